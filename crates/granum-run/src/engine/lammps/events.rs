//! The lines that a deck writes while it runs.

use granum_core::assembly::Matrix;
use granum_dem::loading::{MacroState, Stage};

/// What a line says.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Event {
    /// A stage begins.
    Began(Instant),
    /// A row ends; grains and contacts of this instant have been written.
    Row(Instant),
    /// A stage is over.
    Ended(End),
    /// A restart file of this step is complete.
    Saved(u64),
}

/// The cell at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub(super) struct Instant {
    /// Number of the stage, from 1; 0 before the test.
    pub(super) stage: usize,
    /// Number of the step.
    pub(super) step: u64,
    /// Time since the start of the test, s.
    pub(super) time: f64,
    /// Time step, s.
    pub(super) time_step: f64,
    /// Logarithmic strain, compression positive.
    pub(super) strain: Matrix,
    /// Arc length of the strain path.
    pub(super) arc_length: f64,
    /// Velocity gradient, 1/s.
    pub(super) gradient: Matrix,
    /// Target of the mean stress, Pa; zero if there is none.
    pub(super) target: f64,
    /// The three normal stresses as LAMMPS has them, with the dashpots, Pa.
    pub(super) stress: [f64; 3],
    /// Von Mises stress in the same way, Pa.
    pub(super) von_mises: f64,
}

impl Instant {
    /// Mean stress with the dashpots, Pa.
    pub(super) fn mean_stress(&self) -> f64 {
        self.stress.iter().sum::<f64>() / 3.0
    }

    /// The instant as measures see it, with the normal stresses alone.
    pub(super) fn macro_state(&self) -> MacroState {
        let mut stress = [[0.0; 3]; 3];
        for (a, value) in self.stress.into_iter().enumerate() {
            stress[a][a] = value;
        }
        MacroState { stress, strain: self.strain, arc_length: self.arc_length, time: self.time }
    }
}

/// The end of a stage.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct End {
    /// Number of the stage.
    pub(super) stage: usize,
    /// Number of its steps.
    pub(super) steps: u64,
    /// Its duration, s.
    pub(super) time: f64,
    /// Arc length of strain since its start.
    pub(super) arc_length: f64,
    /// Mean stress at its end and at its start, Pa.
    pub(super) mean_stress: [f64; 2],
    /// True if the sample lost its stress.
    pub(super) lost: bool,
    /// True if it exceeded its largest length or time.
    pub(super) too_long: bool,
    /// For each of its end conditions whether it was met.
    pub(super) met: Vec<bool>,
    /// For each controlled stress the root mean square of its error over the mean stress.
    pub(super) servo_errors: Vec<f64>,
}

impl Event {
    /// What a line says; `None` if it is no such line. `stages` are those of the test.
    pub(super) fn from_line(line: &str, stages: &[Stage]) -> Option<Event> {
        let mut words = line.trim().split(',');
        let kind = words.next()?;
        let numbers: Vec<f64> = words.map(|word| word.trim().parse().ok()).collect::<Option<_>>()?;
        match kind {
            "begin" => Some(Event::Began(instant(&numbers)?)),
            "row" => Some(Event::Row(instant(&numbers)?)),
            "saved" => Some(Event::Saved(*numbers.first()? as u64)),
            "end" => Some(Event::Ended(end(&numbers, stages)?)),
            _ => None,
        }
    }
}

fn instant(n: &[f64]) -> Option<Instant> {
    let &[
        stage,
        step,
        time,
        time_step,
        e11,
        e22,
        e33,
        g12,
        g23,
        arc,
        l11,
        l22,
        l33,
        l12,
        l23,
        target,
        s11,
        s22,
        s33,
        vm,
    ] = n
    else {
        return None;
    };
    Some(Instant {
        stage: stage as usize,
        step: step as u64,
        time,
        time_step,
        strain: [[e11, 0.5 * g12, 0.0], [0.5 * g12, e22, 0.5 * g23], [0.0, 0.5 * g23, e33]],
        arc_length: arc,
        gradient: [[l11, l12, 0.0], [0.0, l22, l23], [0.0, 0.0, l33]],
        target,
        stress: [s11, s22, s33],
        von_mises: vm,
    })
}

fn end(n: &[f64], stages: &[Stage]) -> Option<End> {
    let [stage, steps, time, arc_length, p, before, lost, too_long, rest @ ..] = n else { return None };
    let stage = *stage as usize;
    // What precedes the test has one condition: that the sample is at rest.
    let conditions =
        stage.checked_sub(1).map_or(Some(1), |at| stages.get(at).map(|stage| stage.until.len()))?;
    let (met, servo_errors) = rest.split_at_checked(conditions)?;
    Some(End {
        stage,
        steps: *steps as u64,
        time: *time,
        arc_length: *arc_length,
        mean_stress: [*p, *before],
        lost: *lost != 0.0,
        too_long: *too_long != 0.0,
        met: met.iter().map(|met| *met != 0.0).collect(),
        servo_errors: servo_errors.to_vec(),
    })
}

#[cfg(test)]
mod tests {
    use granum_io::Case;

    use super::*;

    #[test]
    fn lines_are_read_and_others_are_not() {
        let stages = Case::parse("[[stage]]\npath = 'drained-triaxial'\n", "case").unwrap().test_stages();
        let row = "row,1,120,1e-5,1e-8,0.01,-0.004,-0.003,0.002,0,0.009,-1,2,3,4,0,2e4,3e4,2e4,1e4,1.5e4";
        let Some(Event::Row(row)) = Event::from_line(row, &stages) else { panic!("no row") };
        assert_eq!((row.stage, row.step, row.strain[0][1], row.gradient[0][1]), (1, 120, 0.001, 4.0));
        assert_eq!(row.mean_stress(), 2e4);
        let Some(Event::Ended(end)) =
            Event::from_line("end,1,500,1e-4,0.2,2e4,1e4,0,0,1,0.002,0.004", &stages)
        else {
            panic!("no end")
        };
        assert_eq!((end.steps, &end.met[..], &end.servo_errors[..]), (500, &[true][..], &[0.002, 0.004][..]));
        assert_eq!(Event::from_line("saved,77", &stages), Some(Event::Saved(77)));
        // A line that is cut short, or of a stage that the test does not have.
        for line in ["row,1,120,1e-5", "end,7,500,1e-4,0.2,2e4,1e4,0,0,1", "row,x", "", "saved,"] {
            assert_eq!(Event::from_line(line, &stages), None, "{line}");
        }
    }
}
