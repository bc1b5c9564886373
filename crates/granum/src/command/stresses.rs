//! The stresses at which a test was run, for its summary.

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

/// A stage of a test: its number from 1, its name, and its first and last recorded states.
struct StageStresses {
    number: usize,
    name: String,
    start: State,
    end: Option<State>,
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
        Stresses::from(&run.series().ok()?, &run.case().ok()?)
    }

    fn from(series: &Table, case: &Case) -> Option<Stresses> {
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
            let end = if group.len() > 1 { state(row + group.len() - 1) } else { None };
            stages.push(StageStresses { number, name, start: state(row)?, end });
            row += group.len();
        }
        Some(Stresses { stages, is_one_stage: names.len() == 1 })
    }

    /// As JSON, a stage an object.
    pub fn json(&self) -> Value {
        let state = |state: &State| json!({ "mean_stress": state.mean, "stress_11": state.components[0], "stress_22": state.components[1], "stress_33": state.components[2] });
        let stage = |stage: &StageStresses| {
            json!({
                "stage": stage.number,
                "name": stage.name,
                "start": state(&stage.start),
                "end": stage.end.as_ref().map(state),
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
            match &stage.end {
                Some(end) => {
                    format!("{place}: {} at its start, {} at its end", text(&stage.start), text(end))
                }
                None => format!("{place}: {} at its start", text(&stage.start)),
            }
        };
        let all = &self.stages;
        match all.len() {
            0..=MOST_STAGES => all.iter().map(line).collect(),
            many => {
                let between = format!("stresses of the {} stages between them: in series.parquet", many - 2);
                [all.first().map(line), Some(between), all.last().map(line)].into_iter().flatten().collect()
            }
        }
    }
}

/// "p 100.0 kPa (100.2, 99.9, 99.9)".
fn text(state: &State) -> String {
    let largest = state.components.iter().fold(state.mean.abs(), |largest, stress| largest.max(stress.abs()));
    let units = [("GPa", 1e9), ("MPa", 1e6), ("kPa", 1e3)];
    let (unit, size) = units.into_iter().find(|(_, size)| largest >= *size).unwrap_or(("Pa", 1.0));
    let [x, y, z] = state.components.map(|stress| four_digits(stress / size, largest / size));
    format!("p {} {unit} (xx {x}, yy {y}, zz {z})", four_digits(state.mean / size, largest / size))
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
        let found = Stresses::from(&series(&[1.0, 2.0, 2.0], &[2e4, 50.25, 81.0]), &case).unwrap();
        assert_eq!(
            found.lines(),
            [
                "stresses of stage 1 (consolidation): p 20.00 kPa (xx 20.00, yy 20.00, zz 20.00) at its start",
                "stresses of stage 2 (shear): p 50.25 Pa (xx 50.25, yy 50.25, zz 50.25) at its start, p 81.00 Pa (xx 81.00, yy 81.00, zz \
                 81.00) at its end",
            ]
        );
        assert_eq!(found.json()[1]["end"]["mean_stress"], 81.0);
        let many: Vec<f64> = (1..=7).map(f64::from).collect();
        let lines = Stresses::from(&series(&many, &[1e6; 7]), &case).unwrap().lines();
        assert_eq!(lines.len(), 3);
        assert!(lines[1].contains("5 stages between"), "{lines:?}");
    }
}
