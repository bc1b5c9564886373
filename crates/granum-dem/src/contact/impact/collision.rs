//! Collision of two equal grains: restitution, rebound of the contact point, spin.
//!
//! Grain j collides with grain i, which is at rest. The equations of motion of both are integrated as in the engine: each
//! step is a kick, a drift, and the interaction with the positions at its end and the velocities at its middle; the kicks
//! are split into two halves so that velocities are also known at the ends. The collision begins at the instant of first
//! contact, with the force that the law gives there, and ends exactly at the instant of separation.

use granum_simd::{Isa, Kernel, Lanes, dispatch, mul_add};
use serde::{Deserialize, Serialize};

use crate::contact::choice::check::check;
use crate::contact::choice::contact_model::ContactModel;
use crate::contact::choice::law_error::LawError;
use crate::contact::evaluation::constants::PairConstants;
use crate::contact::evaluation::interaction::{PairMotion, interact};
use crate::contact::evaluation::memory::Memory;
use crate::contact::law::pair_properties::PairProperties;
use crate::contact::slot::columns::One;
use crate::contact::slot::slots::{Open, Slots};
use crate::material::Material;
use granum_simd::vectors::{add_scaled, cross, dot, scale};

/// Outcome of a collision. Tangential velocities are those of the contact point of j relative to that of i, spin included.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Impact {
    /// Speed of j relative to i before the collision, m/s.
    pub speed: f64,
    /// Angle between this velocity and the line of centres, degrees; 0 is head-on.
    pub angle_deg: f64,
    /// Approach velocity along the line of centres before the collision, m/s.
    pub normal_velocity_in: f64,
    /// Tangential velocity before the collision, m/s.
    pub tangential_velocity_in: f64,
    /// Separation velocity along the line of centres after the collision, m/s; zero where the grains stick.
    pub normal_velocity_out: f64,
    /// Tangential velocity after the collision, m/s, with the sign convention of the incoming one; zero where the grains
    /// stick.
    pub tangential_velocity_out: f64,
    /// Spin of each grain after the collision, rad/s, positive in the sense of the friction during the approach; zero where
    /// the grains stick.
    pub spin_out: f64,
    /// `normal_velocity_out / normal_velocity_in`; zero where the grains stick.
    pub restitution: f64,
    /// `2 (1 - nu) / (mu (2 - nu))` times `tangential_velocity_in / normal_velocity_in` (Maw, Barber and Fawcett 1976); zero
    /// without friction.
    pub psi1: f64,
    /// The same with `tangential_velocity_out`.
    pub psi2: f64,
    /// Time from first contact to separation, s; infinite where the grains stick.
    pub contact_time: f64,
    /// Time step of the reported result, s.
    pub time_step: f64,
    /// True where the grains stay together.
    pub sticks: bool,
    /// Remaining change of the velocities with the time step, relative to the approach velocity. It exceeds 1e-5 only where
    /// the grains barely separate (the bond oscillates many times, and every oscillation amplifies the earlier errors) or barely
    /// touch (the overlap is lost in the rounding of the distance of the centres), and is infinite where even the outcome,
    /// separation or sticking, changes.
    pub uncertainty: f64,
}

/// Reasons why a collision cannot be computed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ImpactError {
    /// The laws cannot be combined.
    #[error(transparent)]
    Law(#[from] LawError),
    /// The speed is out of range.
    #[error("speed is {0} m/s; it must be positive and small compared with the speed of sound, e.g. 0.1")]
    Speed(f64),
    /// The angle is out of range.
    #[error("angle is {0} degrees; it must be at least 0 (head-on) and less than 90 (grazing)")]
    Angle(f64),
}

/// Initial number of steps per characteristic time of the contact.
const FIRST_STEPS: usize = 1000;
/// Largest number of steps per characteristic time, after repeated doubling.
const MOST_STEPS: usize = FIRST_STEPS << 8;
/// Above this uncertainty of the velocities, relative to the approach velocity, a warning is due.
pub const AGREEMENT: f64 = 1e-5;
/// The time step is no longer halved when two extrapolations differ by less than this, relative to the approach velocity.
const CONVERGED: f64 = 1e-9;
/// Largest fraction of the remaining distance to separation that a step covers, times `FIRST_STEPS` over the number of steps
/// per characteristic time: an adhesive force has an infinite slope there.
const LAST_WAY: f64 = 0.02;
/// Number of characteristic times after which grains that have not separated count as sticking.
const PATIENCE: f64 = 200.0;

/// Computes the collision of two equal grains of a given diameter, m, at a speed of j relative to i, m/s, and an angle,
/// degrees.
///
/// The time step is a fraction of the shorter of Hertz's contact time and of the period of the adhesive bond, initially
/// `1/1000`. It is halved, and the results are extrapolated to zero step (friction has an error of first order in the step,
/// the motion one of second order), until two extrapolations of the velocities agree within 1e-9 of the approach velocity or
/// the fraction has reached 1/256000. The result that changed least is returned, and its change is [`Impact::uncertainty`].
pub fn collide(
    contact: &ContactModel,
    material: &Material,
    diameter: f64,
    speed: f64,
    angle_deg: f64,
) -> Result<Impact, ImpactError> {
    check(contact)?;
    if !(speed > 0.0 && speed * speed < 0.1 * material.youngs_modulus / material.density) {
        return Err(ImpactError::Speed(speed));
    }
    if !(0.0..90.0).contains(&angle_deg) {
        return Err(ImpactError::Angle(angle_deg));
    }
    let side = (material, 0.5 * diameter);
    let pair = PairProperties::new(side, side, contact.damping);
    let velocity = speed * libm::cos(angle_deg.to_radians());
    let across = speed * libm::sin(angle_deg.to_radians());
    let mut steps = FIRST_STEPS;
    let mut coarse = run(contact, &pair, velocity, across, steps);
    let mut first_order: Option<Impact> = None;
    let mut last: Option<Impact> = None;
    let mut steadiest: Option<Impact> = None;
    loop {
        steps *= 2;
        let fine = run(contact, &pair, velocity, across, steps);
        let once = extrapolate(&coarse, &fine, 1.0);
        let best = first_order.map(|before| extrapolate(&before, &once, 1.0 / 3.0));
        let change = last.zip(best).map_or(f64::INFINITY, |(a, b)| difference(&a, &b) / velocity);
        let now = Impact { uncertainty: change, ..best.unwrap_or(once) };
        // With very small steps rounding errors accumulate: the best result is the one that changed least.
        let kept = steadiest.filter(|kept| kept.uncertainty < change).unwrap_or(now);
        if kept.uncertainty < CONVERGED || steps >= MOST_STEPS {
            let rounding =
                f64::EPSILON * pair.radius_sum / (velocity * duration(contact, &pair, velocity, across));
            let kept = Impact { uncertainty: kept.uncertainty.max(rounding), ..kept };
            return Ok(describe(kept, &pair, material, speed, angle_deg));
        }
        steadiest = Some(kept);
        (coarse, first_order, last) = (fine, Some(once), best);
    }
}

/// Romberg's extrapolation to zero time step from two results, the second with half the step of the first:
/// `fine + factor (fine - coarse)` removes an error of first order with a factor of 1, and one of second order with 1/3.
fn extrapolate(coarse: &Impact, fine: &Impact, factor: f64) -> Impact {
    if coarse.sticks || fine.sticks {
        return *fine;
    }
    let limit = |value: fn(&Impact) -> f64| value(fine) + factor * (value(fine) - value(coarse));
    Impact {
        normal_velocity_out: limit(|i| i.normal_velocity_out),
        tangential_velocity_out: limit(|i| i.tangential_velocity_out),
        spin_out: limit(|i| i.spin_out),
        contact_time: limit(|i| i.contact_time),
        ..*fine
    }
}

/// Largest difference of the velocities after the collision, m/s; infinite if the grains stick in only one of the two.
fn difference(a: &Impact, b: &Impact) -> f64 {
    if a.sticks != b.sticks {
        return f64::INFINITY;
    }
    let normal = (a.normal_velocity_out - b.normal_velocity_out).abs();
    normal.max((a.tangential_velocity_out - b.tangential_velocity_out).abs())
}

fn describe(raw: Impact, pair: &PairProperties, material: &Material, speed: f64, angle_deg: f64) -> Impact {
    let nu = material.poissons_ratio;
    let factor = 2.0 * (1.0 - nu) / (pair.friction * (2.0 - nu));
    let psi =
        |velocity: f64| if pair.friction > 0.0 { factor * velocity / raw.normal_velocity_in } else { 0.0 };
    Impact {
        speed,
        angle_deg,
        restitution: raw.normal_velocity_out / raw.normal_velocity_in,
        psi1: psi(raw.tangential_velocity_in),
        psi2: psi(raw.tangential_velocity_out),
        ..raw
    }
}

/// The shorter of the contact time and of the time `(m* d_0 / N_c)^(1/2)` of an adhesive bond, s. Without a contact area the
/// contact time is half the period of the normal spring, otherwise that of Hertz.
fn characteristic_time(contact: &ContactModel, pair: &PairProperties, velocity: f64) -> f64 {
    let (mass, radius, modulus) = (pair.effective_mass, pair.effective_radius, pair.effective_modulus);
    let normal = contact.normal.law().traits();
    if !normal.contact_area {
        let [stiffness, _] = contact.stiffness_under(pair, velocity * velocity * mass / pair.radius_sum);
        return std::f64::consts::PI * (mass / stiffness).sqrt();
    }
    let hertz = 2.868 * libm::pow(mass * mass / (radius * modulus * modulus * velocity), 0.2);
    if pair.interface_energy == 0.0 {
        return hertz;
    }
    let force = 1.5 * std::f64::consts::PI * pair.interface_energy * radius;
    let length = libm::pow(3.0 * force / modulus, 2.0 / 3.0) / libm::cbrt(radius);
    hertz.min((mass * length / force).sqrt())
}

/// The characteristic time, s, or the time `2 D v_n / v_t^2` after which grains that only graze each other have passed, if that is
/// shorter.
fn duration(contact: &ContactModel, pair: &PairProperties, velocity: f64, across: f64) -> f64 {
    let time = characteristic_time(contact, pair, velocity);
    let constants = contact.constants(pair);
    // Grains that attract each other do not pass.
    let attracts = contact.breaking_overlap(&constants) < 0.0 || contact.range(&constants) > 0.0;
    if attracts { time } else { time.min(2.0 * pair.radius_sum * velocity / (across * across)) }
}

/// One collision with a time step of the characteristic time over `steps`.
pub(super) fn run(
    contact: &ContactModel,
    pair: &PairProperties,
    velocity: f64,
    across: f64,
    steps: usize,
) -> Impact {
    let time = characteristic_time(contact, pair, velocity);
    let time_step = duration(contact, pair, velocity, across) / steps as f64;
    let constants = contact.constants(pair);
    // Attraction beyond touch is left at the speed of the rebound, which may be a small part of that before.
    let patience = PATIENCE * (time + contact.range(&constants) / velocity);
    let given = Collide { pair, velocity, across, steps, time_step, patience };
    // A bridge may hold grains that do not touch any more.
    let separation = contact.breaking_overlap(&constants).min(-contact.range(&constants));
    let isa = Isa::detect();
    dispatch(
        isa,
        Motion { given, constants, separation, contact, laws: Open::new(&Slots::new(contact, isa)) },
    )
}

struct Collide<'a> {
    pair: &'a PairProperties,
    velocity: f64,
    across: f64,
    steps: usize,
    time_step: f64,
    patience: f64,
}

/// The motion in scalar arithmetic, compiled for the fused operations of the processor.
struct Motion<'a> {
    given: Collide<'a>,
    constants: PairConstants<f64>,
    separation: f64,
    contact: &'a ContactModel,
    laws: Open<'a, One>,
}

/// The variables of motion: the branch vector from i to j, the velocity of j relative to i, and the common spin of both
/// grains.
#[derive(Clone, Copy)]
struct Relative {
    branch: [f64; 3],
    velocity: [f64; 3],
    spin: [f64; 3],
}

impl Kernel for Motion<'_> {
    type Output = Impact;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Impact {
        let Collide { pair, velocity, across, steps, time_step, patience } = self.given;
        let last_way = LAST_WAY * FIRST_STEPS as f64 / steps as f64;
        let normal = [1.0, 2.0, 3.0].map(|x| x / 14f64.sqrt());
        let along = [4.0, 1.0, -2.0].map(|x| x / 21f64.sqrt());
        let radius = 0.5 * pair.radius_sum;
        // The mass of each grain is twice the effective mass; by symmetry friction gives both the same spin.
        let per_inertia = radius / (0.4 * 2.0 * pair.effective_mass * radius * radius);
        let mut state = Relative {
            branch: scale(pair.radius_sum, normal),
            velocity: add_scaled(scale(-velocity, normal), across, along),
            spin: [0.0; 3],
        };
        let mut result = Impact {
            normal_velocity_in: velocity,
            tangential_velocity_in: across,
            time_step,
            contact_time: f64::INFINITY,
            sticks: true,
            ..Impact::default()
        };
        // The force at the instant of first contact, where adhesion acts at once.
        let first = self.contact.normal_contact(&self.constants, pair.radius_sum * 1e-15);
        let opening = self.constants.damping * first.root_stiffness * -velocity;
        let [bridge, _] = self.contact.adhesion.law().at_touch(&self.constants.adhesion);
        let mut pull = scale(opening - first.force + bridge, normal);
        let mut moment = [0.0; 3];
        // Slightly before the separation, so that the force there still acts: adhesion, or a dashpot whose spring does not
        // soften.
        let inside = if first.radius > 0.0 { 0.0 } else { pair.radius_sum * 1e-14 };
        let edge = pair.radius_sum - self.separation * (1.0 - 1e-9) - inside;
        let mut memory = Memory::<f64>::new();
        self.contact.wet(&self.constants, 0.0, &mut memory);
        let mut time = 0.0;
        let mut opened = false;
        while time < patience {
            let half = |state: &Relative, pull: [f64; 3], moment: [f64; 3], dt: f64| Relative {
                branch: state.branch,
                velocity: add_scaled(state.velocity, -0.5 * dt / pair.effective_mass, pull),
                spin: add_scaled(state.spin, 0.5 * dt * per_inertia, moment),
            };
            let mut dt = time_step.min(last_way * self.time_to_separation(&state, edge));
            let mut middle = half(&state, pull, moment, dt);
            let mut last = false;
            // A step that would pass the separation is shortened to end on it; since the kick depends on its length, this is
            // done twice.
            for _ in 0..2 {
                let cut = time_to_distance(&middle, edge);
                if cut <= dt {
                    last = true;
                    dt = cut;
                    middle = half(&state, pull, moment, dt);
                }
            }
            let branch = add_scaled(middle.branch, dt, middle.velocity);
            let kinematics = PairMotion {
                branch,
                velocity: middle.velocity,
                rolling: middle.spin,
                mean_spin: middle.spin,
                relative_spin: [0.0; 3],
            };
            let out = interact(&self.laws, &self.constants, &kinematics, dt, &mut memory);
            (pull, moment) = (out.force, out.moment);
            state = half(&Relative { branch, ..middle }, pull, moment, dt);
            time += dt;
            let closing = -dot(state.velocity, state.branch);
            if last || !(out.touching || out.attracting) {
                let distance = dot(state.branch, state.branch).sqrt();
                let normal = scale(1.0 / distance, state.branch);
                // Directions at separation: the pair has rotated a little.
                let side = cross(normal, along);
                let along = cross(side, normal);
                let along = scale(1.0 / dot(along, along).sqrt(), along);
                let surface = add_scaled(state.velocity, -distance, cross(state.spin, normal));
                result.normal_velocity_out = dot(state.velocity, normal);
                result.tangential_velocity_out = dot(surface, along);
                result.spin_out = dot(state.spin, cross(normal, along));
                result.contact_time = time;
                result.sticks = false;
                break;
            }
            // A pair that closes again after it began to open no longer has the energy to separate.
            if closing > 0.0 && opened {
                break;
            }
            opened |= closing < 0.0;
        }
        result
    }
}

impl Motion<'_> {
    /// Time until grains whose bond is being stretched separate, s; infinite while they approach, or without adhesion.
    #[inline(always)]
    fn time_to_separation(&self, state: &Relative, edge: f64) -> f64 {
        let distance = dot(state.branch, state.branch).sqrt();
        let opening = dot(state.branch, state.velocity) / distance;
        if self.separation == 0.0 || opening <= 0.0 {
            return f64::INFINITY;
        }
        // The lower bound makes sure that the separation is reached.
        (edge - distance).max(-1e-6 * self.separation) / opening
    }
}

/// Time until the centres, at their present velocity, are at a given distance from each other; infinite if never.
#[inline(always)]
fn time_to_distance(state: &Relative, distance: f64) -> f64 {
    let speed = dot(state.velocity, state.velocity);
    let along = dot(state.branch, state.velocity);
    let within = mul_add(distance, distance, -dot(state.branch, state.branch));
    if speed == 0.0 || along <= 0.0 {
        return f64::INFINITY;
    }
    // Root of speed t^2 + 2 along t - within = 0.
    let root = (along * along + speed * within).max(0.0).sqrt();
    (within / (along + root)).max(0.0)
}
