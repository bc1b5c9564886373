//! Quality checks of a run: measures are compared with thresholds, with advice on what to change if one is exceeded.

use granum_core::assembly::Assembly;
use granum_dem::config::{MOST_CONTACTS, Preparation};
use granum_dem::invariants;
use granum_dem::loading::{Reason, Stage, StageEnd};
use granum_dem::simulation::Simulation;
use granum_dem::state::ServoError;
use granum_io::run::QualityFlag;
use granum_sensors::overlap::largest_overlap;
use granum_sensors::{MissedObservations, Observation, Record};

use super::energy_balance::energy_gap;
use super::test_state::Test;
use crate::engine::flags;
use crate::strength::symmetry::keeps_volume;
use crate::strength::{CARRIES_STRESS, Curves, ended_liquefied};

/// Magnitude of the total momentum over the sum of the magnitudes of the momenta of the grains.
fn momentum_drift(assembly: &Assembly) -> f64 {
    let mut net = [0.0; 3];
    let mut sum = 0.0;
    for g in &assembly.bodies {
        let mut square = 0.0;
        for k in 0..3 {
            net[k] += g.mass * g.velocity[k];
            square += g.velocity[k] * g.velocity[k];
        }
        sum += g.mass * square.sqrt();
    }
    if sum == 0.0 { 0.0 } else { net.iter().map(|x| x * x).sum::<f64>().sqrt() / sum }
}

/// Limit on the root mean square error of each controlled stress over the mean stress, in a stage whose rates grow from zero.
const SERVO_ERROR: f64 = 0.005;
/// The same in a stage whose rates begin at once, as in the test of the paper: the stresses still settle after the strain of the
/// start, which is not judged.
const SERVO_ERROR_WITHOUT_EASE: f64 = 0.01;
/// Largest net momentum over the sum of the magnitudes of the momenta.
const LARGEST_MOMENTUM_DRIFT: f64 = 1e-6;
/// Limit on the relative deviation of the mean stress of a sample at rest from its target.
const MEAN_STRESS_MISSED: f64 = 0.005;

/// The quality flags of a prepared or consolidated sample; `what` is the prefix of their names.
pub(super) fn judge_rest(
    what: &str,
    simulation: &Simulation,
    unbalanced_force: f64,
    p: &Preparation,
) -> Vec<QualityFlag> {
    let state = simulation.state();
    vec![
        QualityFlag::at_most(
            format!("{what}_unbalanced_force"),
            unbalanced_force,
            p.unbalanced_force,
            "the sample did not come to rest; raise preparation.unbalanced_force or lower preparation.inertial_number",
        ),
        QualityFlag::at_most(
            format!("{what}_mean_stress_missed_by"),
            (state.mean_stress() / p.mean_stress - 1.0).abs(),
            MEAN_STRESS_MISSED,
            "the sample did not come to rest at its mean stress; lower preparation.inertial_number",
        ),
        flags::overlap(
            format!("{what}_largest_overlap"),
            largest_overlap(&Observation::new(&simulation.assembly())),
        ),
        judge_time_step(format!("{what}_time_step_fraction"), simulation),
    ]
}

fn judge_time_step(name: impl Into<String>, simulation: &Simulation) -> QualityFlag {
    let limit = simulation.properties().contact.stable_fraction(MOST_CONTACTS);
    flags::time_step(name, simulation.state().time_step_fraction(), limit)
}

/// True for a stage that has no limit after which it would be cut short, such as that of the section `[shear]`: that it met its end
/// needs no word.
pub(super) fn is_certain_to_end(stage: &Stage) -> bool {
    stage.most_arc_length.is_none()
}

/// Limit on the root mean square error of the stresses that a stage controls.
fn servo_limit(stage: &Stage) -> f64 {
    if stage.control.eases { SERVO_ERROR } else { SERVO_ERROR_WITHOUT_EASE }
}

/// The error of the stage that comes nearest to its limit, or exceeds it most, with the limit; the limit of the first stage if no
/// stage controls a stress.
pub(in crate::engine) fn worst_servo_error<'e>(
    stages: &[Stage],
    errors: impl Iterator<Item = (usize, &'e ServoError)>,
) -> (f64, f64) {
    let limit = |k: usize| stages.get(k).map_or(SERVO_ERROR, servo_limit);
    errors.fold((0.0, limit(0)), |(error, of_error), (k, next)| {
        let (next, of_next) = (next.rms(), limit(k));
        if next / of_next > error / of_error { (next, of_next) } else { (error, of_error) }
    })
}

/// A remark for the user if states were averaged over fewer observations than the case requires.
pub(in crate::engine) fn remark_on_samples(
    missed_observations: &MissedObservations,
    speed_key: &str,
) -> Option<String> {
    let MissedObservations { wanted, missing, states, empty_states } = *missed_observations;
    let none = match empty_states {
        0 => String::new(),
        some => format!(" ({some} of them without any: they are not recorded)"),
    };
    (missing > 0).then(|| {
        format!(
            "{missing} of the {wanted} observations required by recording.observations_per_state were not made, at \
             {states} states{none}: the test takes fewer steps there; lower recording.observations_per_state or \
             {speed_key}, or record fewer states"
        )
    })
}

/// Share of the largest mean stress of a stage below which it starts without stress.
const NO_STRESS: f64 = 1e-3;

/// For every state whether the sample carries stress: at least [`CARRIES_STRESS`] of the mean stress at the start of its stage, or of
/// the largest of the stage where it starts without stress.
fn carry_stress(record: &Record) -> Vec<bool> {
    let column = |name: &str| record.series.values(name).unwrap_or(&[]);
    let (p, stages) = (column("mean_stress"), column("stage"));
    let most = p.iter().copied().fold(0.0, f64::max);
    let (mut start, mut least) = (0, f64::NAN);
    (0..p.len())
        .map(|row| {
            if row == 0 || stages.get(row) != stages.get(start) {
                start = row;
                let rest = (row..p.len()).take_while(|other| stages.get(*other) == stages.get(row));
                let largest = rest.map(|other| p[other]).fold(0.0, f64::max);
                // In a stage without any stress the little that is left is noise.
                let largest = if largest > NO_STRESS * most { largest } else { f64::INFINITY };
                least = CARRIES_STRESS * if p[row] > NO_STRESS * largest { p[row] } else { largest };
            }
            p[row] >= least || p[row].is_nan()
        })
        .collect()
}

/// For every stage whether its sample lost its stress, by its states or by the reason why it ended.
pub(in crate::engine) fn stages_without_stress(record: &Record, ends: &[StageEnd]) -> Vec<bool> {
    let stages = record.series.values("stage").unwrap_or(&[]);
    let mut carries = vec![Vec::new(); ends.len()];
    for (row, carried) in carry_stress(record).into_iter().enumerate() {
        let stage = stages.get(row).map_or(0, |number| (*number as usize).saturating_sub(1));
        if let Some(of_stage) = carries.get_mut(stage) {
            of_stage.push(carried);
        }
    }
    // A stage that begins without stress has lost none, unless it never carries any.
    let is_lost = |of_stage: &Vec<bool>| match of_stage.first() {
        Some(true) => of_stage.contains(&false),
        Some(false) => !of_stage.contains(&true),
        None => false,
    };
    let mut lost: Vec<bool> = carries.iter().map(is_lost).collect();
    for (lost, end) in lost.iter_mut().zip(ends) {
        *lost |= ended_liquefied(end) || matches!(end.reason, Reason::TensileStrength { .. });
    }
    lost
}

/// True if no state of the last stage carries stress.
fn end_carries_nothing(record: &Record) -> bool {
    let stages = record.series.values("stage").unwrap_or(&[]);
    let carries = carry_stress(record);
    let of_last = carries.iter().enumerate().filter(|(row, _)| stages.get(*row) == stages.last());
    !carries.is_empty() && of_last.into_iter().all(|(_, carried)| !carried)
}

/// Number of the stages that met none of their end conditions. That an undrained sample liquefies is a result: the last stage of a test
/// that ends with it, has shown what it was to show.
pub(in crate::engine) fn unmet_stages(stages: &[Stage], ends: &[StageEnd]) -> usize {
    let is_unmet =
        |(k, end): &(usize, &StageEnd)| !end.reason.is_asked_for() && !is_liquefied_end(stages, *k, end);
    ends.iter().enumerate().filter(is_unmet).count()
}

/// True for the last stage of a test if it is undrained and ended since its sample had liquefied.
pub(in crate::engine) fn is_liquefied_end(stages: &[Stage], k: usize, end: &StageEnd) -> bool {
    let undrained = stages.get(k).is_some_and(|stage| keeps_volume(&stage.control) && !stage.settling);
    k + 1 == stages.len() && undrained && matches!(end.reason, Reason::Unjammed { .. })
}

/// The mean of a column of a record over the states that count. The first is excluded, since it contains the start of the loading, and so
/// are those of a sample that has lost its stress: grains without contact move as they like.
pub(in crate::engine) fn mean_of_carrying(record: &Record) -> impl Fn(&str) -> f64 {
    let carries = carry_stress(record);
    move |name: &str| {
        let values = record.series.values(name).unwrap_or(&[]);
        let carrying: Vec<f64> =
            values.iter().zip(&carries).skip(1).filter(|(_, c)| **c).map(|(v, _)| *v).collect();
        carrying.iter().sum::<f64>() / carrying.len().max(1) as f64
    }
}

/// The mean inertial number of a test, over the same states. It counts at the mean stress at the start of an undrained part where the
/// sample has lost stress since: the loss is what the test shows, and no speed that is chosen before could follow it.
pub(in crate::engine) fn mean_inertial_number(record: &Record, stages: &[Stage]) -> f64 {
    let (curves, carries) = (Curves::new(record, stages), carry_stress(record));
    let p = curves.mean_stress();
    let at_start = |row: usize, number: f64| {
        let share = curves.undrained_from(row).and_then(|start| Some(p.get(row)? / p.get(start)?));
        match share {
            Some(share) if (0.0..1.0).contains(&share) => number * share.sqrt(),
            _ => number,
        }
    };
    let numbers = curves.column("inertial_number").iter().enumerate().zip(&carries).skip(1);
    let carrying: Vec<f64> =
        numbers.filter(|(_, c)| **c).map(|((row, number), _)| at_start(row, *number)).collect();
    carrying.iter().sum::<f64>() / carrying.len().max(1) as f64
}

/// The quality flags of a finished test; `speed_key` is what sets its speed in the case.
pub(super) fn judge(
    simulation: &Simulation,
    end: &Assembly,
    record: &Record,
    test: &Test,
    speed_key: &str,
) -> Vec<QualityFlag> {
    let state = simulation.state();
    let column = |name: &str| record.series.values(name).unwrap_or(&[]).to_vec();
    let largest = |name: &str| column(name).into_iter().fold(0.0, f64::max);
    let mean = mean_of_carrying(record);
    let lost_stress = stages_without_stress(record, &test.ends);
    let judged = |k: usize| lost_stress.get(k) != Some(&true);
    // The errors of the present stage are those of the last end once it has one.
    let under_way = state.servo_error();
    let present = (test.ends.len() < test.recorders.len() || test.ends.is_empty()).then_some(&under_way);
    let ends = test.ends.iter().map(|end| &end.servo_error).enumerate().filter(|(k, _)| judged(*k));
    let errors: Vec<(usize, &ServoError)> =
        ends.chain(present.map(|error| (test.ends.len(), error))).collect();
    let (servo_error, servo_limit) = worst_servo_error(test.list(), errors.iter().copied());
    let unmet = unmet_stages(test.list(), &test.ends);
    let mut flags = if unmet == 0 && test.list().iter().all(is_certain_to_end) {
        Vec::new()
    } else {
        vec![flags::stages_cut_short(unmet)]
    };
    // A target of no stress, or of tension, is not lost.
    let began = invariants::mean(&test.stage_progress.start.stress);
    let target = state.target_mean_stress().filter(|target| *target > CARRIES_STRESS * began.abs());
    let lost = target.map_or(0.0, |target| 1.0 - state.mean_stress() / target);
    let inertial_number = mean_inertial_number(record, test.list());
    flags.extend(flags::quasi_static(inertial_number, mean("unbalanced_force"), speed_key));
    flags.extend([
        flags::servo_error(servo_error, servo_limit, speed_key),
        QualityFlag::at_most(
            "servo_error_largest",
            errors.iter().map(|(_, error)| error.largest()).fold(0.0, f64::max),
            0.03,
            format!(
                "the controlled stress deviated too far at least once; lower {speed_key} or take more grains"
            ),
        ),
        flags::overlap("largest_overlap", largest("largest_overlap")),
        QualityFlag::at_most(
            "momentum_drift",
            momentum_drift(end),
            LARGEST_MOMENTUM_DRIFT,
            "momentum is not conserved; lower numerics.time_step_factor",
        ),
        judge_time_step("time_step_fraction", simulation),
        QualityFlag::at_most(
            "mean_stress_lost",
            lost,
            0.1,
            format!("the sample lost its mean stress; lower {speed_key} or numerics.time_step_factor"),
        ),
    ]);
    // Errors relative to a stress that has gone say nothing of the servo.
    if errors.is_empty() {
        flags.retain(|flag| !flag.name.starts_with("servo_error"));
    }
    // The energy that global damping takes while a sample comes to rest is not counted, so that there is nothing to judge, and grains
    // that carry nothing have hardly any energy.
    if !test.damped && !end_carries_nothing(record) {
        flags.push(QualityFlag::at_most(
            "energy_gap",
            energy_gap(&test.before, end),
            1e-3,
            "the energy balance does not close; lower numerics.time_step_factor",
        ));
    }
    flags
}

#[cfg(test)]
mod tests {
    use granum_io::Case;

    use super::*;

    /// A sample that loses its stress at constant volume is strained as slowly as it was asked for, and that it liquefies at the end of its test
    /// is no stage that was cut short.
    #[test]
    fn liquefaction_is_a_result() {
        let stages = |text: &str| Case::parse(text, "case.toml").unwrap().test_stages();
        let undrained = stages("[[stage]]\npath = 'undrained-triaxial'\n");
        let drained = stages("[[stage]]\npath = 'drained-triaxial'\n");
        let column = |name: &str, values: [f64; 4]| granum_core::Column::new(name, "", values.to_vec());
        let p = [100e3, 25e3, 6.25e3, 1e3];
        let series = granum_core::Table::new(vec![
            column("stage", [1.0; 4]),
            column("mean_stress", p),
            column("inertial_number", p.map(|p| 1e-3 * (100e3 / p).sqrt())),
        ]);
        let record = Record { series: series.unwrap(), ..Record::default() };
        assert!((mean_inertial_number(&record, &undrained) - 1e-3).abs() < 1e-15);
        assert!(
            (mean_inertial_number(&record, &drained) - 3e-3).abs() < 1e-15,
            "the last state carries no stress"
        );
        let reason = Reason::Unjammed { mean_stress: 10.0, before: 100e3 };
        let end = StageEnd {
            name: "shear".into(),
            reason,
            steps: 1,
            time: 1.0,
            servo_error: ServoError::default(),
        };
        let ends = [end];
        assert_eq!((unmet_stages(&undrained, &ends), unmet_stages(&drained, &ends)), (0, 1));
        let followed = [undrained, drained].concat();
        assert_eq!(unmet_stages(&followed, &ends), 1, "the stages after it were not run");
    }

    fn error(rms: f64) -> ServoError {
        ServoError {
            squares: [rms * rms, 0.0, 0.0, 0.0, 0.0, 0.0],
            steps: [1, 0, 0, 0, 0, 0],
            ..Default::default()
        }
    }

    /// The limit follows from how the rates of a stage begin, and of several stages the one nearest to its own limit is judged.
    #[test]
    fn the_limit_of_the_servo_is_that_of_the_stage() {
        let stages = |text: &str| Case::parse(text, "case.toml").unwrap().test_stages();
        let (shear, path) = (stages(""), stages("[[stage]]\npath = 'drained-triaxial'\n"));
        assert_eq!([servo_limit(&shear[0]), servo_limit(&path[0])], [0.01, 0.005]);
        assert!(is_certain_to_end(&shear[0]) && !is_certain_to_end(&path[0]));
        let both = [shear[0].clone(), path[0].clone()];
        let worst = |errors: [f64; 2]| {
            let errors = errors.map(error);
            worst_servo_error(&both, errors.iter().enumerate())
        };
        assert_eq!(worst([0.006, 0.004]), (0.004, 0.005));
        assert_eq!(worst([0.009, 0.004]), (0.009, 0.01));
        assert_eq!(worst([0.0, 0.0]), (0.0, 0.01));
        assert_eq!(worst_servo_error(&path, std::iter::empty()), (0.0, 0.005));
    }
}
