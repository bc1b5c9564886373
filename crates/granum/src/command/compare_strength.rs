//! The strength of the runs of `granum compare`, the critical state line through those that are critical, and the envelope of cohesive grains.

use granum_core::Table;
use granum_report::comparison::ComparedRun;
use granum_report::figure::Panel;
use granum_report::lines_of_tests::{critical_state_plot, reasons};
use granum_report::strength::{Measures, scatter_table};
use granum_run::runs_table::RunEntry;
use granum_run::strength::critical_state_line::CriticalStateLine;
use granum_run::strength::envelope::StrengthEnvelope;
use granum_run::strength::{CriticalStates, Envelopes, Judged, SECANT_REMARK, Tested};
use granum_sensors::Record;
use serde_json::{Value, json};

use super::text_table;

/// The strength of runs, with the scatter of those that differ in their seeds alone, and what they say together.
pub struct Strength {
    table: Table,
    states: CriticalStates,
    envelopes: Option<Envelopes>,
}

impl Strength {
    /// Of runs with their entries and measurements.
    pub fn from_runs(entries: &[RunEntry], runs: &[ComparedRun], records: &[Record]) -> Strength {
        let measures: Vec<Measures> = runs.iter().map(|run| run.measures.clone()).collect();
        let tested: Vec<Tested> = (entries.iter().zip(runs).zip(records))
            .map(|((entry, run), record)| Tested {
                name: &run.name,
                case: &entry.case,
                about: &entry.record,
                record,
            })
            .collect();
        Strength {
            table: scatter_table(entries, &measures),
            states: CriticalStates::of_tests(&tested),
            envelopes: Envelopes::of_tests(&tested),
        }
    }

    /// The late states with the line, if several runs have one.
    pub fn panel(&self) -> Option<Panel> {
        let count = self.states.tests.iter().filter(|test| test.state.is_some()).count();
        let is_drawn = count >= 2 && self.states.materials_differ_in.is_empty();
        is_drawn.then(|| Panel::plot(critical_state_plot(&self.states)))
    }

    /// Adds it to the JSON of a comparison.
    pub fn add_to(&self, comparison: &mut Value) {
        let CriticalStates { tests, line, materials_differ_in } = &self.states;
        comparison["strength"] = json!(text_table::rows(&self.table));
        comparison["critical_state_line"] = json!(line.map(|line| line_as_json(&line)));
        comparison["not_in_critical_state_line"] = left_out_as_json(tests);
        comparison["materials_differ_in"] = json!(materials_differ_in);
        if let Some(Envelopes { tests, envelope }) = &self.envelopes {
            comparison["strength_envelope"] = json!(envelope.map(|envelope| envelope_as_json(&envelope)));
            comparison["not_in_strength_envelope"] = left_out_as_json(tests);
            comparison["remarks"] = json!([SECANT_REMARK]);
        }
    }

    /// As lines of text.
    pub fn lines(&self) -> Vec<String> {
        let mut lines = Vec::new();
        if self.table.columns().len() > 1 {
            lines.push(String::new());
            lines.extend(text_table::lines(&self.table));
        }
        lines.extend(self.lines_of_states());
        lines.extend(self.lines_of_envelope());
        lines
    }

    fn lines_of_states(&self) -> Vec<String> {
        let CriticalStates { tests, line, materials_differ_in } = &self.states;
        if !materials_differ_in.is_empty() {
            let differing = materials_differ_in.join(", ");
            return vec![format!(
                "no critical state line: the runs are of different materials ({differing})"
            )];
        }
        let with_state = tests.iter().filter(|test| test.state.is_some()).count();
        let mut lines = Vec::new();
        match line {
            Some(line) => lines.push(line_text(line)),
            None if with_state < 2 => return lines,
            None => lines.push(
                "no critical state line: it takes two runs or more that are critical, at mean stresses that differ by a fifth".into(),
            ),
        }
        lines.extend(left_out_lines(tests));
        lines
    }

    fn lines_of_envelope(&self) -> Vec<String> {
        let Some(Envelopes { tests, envelope }) = &self.envelopes else { return Vec::new() };
        let mut lines = vec![format!("remark: {SECANT_REMARK}")];
        match envelope {
            Some(envelope) => lines.push(envelope_text(envelope)),
            None => lines.push(
                "no envelope of the strength: it takes two runs or more of one material that passed their checks, whose peaks are at mean \
                 stresses that differ by a fifth"
                    .into(),
            ),
        }
        lines.extend(left_out_lines(tests));
        lines
    }
}

/// The runs that do not take part in a line, each with the reason.
fn left_out_lines<S>(tests: &[Judged<S>]) -> Vec<String> {
    reasons(tests).into_iter().map(|reason| format!("  left out: {reason}")).collect()
}

fn left_out_as_json<S>(tests: &[Judged<S>]) -> Value {
    let one = |test: &Judged<S>| Some(json!({ "run": test.name, "reason": test.left_out.as_ref()? }));
    json!(tests.iter().filter_map(one).collect::<Vec<_>>())
}

fn line_text(line: &CriticalStateLine) -> String {
    let error = |error: Option<f64>| error.map_or(String::new(), |error| format!(" +- {error:.4}"));
    let [low, high] = line.range.map(|p| p / 1e3);
    format!(
        "critical state line e = Gamma - lambda ln(p / 1 kPa) through the critical states of {} runs: Gamma {:.4}{}, lambda \
         {:.4}{} (standard errors), from {low:.1} to {high:.1} kPa",
        line.tests,
        line.intercept,
        error(line.intercept_error),
        line.slope,
        error(line.slope_error),
    )
}

fn envelope_text(envelope: &StrengthEnvelope) -> String {
    let error = |error: Option<f64>, size: f64| {
        error.map_or(String::new(), |error| format!(" +- {:.3}", error / size))
    };
    let [low, high] = envelope.range.map(|p| p / 1e3);
    let unconfined = envelope
        .unconfined_strength()
        .map_or(String::new(), |strength| format!(", unconfined strength {:.3} kPa", strength / 1e3));
    let friction =
        envelope.friction_angle().zip(envelope.cohesion()).map_or(String::new(), |(angle, cohesion)| {
            format!("; friction angle {angle:.1} deg, cohesion {:.3} kPa", cohesion / 1e3)
        });
    format!(
        "envelope of the strength q = M p + c through the peaks of {} runs: M {:.3}{}, c {:.3}{} kPa (standard errors), from {low:.2} to \
         {high:.2} kPa{friction}; extrapolated: isotropic tensile strength {:.3} kPa{unconfined}",
        envelope.tests,
        envelope.slope,
        error(envelope.slope_error, 1.0),
        envelope.intercept / 1e3,
        error(envelope.intercept_error, 1e3),
        envelope.tensile_strength() / 1e3,
    )
}

fn line_as_json(line: &CriticalStateLine) -> Value {
    json!({
        "void_ratio_at_1_kPa": line.intercept,
        "void_ratio_at_1_kPa_standard_error": line.intercept_error,
        "lambda": line.slope,
        "lambda_standard_error": line.slope_error,
        "scatter_of_void_ratio": line.scatter,
        "runs": line.tests,
        "mean_stress_range": line.range,
    })
}

fn envelope_as_json(envelope: &StrengthEnvelope) -> Value {
    json!({
        "slope": envelope.slope,
        "slope_standard_error": envelope.slope_error,
        "intercept": envelope.intercept,
        "intercept_standard_error": envelope.intercept_error,
        "scatter_of_deviator_stress": envelope.scatter,
        "friction_angle": envelope.friction_angle(),
        "cohesion": envelope.cohesion(),
        "tensile_strength": envelope.tensile_strength(),
        "unconfined_strength": envelope.unconfined_strength(),
        "runs": envelope.tests,
        "mean_stress_range": envelope.range,
    })
}
