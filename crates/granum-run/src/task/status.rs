//! The progress of a run as text, and its speed.

use granum_core::ObservedState;
use granum_core::clock::Instant;
use granum_core::observer::Progress as Report;
use granum_dem::invariants::{deviatoric_strain, signed_von_mises};
use granum_dem::loading::Measure;
use granum_dem::observer::SimulationProgress;
use granum_dem::preparation::Phase;

use crate::strength::symmetry::axial_deviator;

/// A part of a line of progress.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ProgressField {
    /// Text for display.
    pub text: String,
    /// Order in which fields are dropped from a line that is too long: the largest rank first, rank 0 never.
    pub rank: u8,
}

impl ProgressField {
    /// A field with a rank and a text.
    pub fn new(rank: u8, text: impl Into<String>) -> ProgressField {
        ProgressField { text: text.into(), rank }
    }
}

/// The progress of a run as one readable line.
pub fn line(progress: &SimulationProgress) -> String {
    let state = progress.state;
    let mut parts = Vec::new();
    if progress.trial > 1 && progress.phase != Phase::Test {
        parts.push(format!("trial {}", progress.trial));
    }
    if is_of_path(progress) {
        parts.extend(progress.stage.map(str::to_string));
        parts.push(format!("strain {:.4}", strain(progress)));
    }
    if progress.phase == Phase::Test {
        parts.push(stress_ratio(progress));
    }
    parts.push(format!(
        "p {:.2} kPa  solid fraction {:.4}",
        state.macro_state().mean_stress() / 1e3,
        state.solid_fraction()
    ));
    if progress.phase != Phase::Test {
        parts.push(format!("coordination number {:.3}", coordination_number(progress)));
    }
    parts.extend(progress.grain_steps_per_second.map(|rate| format!("{} grain-steps/s", speed(rate))));
    parts.join("  ")
}

/// The progress of a run in short form, for a line of a terminal. If the line is too long, the mean stress, which a test
/// holds constant, is dropped first, then stress ratio and strain; solid fraction and speed are dropped last. A sample that is
/// being made has its coordination number Z in place of the stress ratio.
pub fn fields(progress: &SimulationProgress) -> Vec<ProgressField> {
    let state = progress.state;
    let mut fields = Vec::new();
    if progress.trial > 1 && progress.phase != Phase::Test {
        fields.push(ProgressField::new(1, format!("trial {}", progress.trial)));
    }
    if is_of_path(progress) {
        fields.push(ProgressField::new(1, format!("strain {:.3}", strain(progress))));
    }
    if progress.phase == Phase::Test {
        fields.push(ProgressField::new(2, stress_ratio(progress)));
    }
    fields.push(ProgressField::new(3, format!("p {:.1} kPa", state.macro_state().mean_stress() / 1e3)));
    fields.push(ProgressField::new(0, format!("density {:.3}", state.solid_fraction())));
    if progress.phase != Phase::Test {
        fields.push(ProgressField::new(2, format!("Z {:.2}", coordination_number(progress))));
    }
    fields.extend(
        progress.grain_steps_per_second.map(|rate| ProgressField::new(0, format!("{}/s", speed(rate)))),
    );
    fields
}

/// The progress of a test that another program carries out, in the same short form.
pub fn fields_of_report(report: &Report) -> Vec<ProgressField> {
    let value = |name: &str| report.value(name);
    let mut fields: Vec<ProgressField> =
        report.part.iter().map(|part| ProgressField::new(4, part.clone())).collect();
    fields.extend(
        value("deviatoric_strain").map(|strain| ProgressField::new(1, format!("strain {strain:.4}"))),
    );
    fields.extend(value("von_mises_ratio").map(|ratio| ProgressField::new(2, format!("q_vM/p {ratio:.3}"))));
    fields.extend(value("mean_stress").map(|p| ProgressField::new(3, format!("p {:.1} kPa", p / 1e3))));
    fields.push(ProgressField::new(0, format!("{} {}", report.done, report.counted)));
    fields.extend(
        value("grain_steps_per_second")
            .map(|rate| ProgressField::new(0, format!("{} grain-steps/s", speed(rate)))),
    );
    fields
}

/// True if the progress is that of a loading path, in a test or in a preparation.
fn is_of_path(progress: &SimulationProgress) -> bool {
    matches!(progress.phase, Phase::Test | Phase::PreparationStage)
}

/// Contacts of a grain, of all grains.
fn coordination_number(progress: &SimulationProgress) -> f64 {
    2.0 * progress.state.contacts() as f64 / progress.state.grains().max(1) as f64
}

/// The deviator strain where it spaces the states of the stage, and else the deviatoric strain.
fn strain(progress: &SimulationProgress) -> f64 {
    let macro_state = progress.state.macro_state();
    match progress.measure {
        Some(measure @ Measure::AxialDeviatorStrain) => measure.value(&macro_state),
        _ => deviatoric_strain(&macro_state.strain),
    }
}

/// The ratio q/p of an axisymmetric stage, with the axial stress less the mean lateral one as q; of a general stage that of the von
/// Mises stress, without sign. Zero if p is zero.
fn stress_ratio(progress: &SimulationProgress) -> String {
    let macro_state = progress.state.macro_state();
    let (name, q) = match progress.axis {
        Some(axis) => ("q/p", axial_deviator(&macro_state.stress, axis)),
        None => ("q_vM/p", signed_von_mises(&macro_state.stress).abs()),
    };
    let p = macro_state.mean_stress();
    format!("{name} {:.3}", if p == 0.0 { 0.0 } else { q / p })
}

/// A number of grain-steps with at most three digits: "18.4 M", "840 k".
fn speed(rate: f64) -> String {
    match rate {
        1e8.. => format!("{:.0} M", rate / 1e6),
        1e6.. => format!("{:.1} M", rate / 1e6),
        _ => format!("{:.0} k", rate / 1e3),
    }
}

/// Measures the speed of a run in grain-steps per second.
pub(crate) struct Speedometer {
    since: Instant,
    /// Step at that time; none before the first measurement of a segment.
    step: Option<u64>,
    rate: Option<f64>,
}

impl Speedometer {
    pub(crate) fn new() -> Self {
        Speedometer { since: Instant::now(), step: None, rate: None }
    }

    /// Begins a segment, so that the time since the last one, in which a checkpoint was written, is not counted.
    pub(crate) fn begin(&mut self) {
        self.step = None;
    }

    /// The speed. Until the current one has been measured for half a second, the previous value is returned.
    pub(crate) fn rate(&mut self, state: &dyn ObservedState) -> Option<f64> {
        let step = state.step();
        let seconds = self.since.elapsed().as_secs_f64();
        let steps = self.step.and_then(|before| step.checked_sub(before));
        match steps {
            Some(_) if seconds <= 0.5 => {}
            Some(steps) => {
                let rate = steps as f64 * state.grains() as f64 / seconds;
                *self = Speedometer { step: Some(step), rate: Some(rate), since: Instant::now() };
            }
            // A new segment or phase has begun.
            None => *self = Speedometer { step: Some(step), rate: self.rate, since: Instant::now() },
        }
        self.rate
    }
}

#[cfg(test)]
mod tests {
    use granum_core::cell::Cell;
    use granum_dem::config::{ContactModel, Material};
    use granum_dem::simulation::{InitialSphere, Properties, Simulation};

    use super::*;

    /// A sample that is being made is isotropic or not meant to be axisymmetric: what is shown is the pressure, how dense and how
    /// well connected it is, not a ratio of its residual stresses.
    #[test]
    fn a_sample_shows_no_stress_ratio_and_a_test_shows_one() {
        let spheres = [[1.0e-4; 3], [1.99e-4, 1.0e-4, 1.0e-4]].map(|position| (position, 5e-5));
        let spheres: Vec<InitialSphere> = (1..)
            .zip(spheres)
            .map(|(id, (position, radius))| InitialSphere { id, position, radius })
            .collect();
        let properties = Properties::new(Material::default(), ContactModel::default());
        let simulation = Simulation::new(Cell::cuboid([4e-4; 3]), &spheres, properties).unwrap();
        let shown = |phase| {
            let progress = SimulationProgress::new(phase, 0, 0.0, &simulation);
            let fields: Vec<String> = fields(&progress).into_iter().map(|field| field.text).collect();
            (line(&progress), fields.join("  "))
        };
        for phase in [Phase::Compaction, Phase::Relaxation, Phase::Consolidation, Phase::PreparationStage] {
            let (line, fields) = shown(phase);
            assert!(line.ends_with("coordination number 1.000") && !line.contains("/p"), "{line}");
            assert!(fields.ends_with("Z 1.00") && !fields.contains("/p"), "{fields}");
        }
        let (line, fields) = shown(Phase::Test);
        assert!(line.contains("q_vM/p") && !line.contains("coordination"), "{line}");
        assert!(fields.contains("q_vM/p") && !fields.contains('Z'), "{fields}");
    }

    #[test]
    fn speeds_have_three_digits_and_are_never_nothing() {
        let shown = [1.234e8, 1.84e7, 9.99e6, 8.4e5, 4.2e4].map(speed);
        assert_eq!(shown, ["123 M", "18.4 M", "10.0 M", "840 k", "42 k"]);
    }
}
