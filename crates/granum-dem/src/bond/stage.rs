//! The second stage of bonds in a step: eight bonds at a time are strained, judged and loaded. Before it the pieces were turned
//! ([`super::turning`]); the loads are added up as [`super::summing`] says.

use std::ops::Range;

use granum_simd::vectors::{cross, dot};
use granum_simd::{Isa, Kernel, LANES, Lanes, Mask, Row8, dispatch};

use super::bonds::column::{ALIVE, ARMS, COLUMNS, DASHPOTS, FRAMES, LIMIT, STIFFNESS};
use super::guard::RUPTURED;
use super::law::additive::sum_of_ratios;
use super::law::bond_law::{BondLoads, Criterion, LIMITS};
use super::law::kind::BondKind;
use super::law::parallel::stresses_over_strengths;
use super::motion::{Ends, Vectors, in_axes, in_space, strained};
use super::summing::Loads;
use super::views::{BATCHES, BondSums, LOADS};
use crate::kernel::Views;

/// Number of batches between prefetching one and straining its bonds.
const AHEAD: usize = 2;

/// The stage of bonds for a range of blocks of batches. With `DAMPED`, bonds have dashpots, which need the velocities of the pieces. With `ALONE`
/// no other thread works on the stage.
struct BondStage<'a, const DAMPED: bool, const ALONE: bool> {
    views: &'a Views,
    blocks: Range<usize>,
}

impl<const DAMPED: bool, const ALONE: bool> Kernel for BondStage<'_, DAMPED, ALONE> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let v = &self.views.bonds;
        for k in self.blocks {
            let mut totals = Totals::<L>::none();
            for batch in k * BATCHES..usize::min((k + 1) * BATCHES, v.law.len()) {
                if v.far {
                    fetch::<DAMPED, ALONE>(self.views, batch + AHEAD);
                }
                // SAFETY: rows are only read in this stage.
                let rows = unsafe { &v.rows.read()[batch] };
                let loads = one_batch::<L, DAMPED>(self.views, batch, rows, &mut totals);
                // SAFETY: the loads of a batch are written by the thread of its block alone, and forces by one that is alone.
                unsafe {
                    if ALONE {
                        loads.add(self.views, rows);
                    } else {
                        loads.put(v.loads.write(LOADS * batch..LOADS * (batch + 1)));
                    }
                }
            }
            // SAFETY: a block belongs to the thread that works on it.
            unsafe { v.sums.write(k..k + 1)[0] = totals.reduced() };
        }
    }
}

/// Prefetches the numbers of a later batch and its pieces: their rows are near each other in space, but not in memory.
#[inline(always)]
fn fetch<const DAMPED: bool, const ALONE: bool>(v: &Views, batch: usize) {
    // SAFETY: rows are only read in this stage.
    let Some(rows) = (unsafe { v.bonds.rows.read() }).get(batch) else { return };
    for column in 0..LIMIT {
        v.bonds.columns.prefetch(batch * COLUMNS + column);
    }
    v.bonds.guards.prefetch(batch);
    v.bonds.images.prefetch(batch);
    for row in rows.iter().flatten() {
        v.particles.prefetch(*row as usize);
        v.bonds.orientations.prefetch(*row as usize);
        if DAMPED {
            v.spin.prefetch(*row as usize);
        }
        if ALONE {
            v.forces.prefetch(*row as usize);
        }
    }
}

/// Strains, judges and loads the bonds of a range of blocks. Where the thread is `alone`, that is all; where it is not, the loads wait for
/// [`super::BondedStage`].
pub(crate) fn bond_stage(isa: Isa, views: &Views, blocks: Range<usize>, alone: bool) {
    match (views.bonds.damped, alone) {
        (true, true) => dispatch(isa, BondStage::<true, true> { views, blocks }),
        (true, false) => dispatch(isa, BondStage::<true, false> { views, blocks }),
        (false, true) => dispatch(isa, BondStage::<false, true> { views, blocks }),
        (false, false) => dispatch(isa, BondStage::<false, false> { views, blocks }),
    }
}

/// Sums in lanes.
struct Totals<L> {
    virial: [L; 9],
    power: L,
    damping: L,
    broken: [L; 2],
    stiffness: L,
    normal_force: L,
    ruptured: bool,
}

impl<L: Lanes> Totals<L> {
    #[inline(always)]
    fn none() -> Totals<L> {
        let zero = L::zero();
        Totals {
            virial: [zero; 9],
            power: zero,
            damping: zero,
            broken: [zero; 2],
            stiffness: zero,
            normal_force: zero,
            ruptured: false,
        }
    }

    #[inline(always)]
    fn reduced(&self) -> BondSums {
        let mut virial = [0.0; 9];
        for (sum, lanes) in virial.iter_mut().zip(self.virial) {
            *sum = lanes.reduce_add();
        }
        BondSums {
            virial,
            power: self.power.reduce_add(),
            damping: self.damping.reduce_add(),
            broken: [self.broken[0].reduce_add(), self.broken[1].reduce_add()],
            stiffness: self.stiffness.reduce_add(),
            normal_force: self.normal_force.reduce_add(),
            ruptured: self.ruptured,
        }
    }
}

/// The pieces at the ends of a batch of bonds.
struct Pieces<L> {
    ends: Ends<L>,
    /// Velocity of j relative to i, the deformation of the cell included, m/s.
    velocity: Vectors<L>,
    /// Spins, rad/s.
    spins: [Vectors<L>; 2],
    /// Reciprocals of the radii, 1/m.
    curvatures: [L; 2],
    /// From the centre of the body of i to that of the body of j, m.
    branch_of_bodies: Vectors<L>,
}

#[inline(always)]
fn affine<L: Lanes>(v: &Views, x: Vectors<L>) -> Vectors<L> {
    let mut y = [L::zero(); 3];
    for r in 0..3 {
        let [a, b, c] = v.gradient[r];
        y[r] = dot([L::splat(a), L::splat(b), L::splat(c)], x);
    }
    y
}

/// Four columns one after the other.
#[inline(always)]
fn four<L: Lanes>(columns: &[Row8], from: usize) -> [L; 4] {
    [
        L::load(&columns[from].0),
        L::load(&columns[from + 1].0),
        L::load(&columns[from + 2].0),
        L::load(&columns[from + 3].0),
    ]
}

/// A vector where the mask is true, else nothing.
#[inline(always)]
fn keep<L: Lanes>(x: Vectors<L>, mask: L::Mask) -> Vectors<L> {
    [x[0].keep(mask), x[1].keep(mask), x[2].keep(mask)]
}

/// `sqrt(a^2 + b^2)`.
#[inline(always)]
fn magnitude<L: Lanes>(a: L, b: L) -> L {
    a.mul_add(a, b * b).sqrt()
}

/// Whole numbers of edges of the cell.
#[inline(always)]
fn edges<L: Lanes>(whole: &[i32; LANES]) -> L {
    let mut numbers = [0.0; LANES];
    for lane in 0..LANES {
        numbers[lane] = f64::from(whole[lane]);
    }
    L::load(&numbers)
}

/// Loads the pieces of a batch; their velocities and spins only where bonds have dashpots.
#[inline(always)]
fn pieces<L: Lanes, const DAMPED: bool>(
    v: &Views,
    rows: &[[u32; LANES]; 2],
    images: &[[i32; LANES]; 3],
    columns: &[Row8],
) -> Pieces<L> {
    // SAFETY: rows and orientations are only read in this stage.
    let (particles, orientations) = unsafe { (v.particles.read(), v.bonds.orientations.read()) };
    let (a, b) = (L::gather8(particles, &rows[0]), L::gather8(particles, &rows[1]));
    let shift = [edges::<L>(&images[0]), edges::<L>(&images[1]), edges::<L>(&images[2])];
    let (mut branch, mut velocity) = ([L::zero(); 3], [L::zero(); 3]);
    for r in 0..3 {
        let edge = [L::splat(v.edges[r][0]), L::splat(v.edges[r][1]), L::splat(v.edges[r][2])];
        branch[r] = b[r] - a[r] + dot(edge, shift);
    }
    let mut spins = [[L::zero(); 3]; 2];
    if DAMPED {
        let drift = affine(v, branch);
        // SAFETY: spins are only read in this stage.
        let spin = unsafe { v.spin.read() };
        let (wa, wb) = (L::gather4(spin, &rows[0]), L::gather4(spin, &rows[1]));
        for r in 0..3 {
            velocity[r] = b[4 + r] - a[4 + r] + drift[r];
            (spins[0][r], spins[1][r]) = (wa[r], wb[r]);
        }
    }
    let mut branch_of_bodies = branch;
    if v.clump_of.len() > 0 {
        // SAFETY: only read in this stage.
        let arms = unsafe { v.arms.read() };
        let (from, to) = (L::gather4(arms, &rows[0]), L::gather4(arms, &rows[1]));
        for r in 0..3 {
            branch_of_bodies[r] = branch[r] + (from[r] - to[r]);
        }
    }
    let ends = Ends {
        orientations: [L::gather4(orientations, &rows[0]), L::gather4(orientations, &rows[1])],
        frames: [four(columns, FRAMES[0]), four(columns, FRAMES[1])],
        arms: [L::load(&columns[ARMS].0), L::load(&columns[ARMS + 1].0)],
        branch,
    };
    let one = L::splat(1.0);
    Pieces { ends, velocity, spins, curvatures: [one / a[3], one / b[3]], branch_of_bodies }
}

/// Strains and judges the bonds of a batch; returns their loads.
#[inline(always)]
fn one_batch<L: Lanes, const DAMPED: bool>(
    v: &Views,
    batch: usize,
    rows: &[[u32; LANES]; 2],
    totals: &mut Totals<L>,
) -> Loads<L> {
    // SAFETY: the columns of a batch are written by the thread of its block alone.
    let columns = unsafe { v.bonds.columns.write(batch * COLUMNS..(batch + 1) * COLUMNS) };
    // SAFETY: as for the columns.
    let guard = unsafe { &mut v.bonds.guards.write(batch..batch + 1)[0] };
    let least_energy = L::load(&guard.0);
    let alive = least_energy.ge(L::zero());
    if !alive.any() {
        return Loads::none();
    }
    // SAFETY: images are only read in this stage.
    let images = unsafe { &v.bonds.images.read()[batch] };
    let p = pieces::<L, DAMPED>(v, rows, images, columns);
    let s = strained(&p.ends);
    let [normal, shear, bending, twisting] = four::<L>(columns, STIFFNESS);
    let (u, phi) = (s.displacement, s.rotation);
    let force = [normal * u[0], shear * u[1], shear * u[2]];
    let couple = [twisting * phi[0], bending * phi[1], bending * phi[2]];
    let mut holds = alive;
    if (alive & stored(&force, &couple, &u, &phi).ge(least_energy)).any() {
        let ruptured = judge(v, batch, columns, alive, &force, &couple);
        if (ruptured[0] | ruptured[1]).any() {
            let energy = L::splat(0.5) * (dot(force, u) + dot(couple, phi));
            holds = note(v, batch, columns, alive, ruptured, energy, totals);
            L::select(holds, least_energy, L::splat(RUPTURED)).store(&mut guard.0);
        }
    }
    let (mut force, mut couple) = (keep(force, holds), keep(couple, holds));
    let elastic = in_space(&s.axes, &force);
    if DAMPED {
        // SAFETY: dashpots are only read in this stage.
        let dashpots = unsafe { &v.bonds.dashpots.read()[batch * DASHPOTS..(batch + 1) * DASHPOTS] };
        let lost = add_dashpots(dashpots, &p, &s, holds, &mut force, &mut couple);
        totals.damping = L::splat(v.dt).mul_add(lost, totals.damping);
    }
    add_to_totals(v, totals, &elastic, &in_space(&s.axes, &force), &p.branch_of_bodies);
    totals.normal_force = totals.normal_force + (normal * u[0]).abs().keep(holds);
    let square = dot(p.ends.branch, p.ends.branch);
    totals.stiffness = totals.stiffness + (normal * square).keep(holds);
    loads_of(&s.levers, in_space(&s.axes, &force), &in_space(&s.axes, &couple), &p.curvatures)
}

/// The energy that is stored, without that of compression.
#[inline(always)]
fn stored<L: Lanes>(force: &Vectors<L>, couple: &Vectors<L>, u: &Vectors<L>, phi: &Vectors<L>) -> L {
    let stretched = force[0] * u[0].max(L::zero());
    let sheared = force[1].mul_add(u[1], force[2] * u[2]);
    L::splat(0.5) * (stretched + sheared + dot(*couple, *phi))
}

/// Which bonds reach their limits: by tension, and by shear.
#[inline(always)]
fn judge<L: Lanes>(
    v: &Views,
    batch: usize,
    columns: &[Row8],
    alive: L::Mask,
    force: &Vectors<L>,
    couple: &Vectors<L>,
) -> [L::Mask; 2] {
    let loads = [force[0], magnitude(force[1], force[2]), magnitude(couple[1], couple[2]), couple[0].abs()];
    // SAFETY: laws are only read.
    let (law, criteria) = unsafe { (v.bonds.law.read()[batch] as usize, v.bonds.criteria.read()) };
    let [tension, shear] = match criteria[law] {
        Criterion::MohrCoulomb => stresses_over_strengths(loads, six(columns)),
        Criterion::Additive => sum_of_ratios(loads, six(columns)),
        // SAFETY: as above.
        Criterion::OfLaw => asked(unsafe { v.bonds.laws.read()[law] }, loads, columns),
    };
    let one = L::splat(1.0);
    let by_tension = alive & tension.ge(one) & tension.ge(shear);
    [by_tension, alive & shear.ge(one) & !by_tension]
}

/// The constants of the law of rupture.
#[inline(always)]
fn six<L: Lanes>(columns: &[Row8]) -> [L; LIMITS] {
    let mut limits = [L::zero(); LIMITS];
    for k in 0..LIMITS {
        limits[k] = L::load(&columns[LIMIT + k].0);
    }
    limits
}

/// What the law answers.
#[inline(always)]
fn asked<L: Lanes>(kind: BondKind, [tension, shear, bending, twisting]: [L; 4], columns: &[Row8]) -> [L; 2] {
    let mut loads = BondLoads::default();
    tension.store(&mut loads.tension);
    shear.store(&mut loads.shear);
    bending.store(&mut loads.bending);
    twisting.store(&mut loads.twisting);
    let mut limits = [[0.0; LANES]; LIMITS];
    for (limit, column) in limits.iter_mut().zip(&columns[LIMIT..]) {
        *limit = column.0;
    }
    let [tension, shear] = kind.law().utilisation(&loads, &limits);
    [L::load(&tension), L::load(&shear)]
}

/// Notes the bonds that rupture, and returns those that still hold.
#[inline(always)]
fn note<L: Lanes>(
    v: &Views,
    batch: usize,
    columns: &mut [Row8],
    alive: L::Mask,
    [tension, shear]: [L::Mask; 2],
    energy: L,
    totals: &mut Totals<L>,
) -> L::Mask {
    let holds = alive & !(tension | shear);
    L::splat(1.0).keep(holds).store(&mut columns[ALIVE].0);
    totals.broken[0] = totals.broken[0] + energy.keep(tension);
    totals.broken[1] = totals.broken[1] + energy.keep(shear);
    totals.ruptured = true;
    // SAFETY: a batch belongs to the thread of its block.
    let ruptures = unsafe { &mut v.bonds.ruptures.write(batch..batch + 1)[0] };
    (ruptures.tension, ruptures.shear) = (tension.bits() as u8, shear.bits() as u8);
    energy.store(&mut ruptures.energy);
    holds
}

/// Adds the dashpots to force and couple, in the axes of the bonds; returns the power that they take.
#[inline(always)]
fn add_dashpots<L: Lanes>(
    dashpots: &[Row8],
    p: &Pieces<L>,
    s: &super::motion::Strained<L>,
    holds: L::Mask,
    force: &mut Vectors<L>,
    couple: &mut Vectors<L>,
) -> L {
    let [normal, shear, bending, twisting] = four::<L>(dashpots, 0);
    let (normal, shear) = (normal.keep(holds), shear.keep(holds));
    let (bending, twisting) = (bending.keep(holds), twisting.keep(holds));
    let (of_first, of_second) = (cross(p.spins[0], s.levers[0]), cross(p.spins[1], s.levers[1]));
    let (mut apart, mut turning) = (p.velocity, p.spins[1]);
    for k in 0..3 {
        apart[k] = p.velocity[k] + of_second[k] - of_first[k];
        turning[k] = p.spins[1][k] - p.spins[0][k];
    }
    let (rate, turn) = (in_axes(&s.axes, &apart), in_axes(&s.axes, &turning));
    let by_force = [normal * rate[0], shear * rate[1], shear * rate[2]];
    let by_couple = [twisting * turn[0], bending * turn[1], bending * turn[2]];
    for k in 0..3 {
        force[k] = force[k] + by_force[k];
        couple[k] = couple[k] + by_couple[k];
    }
    dot(by_force, rate) + dot(by_couple, turn)
}

/// Adds stress and power of the forces.
#[inline(always)]
fn add_to_totals<L: Lanes>(
    v: &Views,
    totals: &mut Totals<L>,
    elastic: &Vectors<L>,
    force: &Vectors<L>,
    branch: &Vectors<L>,
) {
    for r in 0..3 {
        for c in 0..3 {
            let sum = &mut totals.virial[3 * r + c];
            *sum = (-elastic[r]).mul_add(branch[c], *sum);
        }
    }
    totals.power = totals.power + dot(*force, affine(v, *branch));
}

/// The loads of bonds that carry a force and a couple.
#[inline(always)]
fn loads_of<L: Lanes>(
    levers: &[Vectors<L>; 2],
    force: Vectors<L>,
    couple: &Vectors<L>,
    curvatures: &[L; 2],
) -> Loads<L> {
    let (first, second) = (cross(levers[0], force), cross(levers[1], force));
    let mut torques = [[L::zero(); 3]; 2];
    for k in 0..3 {
        torques[0][k] = (couple[k] + first[k]) * curvatures[0];
        torques[1][k] = -((couple[k] + second[k]) * curvatures[1]);
    }
    Loads { force, torques }
}
