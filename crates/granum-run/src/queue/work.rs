//! An estimate of the work of a run, by which runs are ordered and their progress is weighed. It decides nothing else.

use granum_dem::loading::{Measure, Speed, Stage, Until};

use granum_io::run::RunKind;

use super::queued_run::QueuedRun;
use crate::task::memory;
use crate::task::source::Source;

/// Strain of a compaction.
const STRAIN_OF_COMPACTION: f64 = 0.3;
/// Strain of a stage whose end is not given as a strain.
const STRAIN_OF_STAGE: f64 = 0.02;
/// Inertial number of a stage that is driven at a strain rate.
const USUAL_INERTIAL_NUMBER: f64 = 1e-3;

impl QueuedRun {
    /// An estimate of the work of the run in arbitrary units, by which runs are ordered and their progress is weighed.
    pub fn expected_work(&self) -> f64 {
        expected(self)
    }
}

/// Grains times strain over inertial number, which the number of steps is in proportion to at a given stress and stiffness.
fn expected(run: &QueuedRun) -> f64 {
    let case = &run.case;
    let preparation = match &run.source {
        Source::Case => STRAIN_OF_COMPACTION / case.preparation.inertial_number,
        Source::Folder(_) | Source::Packing(_) => 0.0,
    };
    let stages = case.sample_stages();
    let preparation = preparation + stages.iter().map(of_stage).sum::<f64>();
    let test = match run.kind {
        RunKind::Sample => 0.0,
        RunKind::Test => case.test_stages().iter().map(of_stage).sum(),
    };
    memory::spheres_of(case) as f64 * (preparation + test)
}

fn of_stage(stage: &Stage) -> f64 {
    let number = match stage.control.speed {
        Speed::InertialNumber { number, .. } if number > 0.0 => number,
        _ => USUAL_INERTIAL_NUMBER,
    };
    let ends = stage.until.iter().filter_map(strain_of_end);
    let strain = ends.fold(f64::INFINITY, f64::min);
    let strain = if strain.is_finite() { strain } else { STRAIN_OF_STAGE };
    let reversals = stage.until.iter().find_map(|until| match until {
        Until::Reversals(count) => Some(*count as f64),
        _ => None,
    });
    let to_and_fro = stage.turns.as_ref().zip(reversals).map(|(turns, count)| {
        let range = if is_strain(turns.measure) { turns.high - turns.low } else { STRAIN_OF_STAGE };
        count * range
    });
    to_and_fro.unwrap_or(strain) / number
}

fn strain_of_end(until: &Until) -> Option<f64> {
    match until {
        Until::Reaches { measure, value } if is_strain(*measure) => Some(value.abs()),
        _ => None,
    }
}

fn is_strain(measure: Measure) -> bool {
    measure.unit() == "1" && measure != Measure::StressRatio
}

#[cfg(test)]
mod tests {
    use granum_io::Case;

    use super::*;

    fn work(text: &str, source: Source) -> f64 {
        expected(&QueuedRun::test("run", Case::parse(text, "case").unwrap(), source, "run"))
    }

    #[test]
    fn work_grows_with_grains_strain_and_slowness() {
        let of = |text: &str| work(text, Source::Case);
        let usual = of("");
        assert!(of("grains.count = 10000") > 1.9 * usual);
        assert!(of("shear.deviator_strain = 0.1") < usual);
        assert!(of("shear.inertial_number = 1e-4") > 2.0 * usual);
        let folder = || Source::Folder("sample".into());
        let path = |strain: &str| format!("[[stage]]\npath = 'drained-triaxial'\naxial_strain = {strain}\n");
        let [short, long] = ["0.05", "0.1"].map(|strain| work(&path(strain), folder()));
        assert!((long / short - 2.0).abs() < 0.1, "{short} {long}");
        let cycles = work("[[stage]]\npath = 'cyclic'\ncycles = 100\n", folder());
        assert!(cycles > long, "{cycles} {long}");
    }
}
