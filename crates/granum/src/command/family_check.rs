//! `granum predict --family ... --check`: the test itself, and how far off the prediction was.

use granum::gallery::ReadyCase;
use granum_core::quantity::format_number;
use granum_core::words;
use granum_io::Case;
use granum_io::case::field;
use granum_learn::RunStates;
use granum_learn::family::{FamilyModel, FamilyPrediction};
use granum_run::laboratory::Source;
use granum_run::{Laboratory, RunKind};
use serde_json::{Map, Value, json};

use super::family_chart::short;
use super::family_flags::{VOID_RATIO, inputs_of_run};
use super::hardware::Show;
use super::known_numbers::KnownNumbers;
use super::prediction_input::LEVEL;
use crate::context::Context;
use crate::failure::Failure;

/// The stress of the sample, which is the lateral stress of its test too.
const STRESS: &str = "preparation.mean_stress";

/// The friction while the sample is made, which the case may leave to the search for a void ratio.
const PREPARATION_FRICTION: &str = "preparation.friction";

/// Difference of void ratios beyond which a sample is not the one that was asked for: about the tolerance of a preparation.
const SLIGHT: f64 = 0.02;

/// How far an output was off.
struct CheckedOutput {
    column: String,
    meaning: &'static str,
    /// Root mean square of the error over that of the measured values.
    error: f64,
    /// Share of the states within their intervals.
    held: f64,
}

/// A prediction beside its test.
pub struct Checked {
    grains: usize,
    /// Name and value of the inputs that were measured on the sample.
    sample: Vec<(String, f64)>,
    /// The void ratio that was given, if no sample could be made with it.
    missed: Option<f64>,
    outputs: Vec<CheckedOutput>,
    /// The prediction for the sample that was made, and the test: values by column and point. `None` if the test ended before the curves do.
    pub drawn: Option<Drawn>,
}

/// A test and the prediction for its sample.
pub struct Drawn {
    pub prediction: FamilyPrediction,
    pub measured: Vec<Vec<f64>>,
}

/// Makes the sample and tests it; the prediction that is judged is that for the sample that was made.
pub fn run(
    context: &Context,
    model: &FamilyModel,
    known: &KnownNumbers,
    inputs: &[Option<f64>],
    grains: Option<usize>,
) -> Result<Checked, Failure> {
    let family = model.definition();
    let case = case(context, model, known, inputs, grains)?;
    let laboratory = Laboratory::here().with_registry(context.run_registry());
    let mut show = Show::new(context);
    let result = laboratory
        .plan(RunKind::Test, &case, &Source::Case, &mut show)
        .and_then(|planned| planned.in_memory(&mut show))
        .map_err(|error| show.failure(error))?;
    let found = result.about.measures.get("preparation_friction").copied();
    let mut run = RunStates::of_case("check", &case, result.record)?;
    if let Some(friction) = found.filter(|_| run.parameter(PREPARATION_FRICTION).is_none()) {
        run = run.with_parameter(PREPARATION_FRICTION, "", friction)?;
    }
    let own = inputs_of_run(family, &run)?;
    let prediction = model.predict(&own, LEVEL)?;
    let Some(measured) = model.measured(&run)? else {
        return Ok(Checked {
            grains: case.grains.count,
            sample: Vec::new(),
            missed: None,
            outputs: Vec::new(),
            drawn: None,
        });
    };
    let shares = model.shares();
    let outputs: Vec<CheckedOutput> = family
        .outputs
        .iter()
        .map(|output| {
            let (mut error, mut square, mut inside, mut all) = (0.0, 0.0, 0.0, 0.0);
            for column in model.columns_of(output) {
                let curve = &prediction.curves[column];
                for (k, share) in shares.iter().enumerate() {
                    let exact = measured[column][k];
                    error += share * (curve.mean[k] - exact).powi(2);
                    square += share * exact * exact;
                    let slight = 1e-9 * (1.0 + exact.abs());
                    let is_inside = curve.lower[k] - slight <= exact && exact <= curve.upper[k] + slight;
                    inside += share * f64::from(u8::from(is_inside));
                    all += share;
                }
            }
            CheckedOutput {
                column: output.column.into(),
                meaning: output.meaning,
                error: (error / square).sqrt(),
                held: inside / all,
            }
        })
        .collect();
    let sample = prediction.inputs.iter().filter(|input| input.name.starts_with("sample."));
    let sample: Vec<(String, f64)> = sample.map(|input| (input.name.clone(), input.value)).collect();
    let made = sample.iter().find(|(name, _)| name == VOID_RATIO).map(|(_, value)| *value);
    let missed = known.get(VOID_RATIO).zip(made).filter(|(given, made)| (given - made).abs() > SLIGHT);
    Ok(Checked {
        grains: case.grains.count,
        sample,
        missed: missed.map(|(given, _)| given),
        outputs,
        drawn: Some(Drawn { prediction, measured }),
    })
}

/// The case of the test: that of the family with what is known.
fn case(
    context: &Context,
    model: &FamilyModel,
    known: &KnownNumbers,
    inputs: &[Option<f64>],
    grains: Option<usize>,
) -> Result<Case, Failure> {
    let family = model.definition();
    let ready = ReadyCase::named(family.case)
        .ok_or_else(|| Failure::new(format!("there is no ready case {} for the check", family.case)))?;
    let mut case = Case::parse_as(ready.text, family.case, context.reading())?;
    for (key, value) in family.settings {
        match *key {
            "path" => case = case.with_path(value, &[])?,
            key => case.set(key, value)?,
        }
    }
    let rolls = case.parameters().iter().any(|parameter| parameter.key == "contact.rolling_friction");
    let mut set = |key: &str, value: f64| {
        let unit = match field(key) {
            Some(field) => field.si_unit(),
            None if key.ends_with("stress") => "Pa".into(),
            None => String::new(),
        };
        case.set(key, format!("{} {unit}", format_number(value)).trim_end())
    };
    // What the sample is like decides what is not given, and a void ratio is looked for.
    let typical = model.predict(inputs, LEVEL)?;
    for (input, used) in family.inputs.iter().zip(&typical.inputs) {
        match (input.key, input.over) {
            (key, []) if !key.starts_with("sample.") => set(key, used.value)?,
            _ => {}
        }
    }
    for (key, value) in &known.0 {
        let is_of_test =
            family.inputs.iter().any(|input| input.key == key || input.over.contains(&key.as_str()));
        if is_of_test && !key.starts_with("sample.") {
            set(key, *value)?;
        }
        if key == STRESS {
            family.stress_keys.iter().try_for_each(|(key, factor)| set(key, factor * value))?;
        }
    }
    // With the resistance to rolling of samples like it, a void ratio is met by the friction.
    let of = |name: &str| typical.inputs.iter().find(|input| input.name == name).map(|input| input.value);
    let part = of("preparation_ratio").unwrap_or(0.0).clamp(0.0, 1.0);
    for (key, own) in [
        (PREPARATION_FRICTION, "grains.material.friction"),
        ("preparation.rolling_friction", "contact.rolling_friction"),
    ] {
        // Grains without a law of rolling have no coefficients of it.
        if own != "contact.rolling_friction" || rolls {
            set(key, part * known.get(own).unwrap_or(0.0))?;
        }
    }
    // Cohesive grains are so while the sample is made as well.
    if let Some(energy) = known.get("grains.material.interface_energy") {
        set("preparation.interface_energy", energy)?;
    }
    if let Some(ratio) = known.get(VOID_RATIO).filter(|_| known.get(PREPARATION_FRICTION).is_none()) {
        set("preparation.void_ratio", ratio)?;
        case.set(PREPARATION_FRICTION, "auto")?;
    }
    if let Some(grains) = grains {
        case.set("grains.count", &grains.to_string())?;
    }
    case.check()?;
    Ok(case)
}

impl Drawn {
    /// The measured curve of each column, and the prediction for the sample that was made.
    fn curves_as_json(&self) -> Vec<(String, Value)> {
        let of_curve = |(k, curve): (usize, &granum_learn::family::FamilyCurve)| {
            let values = json!({
                "measured": self.measured[k],
                "mean": curve.mean,
                "lower": curve.lower,
                "upper": curve.upper,
            });
            (curve.column.clone(), values)
        };
        self.prediction.curves.iter().enumerate().map(of_curve).collect()
    }
}

impl Checked {
    /// Number of the grains of the sample.
    pub fn grains(&self) -> usize {
        self.grains
    }

    pub fn lines(&self) -> Vec<String> {
        let sample: Vec<String> = self
            .sample
            .iter()
            .map(|(name, value)| {
                format!("{} {}", name.trim_start_matches("sample.").replace('_', " "), short(*value))
            })
            .collect();
        if self.drawn.is_none() {
            return vec![
                String::new(),
                "check: the test ended before the curves do, and cannot be compared with them".into(),
            ];
        }
        let mut lines = vec![
            String::new(),
            format!("check: a sample of {} grains was made ({}) and tested;", self.grains, sample.join(", ")),
            "the prediction for it was off by (root mean square over that of the measured values), and its intervals held:".into(),
        ];
        if let Some(given) = self.missed {
            let text = format!("(the void ratio {} that was asked for could not be reached)", short(given));
            lines.insert(2, text);
        }
        lines.extend(self.outputs.iter().map(|output| {
            let error = words::percent(output.error, 1);
            format!("  {error:>8}, {:>3.0} % of the states: {}", 100.0 * output.held, output.meaning)
        }));
        lines
    }

    pub fn as_json(&self) -> Value {
        let outputs = self.outputs.iter().map(
            |output| json!({ "output": output.column, "relative_error": output.error, "held": output.held }),
        );
        let sample = self.sample.iter().map(|(name, value)| (name.clone(), json!(value)));
        let curves: Map<String, Value> = self.drawn.iter().flat_map(Drawn::curves_as_json).collect();
        json!({
            "grains": self.grains,
            "sample": sample.collect::<serde_json::Map<String, Value>>(),
            "void_ratio_missed": self.missed,
            "complete": self.drawn.is_some(),
            "curves": curves,
            "outputs": outputs.collect::<Vec<_>>(),
        })
    }
}
