//! Grain-steps per second of the engine.

use std::time::Instant;

use granum_dem::Isa;
use granum_dem::config::{ContactModel, Material, NormalKind, TangentialKind};
use granum_dem::servo::CellControl;
use granum_dem::simulation::{Hardware, Properties, Simulation};
use granum_io::{Case, Packing};
use granum_run::laboratory::{cell, memory, spheres};
use serde::Serialize;

use super::arithmetic::rounds_per_second;
use crate::context::Context;
use crate::failure::Failure;
use crate::output;

/// Smallest number of steps for a measurement, so that rebuilds of the neighbour list contribute with their usual share.
const FEWEST_STEPS: u64 = 400;
/// A measurement with that many steps may take at most this many times the requested time.
const PATIENCE: f64 = 6.0;
/// Fraction of critical damping, as in a test.
const DAMPING: f64 = 0.1;
/// Fewest contacts a grain of a packing that carries load, and the smallest share of those at the beginning of a measurement that is
/// left at its end.
const FEWEST_CONTACTS: f64 = 0.5;
const LEAST_CONTACTS: f64 = 0.5;
/// Smallest mean stress at the end of a measurement over that at its beginning: below, the packing has lost its load.
const LEAST_STRESS: f64 = 0.1;
/// Inertial number and mean stress, Pa, of the shear.
const INERTIAL_NUMBER: f64 = 1e-3;
const MEAN_STRESS: f64 = 20e3;

/// A set of contact laws.
#[derive(Clone, Copy)]
pub struct Law(ContactModel);

impl Law {
    /// Name of the rolling law, if there is one.
    fn rolling(self) -> Option<&'static str> {
        self.0.rolling.law().acts().then(|| self.0.rolling.name())
    }

    /// Name of the law of adhesion, if there is one.
    fn adhesion(self) -> Option<&'static str> {
        self.0.adhesion.law().acts().then(|| self.0.adhesion.name())
    }
}

/// The three sets of contact laws for which the speed is compared with that of other programs.
pub const LAWS: [Law; 3] = [
    Law(ContactModel::new(NormalKind::HERTZ, TangentialKind::NO_SLIP, DAMPING)),
    Law(ContactModel::new(NormalKind::HERTZ, TangentialKind::MINDLIN_DERESIEWICZ, DAMPING)),
    Law(ContactModel::new(NormalKind::JKR, TangentialKind::MINDLIN_DERESIEWICZ, DAMPING)),
];

/// The set of contact laws with the given names, separated by commas.
pub fn law(text: &str) -> Result<Law, Failure> {
    let names: Vec<&str> = text.split(',').collect();
    if !(2..=4).contains(&names.len()) {
        return Err(Failure::new(format!(
            "--law {text}: two to four names are needed, as jkr,mindlin-deresiewicz, hertz,no-slip,elastic-plastic or \
             hertz,no-slip,none,capillary-bridge"
        )));
    }
    let mut case = Case::default();
    let keys = ["contact.normal", "contact.tangential", "contact.rolling", "contact.adhesion"];
    for (key, name) in keys.into_iter().zip(names) {
        case.set(key, name)?;
    }
    case.check()?;
    case.contact.damping = DAMPING;
    Ok(Law(case.contact))
}

/// Settings of the measurements.
pub struct Measurement {
    pub laws: Vec<Law>,
    pub grains: Vec<usize>,
    pub threads: Vec<usize>,
    pub isa: Isa,
    /// True to measure the other instruction sets as well, for the last law at the first size.
    pub others: bool,
    pub seconds: f64,
    /// A single segment of given steps instead of the best of several.
    pub segment: Option<Segment>,
    pub time_step: Option<f64>,
    pub strain_rate: Option<f64>,
}

/// A fixed range of steps that is measured once, so that other programs can be measured on the same steps.
#[derive(Clone, Copy)]
pub struct Segment {
    /// Number of steps before the measurement.
    pub skipped: u64,
    /// Number of measured steps.
    pub steps: u64,
}

/// The result of one measurement.
#[derive(Serialize)]
pub struct Figure {
    normal: &'static str,
    tangential: &'static str,
    /// Name of the rolling law, if there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    rolling: Option<&'static str>,
    /// Name of the law of adhesion, if there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    adhesion: Option<&'static str>,
    grains: usize,
    threads: usize,
    isa: &'static str,
    /// Speed in the fastest segment.
    grain_steps_per_second: f64,
    /// Mean speed over all segments: the sum of their steps over the sum of their times.
    mean_grain_steps_per_second: f64,
    /// Speed relative to that with the first number of threads.
    speed_up: f64,
    /// The same ratio for arithmetic in registers, measured between the segments.
    arithmetic_speed_up: Option<f64>,
    steps: u64,
    #[serde(flatten)]
    load: Load,
}

/// The load of the packing at the end of a measurement.
#[derive(Clone, Copy, Serialize)]
struct Load {
    /// Number of contacts over that of grains.
    contacts_per_grain: f64,
    /// Mean stress, Pa.
    mean_stress: f64,
}

impl Load {
    fn measure(simulation: &Simulation) -> Load {
        let state = simulation.state();
        Load {
            contacts_per_grain: state.contacts() as f64 / state.grains() as f64,
            mean_stress: state.mean_stress(),
        }
    }

    /// Refuses a packing that has lost its load: grains that do not touch cost hardly anything, so that its speed says nothing.
    fn check(self, before: Load) -> Result<Load, Failure> {
        let Load { contacts_per_grain: contacts, mean_stress: stress } = self;
        let (loose, unloaded) = (
            contacts < FEWEST_CONTACTS.max(LEAST_CONTACTS * before.contacts_per_grain),
            before.mean_stress > 0.0 && stress < LEAST_STRESS * before.mean_stress,
        );
        if !loose && !unloaded {
            return Ok(self);
        }
        Err(Failure::new(format!(
            "the packing has lost its load under the shear: {contacts:.2} contacts a grain at {stress:.0} Pa (at the beginning \
             {:.2} at {:.0} Pa), and a speed without contacts means nothing; at least {FEWEST_CONTACTS} contacts a grain, and of the \
             first contacts and stress a share of {LEAST_CONTACTS} and {LEAST_STRESS}, are needed. Give a denser packing, or one that \
             is at rest under a larger stress",
            before.contacts_per_grain, before.mean_stress
        )))
    }
}

/// Measures all figures and prints each at once. All laws are measured at the first size, and the last law at the others.
pub fn measure(
    context: &Context,
    packing: &Packing,
    measurement: &Measurement,
) -> Result<Vec<Figure>, Failure> {
    for &size in &measurement.grains {
        check_memory(size)?;
        check_size(size, packing.grains.len())?;
    }
    let mut figures = Vec::new();
    if !context.json {
        output::line(&format!(
            "{:<7} {:<20} {:>9} {:>8} {:>9} {:>14} {:>10} {:>18} {:>9} {:>9} {:>14}",
            "normal",
            "tangential",
            "grains",
            "threads",
            "isa",
            "contacts/grain",
            "stress, Pa",
            "M grain-steps/s",
            "mean",
            "speed-up",
            "arithmetic's"
        ))?;
    }
    let mut take = |law: Law, packing: &Packing, hardware: &[Hardware]| -> Result<(), Failure> {
        let taken = self::figures(context, law, packing, hardware, measurement)?;
        if !context.json {
            for (k, figure) in taken.iter().enumerate() {
                print(figure, k > 0)?;
            }
        }
        figures.extend(taken);
        Ok(())
    };
    for (k, &size) in measurement.grains.iter().enumerate() {
        let packing = enlarged(packing, size)?;
        let laws =
            if k == 0 { &measurement.laws[..] } else { &measurement.laws[measurement.laws.len() - 1..] };
        for &law in laws {
            let hardware = |&threads| Hardware { threads, isa: measurement.isa };
            take(law, &packing, &measurement.threads.iter().map(hardware).collect::<Vec<_>>())?;
        }
        if k == 0 && measurement.others {
            let law = measurement.laws[measurement.laws.len() - 1];
            for isa in Isa::ALL.into_iter().filter(|isa| isa.available() && *isa != measurement.isa) {
                take(law, &packing, &[Hardware { threads: 1, isa }])?;
            }
        }
    }
    Ok(figures)
}

fn print(figure: &Figure, compared: bool) -> Result<(), Failure> {
    let Figure { normal, tangential, grains, threads, isa, .. } = figure;
    let (rate, mean) = (figure.grain_steps_per_second / 1e6, figure.mean_grain_steps_per_second / 1e6);
    let speed_up = if compared {
        let arithmetic = figure.arithmetic_speed_up.map_or("-".into(), |speed_up| format!("{speed_up:.2}"));
        format!("{:>9.2} {arithmetic:>14}", figure.speed_up)
    } else {
        String::new()
    };
    let others = [figure.rolling, figure.adhesion].into_iter().flatten();
    let beside = others.fold(tangential.to_string(), |names, name| format!("{names}, {name}"));
    let Load { contacts_per_grain, mean_stress } = figure.load;
    output::line(&format!(
        "{normal:<7} {beside:<20} {grains:>9} {threads:>8} {isa:>9} {contacts_per_grain:>14.2} {mean_stress:>10.3e} {rate:>18.2} \
         {mean:>9.2} {speed_up}"
    ))
}

/// Refuses a size that does not fit into memory.
fn check_memory(grains: usize) -> Result<(), Failure> {
    use granum_run::laboratory::LaboratoryError::Memory;
    memory::check_grains(grains).map_err(|error| match error {
        Memory { needed, available, fitting, .. } => Failure::new(format!(
            "--grains {grains}: up to {needed:.1} GB of memory are needed, and this machine has {available:.1} GB free; at most \
             {fitting} grains fit"
        )),
        other => other.into(),
    })
}

/// Refuses a number of grains that is not a multiple of that of the packing, since another size would be measured.
fn check_size(grains: usize, base: usize) -> Result<(), Failure> {
    if grains > 0 && grains.is_multiple_of(base) {
        return Ok(());
    }
    let below = grains / base * base;
    let near = if below == 0 { base.to_string() } else { format!("{below} or {}", below + base) };
    Err(Failure::new(format!(
        "--grains {grains}: the packing has {base} grains and only whole copies of it are measured, so that a multiple \
         of {base} is needed (here {near}); for another size give a packing of that size, --packing FILE"
    )))
}

/// A sample of so many grains from copies of the packing, with a shape as close to a cube as the number of copies allows.
fn enlarged(packing: &Packing, grains: usize) -> Result<Packing, Failure> {
    let mut copies = grains / packing.grains.len();
    let mut counts = [1usize; 3];
    let mut factor = 2;
    let mut factors = Vec::new();
    while copies > 1 {
        if copies.is_multiple_of(factor) {
            factors.push(factor);
            copies /= factor;
        } else {
            factor += 1;
        }
    }
    for f in factors.into_iter().rev() {
        let shortest = (0..3).min_by_key(|&k| counts[k]).unwrap_or(0);
        counts[shortest] *= f;
    }
    Ok(packing.repeated(counts)?)
}

/// Shears the packing and measures segments of steps; the best counts for each number of threads. In each segment all
/// numbers of threads compute the same steps one after another, so that their ratios are affected neither by differences
/// between steps nor by slow changes of the speed of the computer.
fn figures(
    context: &Context,
    law: Law,
    packing: &Packing,
    hardware: &[Hardware],
    measurement: &Measurement,
) -> Result<Vec<Figure>, Failure> {
    let mut from = sheared(law, packing, measurement)?;
    let before = Load::measure(&from);
    let first = hardware.first().copied().unwrap_or_default();
    from.set_hardware(first);
    if let Some(wanted) = measurement.segment {
        return one_segment(context, law, packing.grains.len(), &from, hardware, wanted);
    }
    let warm = warm_up(context, &mut from, 0.2 * measurement.seconds)?;
    // The time is limited: on slow computers and instruction sets there are fewer steps than a neighbour list lasts.
    let enough = FEWEST_STEPS.min((PATIENCE * measurement.seconds / warm) as u64);
    let steps = enough.max((measurement.seconds / 3.0 / warm) as u64).max(1);
    let mut best = vec![f64::INFINITY; hardware.len()];
    let mut arithmetic = vec![0.0; hardware.len()];
    let mut sums = vec![0.0; hardware.len()];
    let mut made = 0;
    let clock = Instant::now();
    while made == 0 || clock.elapsed().as_secs_f64() < 0.9 * measurement.seconds * hardware.len() as f64 {
        if let ([_], [best], [sum]) = (hardware, &mut best[..], &mut sums[..]) {
            let each = segment(context, &mut from, steps, warm)?;
            *best = best.min(each);
            *sum += each * steps as f64;
            made += steps;
            continue;
        }
        let mut end = None;
        for ((hardware, best), sum) in hardware.iter().zip(&mut best).zip(&mut sums) {
            // At most two simulations exist at a time, because they may be large.
            drop(end.take());
            let mut simulation = from.clone();
            simulation.set_hardware(*hardware);
            let each = segment(context, &mut simulation, steps, warm)?;
            *best = best.min(each);
            *sum += each * steps as f64;
            end = Some(simulation);
        }
        for (hardware, sum) in hardware.iter().zip(&mut arithmetic) {
            *sum += rounds_per_second(*hardware, 0.1 * measurement.seconds);
        }
        made += steps;
        from = end.unwrap_or(from);
    }
    let load = Load::measure(&from).check(before)?;
    let grains = packing.grains.len() as f64;
    let figure = |k: usize| Figure {
        normal: law.0.normal.name(),
        tangential: law.0.tangential.name(),
        rolling: law.rolling(),
        adhesion: law.adhesion(),
        grains: packing.grains.len(),
        threads: hardware[k].threads,
        isa: hardware[k].isa.name(),
        grain_steps_per_second: grains / best[k],
        mean_grain_steps_per_second: grains * made as f64 / sums[k],
        speed_up: best[0] / best[k],
        arithmetic_speed_up: Some(if hardware[k].threads == first.threads {
            1.0
        } else {
            arithmetic[k] / arithmetic[0]
        }),
        steps: made,
        load,
    };
    Ok((0..hardware.len()).map(figure).collect())
}

/// Measures a fixed range of steps once for each number of threads, always starting from the original packing.
fn one_segment(
    context: &Context,
    law: Law,
    grains: usize,
    from: &Simulation,
    hardware: &[Hardware],
    wanted: Segment,
) -> Result<Vec<Figure>, Failure> {
    let mut figures: Vec<Figure> = Vec::new();
    for hardware in hardware {
        let mut simulation = from.clone();
        simulation.set_hardware(*hardware);
        // The speed of the computer is still unknown, and the guess must keep the calls short.
        let guess = 1e-6 * grains as f64;
        let each = match wanted.skipped {
            0 => guess,
            skipped => segment(context, &mut simulation, skipped, guess)?,
        };
        let rate = grains as f64 / segment(context, &mut simulation, wanted.steps, each)?;
        let first = figures.first().map_or(rate, |figure| figure.grain_steps_per_second);
        figures.push(Figure {
            normal: law.0.normal.name(),
            tangential: law.0.tangential.name(),
            rolling: law.rolling(),
            adhesion: law.adhesion(),
            grains,
            threads: hardware.threads,
            isa: hardware.isa.name(),
            grain_steps_per_second: rate,
            mean_grain_steps_per_second: rate,
            speed_up: rate / first,
            // With a single segment there are no pauses in which the arithmetic could be measured.
            arithmetic_speed_up: None,
            steps: wanted.steps,
            load: Load::measure(&simulation).check(Load::measure(from))?,
        });
    }
    Ok(figures)
}

/// A simulation of the packing under shear.
fn sheared(law: Law, packing: &Packing, measurement: &Measurement) -> Result<Simulation, Failure> {
    let properties = Properties::new(Material::default(), law.0);
    let mut simulation = Simulation::new(cell(packing), &spheres(packing), properties)?;
    simulation.fix_time_step(measurement.time_step);
    let rate =
        measurement.strain_rate.unwrap_or_else(|| simulation.strain_rate(INERTIAL_NUMBER, MEAN_STRESS));
    let mut control = CellControl::fixed();
    control.rate[0][0] = rate;
    control.rate[1][1] = -0.5 * rate;
    control.rate[2][2] = -0.5 * rate;
    simulation.set_control(control);
    Ok(simulation)
}

/// Advances for the given number of seconds; returns the time of a step, s.
fn warm_up(context: &Context, simulation: &mut Simulation, seconds: f64) -> Result<f64, Failure> {
    let clock = Instant::now();
    let (mut made, mut next) = (0, 1);
    loop {
        context.check_stopped(|| "nothing was written".into())?;
        simulation.advance(next)?;
        made += next;
        let spent = clock.elapsed().as_secs_f64();
        if spent >= seconds {
            return Ok(spent / made as f64);
        }
        next = ((0.03 * seconds.max(0.1) * made as f64 / spent) as u64).clamp(1, 1000);
    }
}

/// Advances by the given number of steps, which take about `each` seconds each; returns the time of a step, s.
fn segment(context: &Context, simulation: &mut Simulation, steps: u64, each: f64) -> Result<f64, Failure> {
    // Every call starts the threads again, so that calls should be long; but an interruption has to wait for the end of a
    // call.
    let call = ((0.1 / each) as u64).clamp(1, 1000);
    let clock = Instant::now();
    let mut left = steps;
    while left > 0 {
        context.check_stopped(|| "nothing was written".into())?;
        let next = call.min(left);
        simulation.advance(next)?;
        left -= next;
    }
    Ok(clock.elapsed().as_secs_f64() / steps as f64)
}
