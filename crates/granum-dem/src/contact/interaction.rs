//! One step of one contact, or of eight: kinematics, turning of the history, laws, dashpots, ledger.
//!
//! The kernel of the engine, `granum pair` and `granum impact` all run this one function.

use granum_simd::{Mask, Real};

use super::{MAX_HISTORY, NormalLaw, PairConstants, TangentialLaw};

/// How the grains of a pair stand and move.
#[derive(Clone, Copy)]
pub struct Kinematics<R> {
    /// Branch from the centre of i to the nearest image of the centre of j, m.
    pub branch: [R; 3],
    /// Velocity of j relative to i, the cell's gradient times the branch included, m/s.
    pub velocity: [R; 3],
    /// b_i w_i + b_j w_j over D, rad/s: the spins weighted with the lever arms b = R D / (R_i + R_j).
    pub rolling: [R; 3],
    /// (w_i + w_j) / 2, rad/s.
    pub mean_spin: [R; 3],
}

/// What a contact remembers between steps.
#[derive(Clone, Copy)]
pub struct Memory<R> {
    /// Unit normal at the last step; zero where the pair did not touch.
    pub normal: [R; 3],
    /// The tangential law's own columns.
    pub history: [R; MAX_HISTORY],
}

impl<R: Real> Memory<R> {
    /// A pair that has not touched.
    pub fn new() -> Self {
        Memory { normal: [R::zero(); 3], history: [R::zero(); MAX_HISTORY] }
    }
}

impl<R: Real> Default for Memory<R> {
    fn default() -> Self {
        Memory::new()
    }
}

/// What a contact does to its grains in a step. Everything is zero where the pair does not touch, but for
/// `adhesion_loss`, which falls due just then.
#[derive(Clone, Copy)]
pub struct Interaction<R: Real> {
    /// Force on i, dashpots included, N.
    pub force: [R; 3],
    /// Torque on i is `R_i moment`, on j `R_j moment`; N.
    pub moment: [R; 3],
    /// Elastic force on i, N.
    pub elastic: [R; 3],
    /// Elastic normal force N, N.
    pub normal_force: R,
    /// Radius of the contact area, m.
    pub radius: R,
    /// Normal stiffness, N/m.
    pub normal_stiffness: R,
    /// Tangential stiffness, N/m.
    pub tangential_stiffness: R,
    /// Where the pair touches.
    pub touching: R::Mask,
    /// Where the tangential force stands at the friction limit.
    pub sliding: R::Mask,
    /// Work that the elastic tangential force took up in this step, J.
    pub tangential_work: R,
    /// Lost to sliding in this step, J.
    pub friction_loss: R,
    /// Lost in the dashpots in this step, J.
    pub damping_loss: R,
    /// Lost by breaking in this step, J.
    pub adhesion_loss: R,
}

/// Dot product, in a fixed order of fused operations.
#[inline(always)]
pub fn dot<R: Real>(a: [R; 3], b: [R; 3]) -> R {
    a[0].mul_add(b[0], a[1].mul_add(b[1], a[2] * b[2]))
}

/// Cross product.
#[inline(always)]
pub fn cross<R: Real>(a: [R; 3], b: [R; 3]) -> [R; 3] {
    [
        a[1].mul_add(b[2], -(a[2] * b[1])),
        a[2].mul_add(b[0], -(a[0] * b[2])),
        a[0].mul_add(b[1], -(a[1] * b[0])),
    ]
}

/// `a + s b`.
#[inline(always)]
pub fn add_scaled<R: Real>(a: [R; 3], s: R, b: [R; 3]) -> [R; 3] {
    [s.mul_add(b[0], a[0]), s.mul_add(b[1], a[1]), s.mul_add(b[2], a[2])]
}

/// `s a`.
#[inline(always)]
pub fn scale<R: Real>(s: R, a: [R; 3]) -> [R; 3] {
    [s * a[0], s * a[1], s * a[2]]
}

/// Keeps a vector where the mask is true, else zero.
#[inline(always)]
pub fn keep<R: Real>(mask: R::Mask, a: [R; 3]) -> [R; 3] {
    a.map(|x| x.keep(mask))
}

/// Turns in-plane vectors from the old contact plane into the new one: by the tilt of the normal (exact, norm
/// preserving) and by the mean spin about it.
struct PlaneTurn<R> {
    sum: [R; 3],
    twice_over_square: R,
    sine: R,
    one_minus_cosine: R,
    normal: [R; 3],
}

impl<R: Real> PlaneTurn<R> {
    #[inline(always)]
    fn apply(&self, q: [R; 3]) -> [R; 3] {
        let tilted = add_scaled(q, -(dot(self.normal, q) * self.twice_over_square), self.sum);
        let turned = add_scaled(tilted, self.sine, cross(self.normal, tilted));
        add_scaled(turned, -self.one_minus_cosine, tilted)
    }
}

/// Advances a contact by one step of length `dt`, positions at its end, velocities at its middle.
///
/// The slip uses the mid-step normal and lever arms that sum to the distance of the centres; anything else is not objective: a rigid
/// rotation of a loaded pair would make forces.
#[inline(always)]
pub fn interact<R: Real, N: NormalLaw, T: TangentialLaw>(
    constants: &PairConstants<R>,
    kinematics: &Kinematics<R>,
    dt: R,
    memory: &mut Memory<R>,
) -> Interaction<R> {
    let one = R::splat(1.0);
    let half = R::splat(0.5);
    let branch = kinematics.branch;
    let distance = dot(branch, branch).sqrt();
    let normal = scale(one / distance, branch);
    let approach = constants.radius_sum - distance;
    let touched = dot(memory.normal, memory.normal).gt(half);
    let contact = N::evaluate(&constants.normal, approach, touched);
    let touching = contact.touching;

    // A new contact starts in its own plane.
    let old: [R; 3] = std::array::from_fn(|a| R::select(touched, memory.normal[a], normal[a]));
    let sum: [R; 3] = std::array::from_fn(|a| old[a] + normal[a]);
    let inverse_square = one / dot(sum, sum);
    let middle = scale(inverse_square.sqrt(), sum);
    let psi = dt * dot(kinematics.mean_spin, middle);
    let psi_square = psi * psi;
    let turn = PlaneTurn {
        sum,
        twice_over_square: inverse_square + inverse_square,
        sine: psi * psi_square.mul_add(R::splat(-1.0 / 6.0), one),
        one_minus_cosine: psi_square * psi_square.mul_add(R::splat(-1.0 / 24.0), half),
        normal,
    };
    for v in 0..T::VECTORS {
        let c = 3 * v;
        let turned = turn.apply([memory.history[c], memory.history[c + 1], memory.history[c + 2]]);
        memory.history[c..c + 3].copy_from_slice(&turned);
    }
    let before = T::force(normal, &memory.history);

    // Velocity of the surface of j relative to that of i.
    let surface = add_scaled(kinematics.velocity, -distance, cross(kinematics.rolling, middle));
    let in_plane = add_scaled(surface, -dot(surface, middle), middle);
    let slip_velocity = add_scaled(in_plane, -dot(in_plane, normal), normal);
    let increment = scale(dt, slip_velocity);
    let tangential = T::update(&constants.tangential, &contact, normal, increment, &mut memory.history);

    let mid_force: [R; 3] = std::array::from_fn(|a| half * (before[a] + tangential.force[a]));
    let normal_dashpot = constants.damping * contact.stiffness.sqrt();
    let tangential_dashpot =
        R::select(tangential.sliding, R::zero(), constants.damping * tangential.stiffness.sqrt());
    let opening = dot(kinematics.velocity, normal);
    // On i: elastic -N n + T, and the dashpots pull i along with j.
    let push = opening.mul_add(normal_dashpot, -contact.force);
    let pull = add_scaled(tangential.force, tangential_dashpot, slip_velocity);
    let moment = scale(distance / constants.radius_sum, cross(normal, pull));
    let damping_power =
        normal_dashpot.mul_add(opening * opening, tangential_dashpot * dot(slip_velocity, slip_velocity));

    memory.normal = keep::<R>(touching, normal);
    for c in 0..T::HISTORY {
        memory.history[c] = memory.history[c].keep(touching);
    }
    Interaction {
        force: keep::<R>(touching, add_scaled(pull, push, normal)),
        moment: keep::<R>(touching, moment),
        elastic: keep::<R>(touching, add_scaled(tangential.force, -contact.force, normal)),
        normal_force: contact.force.keep(touching),
        radius: contact.radius.keep(touching),
        normal_stiffness: contact.stiffness.keep(touching),
        tangential_stiffness: tangential.stiffness.keep(touching),
        touching,
        sliding: tangential.sliding & touching,
        tangential_work: dot(mid_force, increment).keep(touching),
        friction_loss: tangential.friction_loss.keep(touching),
        damping_loss: (dt * damping_power).keep(touching),
        adhesion_loss: N::breaking_loss(&constants.normal).keep(touched & !touching),
    }
}

/// True where any lane of the mask is set; a name for readers of the kernel.
#[inline(always)]
pub fn any<R: Real>(mask: R::Mask) -> bool {
    mask.any()
}
