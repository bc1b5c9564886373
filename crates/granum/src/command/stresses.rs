//! The stresses at which a test was run, for its summary: those that each stage reached at its end, and beside them the means over the last
//! interval, which are what the series holds.

use granum_io::run::StageEndRecord;
use granum_io::{Case, Run, Table};
use serde_json::{Value, json};

/// Most stages that are told one by one; of more, the first and the last are told.
const MOST_STAGES: usize = 4;

/// The normal stresses of a state, Pa, compression positive.
#[derive(Clone, Copy)]
struct State {
    mean: f64,
    components: [f64; 3],
}

/// A stage of a test: its number from 1, its name, its first recorded state, the state that it reached, and the mean over its last interval.
struct StageStresses {
    number: usize,
    name: String,
    start: State,
    end: Option<StageEndRecord>,
    last_interval: Option<State>,
}

/// The stresses of the stages of a test.
pub struct Stresses {
    stages: Vec<StageStresses>,
    /// True if the test has no other stage.
    is_one_stage: bool,
}

impl Stresses {
    /// Of a run; none if it is a preparation, or if its series cannot be read.
    pub fn read(run: &Run) -> Option<Stresses> {
        if !run.has_series() {
            return None;
        }
        let mut all = Stresses::from(&run.series().ok()?, &run.case().ok()?, &run.record().ok()?.stage_ends)?;
        let last = all.stages.len();
        for (k, stage) in all.stages.iter_mut().enumerate() {
            // What a test of many stages does not tell is not read either.
            let is_told = last <= MOST_STAGES || k == 0 || k + 1 == last;
            if stage.end.is_none() && is_told {
                stage.end = end_in_snapshot(run, stage.number, k + 1 == last);
            }
        }
        Some(all)
    }

    fn from(series: &Table, case: &Case, ends: &[StageEndRecord]) -> Option<Stresses> {
        let column = |name: &str| series.values(name);
        let mean = column("mean_stress")?;
        let components = [column("stress_11")?, column("stress_22")?, column("stress_33")?];
        let state = |row: usize| {
            Some(State {
                mean: *mean.get(row)?,
                components: [*components[0].get(row)?, *components[1].get(row)?, *components[2].get(row)?],
            })
        };
        let names: Vec<String> = case.test_stages().into_iter().map(|stage| stage.name).collect();
        let ones = vec![1.0; mean.len()];
        let numbers = column("stage").unwrap_or(&ones);
        let mut stages = Vec::new();
        let mut row = 0;
        for group in numbers.chunk_by(|a, b| a == b) {
            let number = group[0] as usize;
            let name = names.get(number.saturating_sub(1)).cloned().unwrap_or_default();
            let last_interval = if group.len() > 1 { state(row + group.len() - 1) } else { None };
            let end = ends.iter().find(|end| end.stage == number).cloned();
            stages.push(StageStresses { number, name, start: state(row)?, end, last_interval });
            row += group.len();
        }
        Some(Stresses { stages, is_one_stage: names.len() == 1 })
    }

    /// As JSON, a stage an object: `end` is the state that was reached, `last_interval` the mean that is the last row of the series.
    pub fn json(&self) -> Value {
        let state = |state: &State| json!({ "mean_stress": state.mean, "stress_11": state.components[0], "stress_22": state.components[1], "stress_33": state.components[2] });
        let end = |end: &StageEndRecord| {
            let mut object = state(&State::from_end(end));
            object["axial_deviator_stress"] = json!(end.axial_deviator_stress);
            object["von_mises_stress"] = json!(end.von_mises_stress);
            object
        };
        let stage = |stage: &StageStresses| {
            json!({
                "stage": stage.number,
                "name": stage.name,
                "start": state(&stage.start),
                "end": stage.end.as_ref().map(end),
                "last_interval": stage.last_interval.as_ref().map(state),
            })
        };
        self.stages.iter().map(stage).collect()
    }

    /// As lines of text.
    pub fn lines(&self) -> Vec<String> {
        let line = |stage: &StageStresses| {
            let place = match self.is_one_stage {
                true => "stresses of the test".to_string(),
                false => format!("stresses of stage {} ({})", stage.number, stage.name),
            };
            let mut text = format!("{place}: {} at its start", text(&stage.start, None));
            if let Some(end) = &stage.end {
                text += &format!(
                    ", {} at its end",
                    self::text(&State::from_end(end), Some(end.axial_deviator_stress))
                );
            }
            if let Some(mean) = &stage.last_interval {
                text += &format!(", {} as the mean over its last interval", self::text(mean, None));
            }
            text
        };
        let all = &self.stages;
        match all.len() {
            0..=MOST_STAGES => all.iter().map(line).collect(),
            many => {
                let between = format!(
                    "stresses of the {} stages between them: at their ends in run.json, as means over intervals in series.parquet",
                    many - 2
                );
                [all.first().map(line), Some(between), all.last().map(line)].into_iter().flatten().collect()
            }
        }
    }
}

impl State {
    fn from_end(end: &StageEndRecord) -> State {
        State { mean: end.mean_stress, components: [0, 1, 2].map(|k| end.stress[k][k]) }
    }
}

/// The state at the end of a stage from its snapshot, where the record has none since an earlier version wrote it.
fn end_in_snapshot(run: &Run, number: usize, is_last: bool) -> Option<StageEndRecord> {
    let names = run.snapshots().ok()?;
    let of_stage = format!("stage-{number}");
    let name =
        names.iter().find(|name| **name == of_stage || is_last && *name == granum_run::laboratory::END)?;
    Some(StageEndRecord::of_state(&run.snapshot(name).ok()?))
}

/// "p 100.0 kPa (xx 100.2, yy 99.9, zz 99.9)", with the axial less the mean lateral stress as q if it is given.
fn text(state: &State, deviator: Option<f64>) -> String {
    let largest = state.components.iter().fold(state.mean.abs(), |largest, stress| largest.max(stress.abs()));
    let units = [("GPa", 1e9), ("MPa", 1e6), ("kPa", 1e3)];
    let (unit, size) = units.into_iter().find(|(_, size)| largest >= *size).unwrap_or(("Pa", 1.0));
    let [x, y, z] = state.components.map(|stress| four_digits(stress / size, largest / size));
    let q = deviator.map_or(String::new(), |q| format!(", q {}", four_digits(q / size, largest / size)));
    format!("p {} {unit} (xx {x}, yy {y}, zz {z}{q})", four_digits(state.mean / size, largest / size))
}

/// A number with as many decimals as give the largest of its kind four digits.
fn four_digits(value: f64, largest: f64) -> String {
    let before = if largest >= 1.0 { libm::log10(largest) as i32 + 1 } else { 1 };
    let decimals = (4 - before).clamp(0, 3) as usize;
    // Zero has one sign.
    let rounded = format!("{value:.decimals$}");
    if rounded.trim_start_matches(['-', '0', '.']).is_empty() {
        rounded.trim_start_matches('-').into()
    } else {
        rounded
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use granum_io::Column;

    fn series(stage: &[f64], stress: &[f64]) -> Table {
        let column = |name: &str, values: &[f64]| Column::new(name, "", values.to_vec());
        let mut columns = vec![column("stage", stage)];
        columns
            .extend(["mean_stress", "stress_11", "stress_22", "stress_33"].map(|name| column(name, stress)));
        Table::new(columns).unwrap()
    }

    #[test]
    fn each_stage_says_its_stresses_in_a_readable_unit() {
        let case =
            Case::parse("[[stage]]\npath = 'drained-triaxial'\nlateral_stress = '50 Pa'\n", "case.toml")
                .unwrap();
        let end = StageEndRecord {
            stage: 2,
            mean_stress: 82.0,
            axial_deviator_stress: 9.0,
            stress: [[88.0, 0.0, 0.0], [0.0, 79.0, 0.0], [0.0, 0.0, 79.0]],
            ..StageEndRecord::default()
        };
        let found =
            Stresses::from(&series(&[1.0, 2.0, 2.0], &[2e4, 50.25, 81.0]), &case, std::slice::from_ref(&end))
                .unwrap();
        assert_eq!(
            found.lines(),
            [
                "stresses of stage 1 (consolidation): p 20.00 kPa (xx 20.00, yy 20.00, zz 20.00) at its start",
                "stresses of stage 2 (shear): p 50.25 Pa (xx 50.25, yy 50.25, zz 50.25) at its start, p 82.00 Pa (xx 88.00, yy 79.00, zz \
                 79.00, q 9.00) at its end, p 81.00 Pa (xx 81.00, yy 81.00, zz 81.00) as the mean over its last interval",
            ]
        );
        assert_eq!(found.json()[1]["end"]["mean_stress"], 82.0);
        assert_eq!(found.json()[1]["last_interval"]["mean_stress"], 81.0);
        let many: Vec<f64> = (1..=7).map(f64::from).collect();
        let lines = Stresses::from(&series(&many, &[1e6; 7]), &case, &[]).unwrap().lines();
        assert_eq!(lines.len(), 3);
        assert!(lines[1].contains("5 stages between"), "{lines:?}");
    }
}
