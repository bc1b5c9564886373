//! One step of one contact, or of eight: kinematics, rotation of the history, laws, dashpots, energy balance.
//!
//! The kernel of the engine, `granum pair` and `granum impact` all use this one function.

use granum_simd::vectors::{add_scaled, cross, dot, keep, scale, select};
use granum_simd::{Mask, Real};

use crate::contact::evaluation::constants::PairConstants;
use crate::contact::evaluation::frame::{ContactFrame, Turn};
use crate::contact::evaluation::set::LawSet;
use crate::contact::law::RelativeSpin;
use crate::contact::law::energy_channel::{LAWS, LawEnergies, SetEnergies};
use crate::contact::law::limits::LAW_CHANNELS;

use crate::contact::evaluation::memory::Memory;

/// Relative position and motion of the grains of a pair.
#[derive(Clone, Copy)]
pub struct PairMotion<R> {
    /// Branch from the centre of i to the nearest image of the centre of j, m.
    pub branch: [R; 3],
    /// Velocity of j relative to i, including the velocity gradient of the cell times the branch vector, m/s.
    pub velocity: [R; 3],
    /// b_i w_i + b_j w_j over D, rad/s: the spins weighted with the lever arms b = R D / (R_i + R_j).
    pub rolling: [R; 3],
    /// (w_i + w_j) / 2, rad/s.
    pub mean_spin: [R; 3],
    /// w_i - w_j, rad/s; not used without a moment law.
    pub relative_spin: [R; 3],
}

/// Forces on the grains of a pair in a step, and the work and losses of that step. Everything is zero where the pair does not
/// touch, except the contributions of an adhesion law, and except `adhesion_broken`, `moment_work`, `moment_loss` and
/// `channels` in the step in which a contact breaks.
#[derive(Clone, Copy)]
pub struct Interaction<R: Real> {
    /// Force on i, dashpots included, N.
    pub force: [R; 3],
    /// The torque of the tangential force is `R_i moment` on i and `R_j moment` on j; N.
    pub moment: [R; 3],
    /// Additional couple on i, dashpots included, N m; the opposite couple acts on j.
    pub couple: [R; 3],
    /// Elastic force on i, N.
    pub elastic: [R; 3],
    /// Elastic normal force N, including the force of an adhesion law, N.
    pub normal_force: R,
    /// Radius of the contact area, m.
    pub radius: R,
    /// Normal stiffness, N/m.
    pub normal_stiffness: R,
    /// Tangential stiffness, N/m.
    pub tangential_stiffness: R,
    /// Stiffness that limits the time step, as a tangential stiffness, N/m.
    pub step_stiffness: R,
    /// Where the pair touches.
    pub touching: R::Mask,
    /// Where an adhesion law acts.
    pub attracting: R::Mask,
    /// Energy lost in this step where the attraction of an adhesion law begins or ends, J.
    pub attraction_loss: R,
    /// Where the tangential force is at the friction limit.
    pub sliding: R::Mask,
    /// Work of the elastic tangential force in this step, positive where energy is absorbed, J.
    pub tangential_work: R,
    /// Energy lost to sliding in this step, J.
    pub friction_loss: R,
    /// Energy lost in this step without sliding, J; where `discards` is set, [`crate::contact::TangentialLaw::discarded`] has to be
    /// added.
    pub micro_slip_loss: R,
    /// Where the tangential law discarded a part of its history.
    pub discards: R::Mask,
    /// Energy lost in the dashpots in this step, J.
    pub damping_loss: R,
    /// Energy lost by the formation of a contact in this step, J.
    pub adhesion_made: R,
    /// Energy lost by the breaking of a contact in this step, J.
    pub adhesion_broken: R,
    /// Work of the elastic couple in this step, positive where energy is absorbed, J.
    pub moment_work: R,
    /// The part of it that was dissipated, J.
    pub moment_loss: R,
    /// Energies in the channels of the normal, the tangential, the moment and the adhesion law in this step, J.
    pub channels: SetEnergies<R>,
}

/// Below this value of `1 - m.n` the middle normal is computed from a series, which is exact to the last bits.
const SMALL_TILT: f64 = 1e-3;

/// `1 / |m + n|` of two unit vectors, from `1 - m.n`.
#[inline(always)]
fn inverse_of_sum<R: Real>(tilt: R) -> R {
    // 1/2 (1 - tilt/2)^(-1/2).
    let square = tilt * tilt;
    let high = R::splat(5.0 / 256.0).mul_add(tilt, R::splat(3.0 / 64.0));
    let high = R::splat(35.0 / 4096.0).mul_add(square, high);
    let series = square.mul_add(high, R::splat(0.125).mul_add(tilt, R::splat(0.5)));
    let large = tilt.gt(R::splat(SMALL_TILT));
    if !large.any() {
        return series;
    }
    let sum = (R::splat(2.0) - tilt) * R::splat(2.0);
    R::select(large, R::splat(1.0) / sum.sqrt(), series)
}

/// Advances a contact by one step of length `dt`, with positions at its end and velocities at its middle.
///
/// The slip uses the mid-step normal and lever arms whose sum is the distance of the centres; any other choice is not
/// objective: a rigid rotation of a loaded pair would create forces.
#[inline(always)]
pub fn interact<R: Real, S: LawSet<R>>(
    laws: &S,
    constants: &PairConstants<R>,
    kinematics: &PairMotion<R>,
    dt: R,
    memory: &mut Memory<R>,
) -> Interaction<R> {
    let (zero, one, half) = (R::zero(), R::splat(1.0), R::splat(0.5));
    let branch = kinematics.branch;
    // The square root and the reciprocal do not depend on each other.
    let square = dot(branch, branch);
    let distance = square.sqrt();
    let normal = scale(distance * (one / square), branch);
    let overlap = constants.radius_sum - distance;
    // The stored normal is zero where the pair did not touch.
    let cosine = dot(memory.normal, normal);
    let touched = cosine.gt(zero);
    let mut channels = [[zero; LAW_CHANNELS]; LAWS];
    let [of_normal, of_tangential, of_moments, of_adhesion] = &mut channels;
    let (contact, losses) = laws.normal(&constants.normal, overlap, touched, &mut memory.loading, of_normal);
    let touching = contact.touching;

    // A new contact starts in its own contact plane.
    let cosine = R::select(touched, cosine, one);
    let old = select::<R, 3>(touched, memory.normal, normal);
    let inverse = inverse_of_sum(one - cosine);
    let sum = [old[0] + normal[0], old[1] + normal[1], old[2] + normal[2]];
    let middle = scale(inverse, sum);
    let spin = dt * dot(kinematics.mean_spin, sum) * inverse;
    let turn = Turn::new(old, normal, cosine, spin);

    // Velocity of the surface of j relative to that of i.
    let surface = add_scaled(kinematics.velocity, -distance, cross(kinematics.rolling, middle));
    let in_plane = add_scaled(surface, -dot(surface, middle), middle);
    let frame = ContactFrame::new(normal);
    let slip_velocity = frame.components(in_plane);
    let slip = [dt * slip_velocity[0], dt * slip_velocity[1]];
    let (tangential, step_stiffness, before) =
        laws.tangential(&constants.tangential, &contact, slip, &turn, &mut memory.history, of_tangential);

    let work = slip[0].mul_add(before[0] + tangential.force[0], slip[1] * (before[1] + tangential.force[1]));
    let normal_dashpot = constants.damping * contact.root_stiffness;
    let tangential_dashpot = (constants.damping * tangential.root_stiffness).keep(!tangential.sliding);
    let opening = dot(kinematics.velocity, normal);
    // Forces on i: elastic -N n + T, and the dashpots drag i along with j.
    let push = opening.mul_add(normal_dashpot, -contact.force);
    let pull = [
        tangential_dashpot.mul_add(slip_velocity[0], tangential.force[0]),
        tangential_dashpot.mul_add(slip_velocity[1], tangential.force[1]),
    ];
    // The cross product with the normal maps the first axis of the frame to the second, and the second to minus the first.
    let arm = distance * constants.inverse_radius_sum;
    let moment = frame.vector([-(arm * pull[1]), arm * pull[0]]);
    let slip_square = slip_velocity[0].mul_add(slip_velocity[0], slip_velocity[1] * slip_velocity[1]);
    let mut damping_power = normal_dashpot.mul_add(opening * opening, tangential_dashpot * slip_square);

    let mut moments = Moments { couple: [zero; 3], work: zero, loss: zero, step_stiffness };
    if S::MAY_HAVE_MOMENTS && laws.has_moments() {
        let plane = Plane { normal, middle, frame: &frame, turn: &turn };
        let (found, power) = resist(laws, constants, &contact, kinematics, plane, dt, memory, of_moments);
        let step_stiffness = step_stiffness.max(found.step_stiffness);
        moments = Moments { step_stiffness, ..found };
        damping_power = damping_power + power;
    }

    if S::MAY_HAVE_CHANNELS && laws.has_channels() {
        let ending = touching | touched;
        let counts = laws.channels();
        let laws = [(of_normal, ending), (of_tangential, touching), (of_moments, ending)];
        for ((energies, mask), count) in laws.into_iter().zip(counts) {
            for (k, energy) in energies.iter_mut().enumerate() {
                if k < count {
                    *energy = energy.keep(mask);
                }
            }
        }
    }
    memory.normal = keep::<R, 3>(touching, normal);
    let found = Interaction {
        force: keep::<R, 3>(touching, add_scaled(frame.vector(pull), push, normal)),
        moment: keep::<R, 3>(touching, moment),
        couple: keep::<R, 3>(touching, moments.couple),
        elastic: keep::<R, 3>(touching, add_scaled(frame.vector(tangential.force), -contact.force, normal)),
        normal_force: contact.force.keep(touching),
        radius: contact.radius.keep(touching),
        normal_stiffness: contact.stiffness.keep(touching),
        tangential_stiffness: tangential.stiffness.keep(touching),
        step_stiffness: moments.step_stiffness.keep(touching),
        touching,
        attracting: granum_simd::Mask::splat(false),
        attraction_loss: zero,
        sliding: tangential.sliding & touching,
        tangential_work: (half * work).keep(touching),
        friction_loss: tangential.friction_loss.keep(touching),
        micro_slip_loss: tangential.micro_slip_loss.keep(touching),
        discards: tangential.discards & touching,
        damping_loss: (dt * damping_power).keep(touching),
        adhesion_made: losses.made.keep(touching & !touched),
        adhesion_broken: losses.broken.keep(touched & !touching),
        // The energy still stored in a contact that breaks is lost.
        moment_work: moments.work.keep(touching | touched),
        moment_loss: moments.loss.keep(touching | touched),
        channels: [[zero; LAW_CHANNELS]; LAWS],
    };
    let mut out = found;
    if S::MAY_HAVE_ADHESION && laws.has_adhesion() {
        out = attract(laws, constants, normal, overlap, memory, found, of_adhesion);
    }
    Interaction { channels, ..out }
}

/// For the time step a third of a normal stiffness counts as a tangential stiffness: above it the spinning of the grains is their
/// fastest mode of oscillation.
const THIRD: f64 = 1.0 / 3.0;

/// Adds the force and the loss of the adhesion law.
#[inline(always)]
fn attract<R: Real, S: LawSet<R>>(
    laws: &S,
    constants: &PairConstants<R>,
    normal: [R; 3],
    overlap: R,
    memory: &mut Memory<R>,
    contact: Interaction<R>,
    energies: &mut LawEnergies<R>,
) -> Interaction<R> {
    let found = laws.adhesion(&constants.adhesion, overlap, contact.touching, &mut memory.adhesion, energies);
    let force = found.force.keep(found.acting);
    let step_stiffness = R::splat(THIRD).mul_add(found.stiffness.keep(found.acting), contact.step_stiffness);
    Interaction {
        force: add_scaled(contact.force, force, normal),
        elastic: add_scaled(contact.elastic, force, normal),
        normal_force: contact.normal_force - force,
        step_stiffness,
        attracting: found.acting,
        attraction_loss: found.loss,
        ..contact
    }
}

/// The contact plane of a step.
struct Plane<'a, R> {
    normal: [R; 3],
    /// Normal of the middle of the step.
    middle: [R; 3],
    frame: &'a ContactFrame<R>,
    turn: &'a Turn<R>,
}

/// Effect of a moment law in a step.
struct Moments<R> {
    /// Couple on i, dashpot included, N m.
    couple: [R; 3],
    work: R,
    loss: R,
    step_stiffness: R,
}

/// A step of the moment law, and the power dissipated by its dashpot.
#[inline(always)]
fn resist<R: Real, S: LawSet<R>>(
    laws: &S,
    constants: &PairConstants<R>,
    contact: &crate::contact::Normal<R>,
    kinematics: &PairMotion<R>,
    Plane { normal, middle, frame, turn }: Plane<'_, R>,
    dt: R,
    memory: &mut Memory<R>,
    energies: &mut LawEnergies<R>,
) -> (Moments<R>, R) {
    let twisting = dot(kinematics.relative_spin, middle);
    let [x, y] = frame.components(add_scaled(kinematics.relative_spin, -twisting, middle));
    let spin = RelativeSpin { rolling: [x, y], twisting };
    let found = laws.moment(&constants.rolling, contact, spin, dt, turn, &mut memory.moments, energies);
    let [a, b, c] = found.couple;
    let [rolling_x, rolling_y] = [found.dashpot.mul_add(x, a), found.dashpot.mul_add(y, b)];
    let about_normal = found.twisting_dashpot.mul_add(twisting, c);
    let on_j = add_scaled(frame.vector([rolling_x, rolling_y]), about_normal, normal);
    let moments = Moments {
        couple: [-on_j[0], -on_j[1], -on_j[2]],
        work: found.work,
        loss: found.loss,
        step_stiffness: found.step_stiffness,
    };
    let rolling_power = found.dashpot * x.mul_add(x, y * y);
    (moments, found.twisting_dashpot.mul_add(twisting * twisting, rolling_power))
}
