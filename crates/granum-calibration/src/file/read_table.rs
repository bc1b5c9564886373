//! Reading the table `[calibration]`.

use granum_campaign::plan::{Node, Reader};
use toml::de::{DeTable, DeValue};

use super::definition::{
    CalibrationTable, ComparedQuantity, CriticalStateOfTests, Method, PredictedTests, WHY_PREDICTIONS,
};
use super::words::word;
use crate::compared::quantity::Quantity;
use crate::inference::likelihood::Discrepancy;

/// The keys of the table.
const KEYS: [&str; 16] = [
    "tests",
    "predict",
    "method",
    "runs",
    "samples",
    "rounds",
    "confirm",
    "draws",
    "chains",
    "most_draws",
    "seed",
    "density",
    "critical_state",
    "stress_scale",
    "inadequacy",
    "quantity",
];
/// The keys of a quantity.
const QUANTITY_KEYS: [&str; 9] =
    ["name", "strains", "from", "to", "points", "weight", "absolute", "relative", "correlation_strain"];
/// Axial strains between which quantities are compared unless the file says otherwise, and their number.
const USUAL_STRAINS: ([f64; 2], usize) = ([0.005, 0.15], 16);
/// Samples of each simulation of a round unless the file says otherwise: the least that tell how samples scatter.
const USUAL_SAMPLES: u64 = 2;
/// Most strains of a quantity: the cost of the likelihood grows as their third power.
const MOST_STRAINS: u64 = 200;
const STRAIN_UNIT: &str = "";
/// Exponent of the critical state line of most sands (Li and Wang 1998).
const USUAL_EXPONENT: f64 = 0.7;

pub(super) fn table(reader: &mut Reader, node: Option<&Node>) -> Option<CalibrationTable> {
    let Some(node) = node else {
        let help = "add [calibration] and [[calibration.quantity]] with name = \"deviator_stress\"";
        reader.error(0..0, "the file has no table [calibration]", help);
        return None;
    };
    let table = as_table(reader, node, "calibration")?;
    reader.refuse_unknown(table, &KEYS, "calibration");
    let tests = table.get("tests").map_or(Some(Vec::new()), |node| names(reader, node, "tests"))?;
    let predict = match table.get("predict") {
        None => PredictedTests::Named(Vec::new()),
        Some(node) => predicted(reader, node)?,
    };
    let method = match table.get("method") {
        None => Method::Surrogate,
        Some(node) => word(reader, node, "method", &Method::ALL)?,
    };
    if let Some(node) =
        table.get("predict").filter(|_| method == Method::Dem && predict != PredictedTests::Named(Vec::new()))
    {
        let message = format!("predict needs a surrogate, since {WHY_PREDICTIONS}");
        reader.error(node.span(), message, "write method = \"surrogate\", or leave predict out");
    }
    if let Some(node) = table.get("samples").filter(|_| method == Method::Surrogate) {
        let message = "samples is for method = \"dem\": a surrogate learns the scatter of samples from runs that each have a sample of their own";
        reader.error(node.span(), message, "leave it out, or write method = \"dem\"");
    }
    let mut count = |key: &str, least: u64, most: u64, usual: u64| {
        reader.count(table, key, least, most).unwrap_or(usual) as usize
    };
    let (usual_runs, usual_rounds) = match method {
        Method::Surrogate => (80, 3),
        Method::Dem => (32, 10),
    };
    let [runs, rounds] = [count("runs", 8, 100_000, usual_runs), count("rounds", 1, 1000, usual_rounds)];
    let samples = count("samples", 1, 100, USUAL_SAMPLES);
    let [confirm, draws] = [count("confirm", 0, 1000, 4), count("draws", 1, 100_000, 20)];
    let [chains, most_draws] = [count("chains", 2, 64, 4), count("most_draws", 1000, 10_000_000, 100_000)];
    let seed = count("seed", 0, u64::from(u32::MAX), 1) as u32;
    let void_ratio_limits = table.get("density").and_then(|node| limits(reader, node));
    let critical_state = table.get("critical_state").and_then(|node| critical_state(reader, node));
    let stress_scale = table.get("stress_scale").and_then(|node| stress_scale(reader, node));
    let inadequacy = match table.get("inadequacy") {
        None => Some(Discrepancy::default()),
        Some(node) => inadequacy(reader, node),
    };
    let quantities = quantities(reader, node, table)?;
    Some(CalibrationTable {
        tests,
        tests_span: table.get("tests").map_or(node.span(), |node| node.span()),
        predict,
        predict_span: table.get("predict").map_or(node.span(), |node| node.span()),
        method,
        runs,
        samples,
        rounds,
        confirm,
        draws,
        chains,
        most_draws,
        seed,
        void_ratio_limits,
        critical_state,
        stress_scale,
        inadequacy,
        quantities,
    })
}

fn stress_scale(reader: &mut Reader, node: &Node) -> Option<f64> {
    let scale = reader.number(node, "stress_scale", "Pa")?;
    if !(scale > 0.0 && scale.is_finite()) {
        let help = "give a stress of the size of the strength, as stress_scale = \"1 MPa\"";
        reader.error(node.span(), format!("stress_scale = {scale} must be positive"), help);
        return None;
    }
    Some(scale)
}

fn names(reader: &mut Reader, node: &Node, key: &str) -> Option<Vec<String>> {
    let items = reader.array(node, key)?.iter();
    items.map(|item| reader.text(item, key)).collect()
}

/// The tests that are predicted: their names, or the word for all others.
fn predicted(reader: &mut Reader, node: &Node) -> Option<PredictedTests> {
    match node.get_ref() {
        DeValue::String(word) if &**word == PredictedTests::OTHERS => Some(PredictedTests::Others),
        DeValue::String(word) => {
            let message = format!("predict = {:?} is no list of tests", &**word);
            let help = "write predict = [\"NAME\"], or predict = \"others\" for all tests that are not calibrated on";
            reader.error(node.span(), message, help);
            None
        }
        _ => names(reader, node, "predict").map(PredictedTests::Named),
    }
}

fn as_table<'a>(reader: &mut Reader, node: &'a Node<'a>, key: &str) -> Option<&'a DeTable<'a>> {
    if let DeValue::Table(table) = node.get_ref() {
        return Some(table);
    }
    reader.error(node.span(), format!("{key} must be a table"), "");
    None
}

fn limits(reader: &mut Reader, node: &Node) -> Option<[f64; 2]> {
    let table = as_table(reader, node, "density")?;
    reader.refuse_unknown(table, &["densest_void_ratio", "loosest_void_ratio"], "density");
    let mut number = |key: &str| match table.get(key) {
        Some(node) => reader.number(node, key, ""),
        None => {
            reader.error(node.span(), format!("density needs {key}"), "");
            None
        }
    };
    let [densest, loosest] = [number("densest_void_ratio")?, number("loosest_void_ratio")?];
    if !(0.0 < densest && densest < loosest) {
        let message = format!(
            "densest_void_ratio = {densest} must be above 0 and below loosest_void_ratio = {loosest}"
        );
        reader.error(node.span(), message, "");
        return None;
    }
    Some([densest, loosest])
}

/// The critical state line of the laboratory.
fn critical_state(reader: &mut Reader, node: &Node) -> Option<CriticalStateOfTests> {
    let table = as_table(reader, node, "critical_state")?;
    reader.refuse_unknown(table, &["void_ratio", "slope", "exponent"], "critical_state");
    let needed = ["void_ratio", "slope"].into_iter().find(|key| !table.contains_key(*key));
    if let Some(key) = needed {
        let help =
            "e_c = void_ratio - slope (p / 101.325 kPa)^exponent, with an exponent of 0.7 unless it is given";
        reader.error(node.span(), format!("critical_state needs {key}"), help);
        return None;
    }
    let void_ratio = positive(reader, table, "void_ratio", 1.0)?;
    let slope = positive(reader, table, "slope", 0.02)?;
    let exponent = positive(reader, table, "exponent", USUAL_EXPONENT)?;
    Some(CriticalStateOfTests { void_ratio, slope, exponent })
}

/// The inadequacy; `false` for a model that is taken to be right.
fn inadequacy(reader: &mut Reader, node: &Node) -> Option<Discrepancy> {
    if let DeValue::Boolean(is_free) = node.get_ref() {
        return is_free.then(Discrepancy::default);
    }
    let table = as_table(reader, node, "inadequacy")?;
    reader.refuse_unknown(table, &["scale", "correlation_strain"], "inadequacy");
    let usual = Discrepancy::default();
    let scale = positive(reader, table, "scale", usual.scale)?;
    let correlation_strain = positive(reader, table, "correlation_strain", usual.correlation_strain)?;
    Some(Discrepancy { scale, correlation_strain })
}

fn positive(reader: &mut Reader, table: &DeTable, key: &str, usual: f64) -> Option<f64> {
    let Some(node) = table.get(key) else { return Some(usual) };
    let number = reader.number(node, key, "")?;
    if number > 0.0 && number.is_finite() {
        return Some(number);
    }
    reader.error(node.span(), format!("{key} = {number} must be above 0"), "");
    None
}

fn quantities(reader: &mut Reader, whole: &Node, table: &DeTable) -> Option<Vec<ComparedQuantity>> {
    let Some(node) = table.get("quantity") else {
        let help = "add [[calibration.quantity]] with name = \"deviator_stress\"";
        reader.error(whole.span(), "nothing is compared", help);
        return None;
    };
    let DeValue::Array(items) = node.get_ref() else {
        reader.error(node.span(), "quantity must be a list of tables", "write [[calibration.quantity]]");
        return None;
    };
    let mut found: Vec<ComparedQuantity> = Vec::new();
    for item in items.iter() {
        let Some(compared) = quantity(reader, item) else { continue };
        if found.iter().any(|known| known.quantity == compared.quantity) {
            let message = format!("{} is compared twice", compared.quantity.word());
            reader.error(item.span(), message, "put all of its strains into one of them");
            continue;
        }
        found.push(compared);
    }
    Some(found)
}

fn quantity(reader: &mut Reader, item: &Node) -> Option<ComparedQuantity> {
    let table = as_table(reader, item, "quantity")?;
    reader.refuse_unknown(table, &QUANTITY_KEYS, "quantity");
    let Some(node) = table.get("name") else {
        let words = Quantity::ALL.map(Quantity::word);
        reader.error(item.span(), "a quantity needs its name", &format!("one of {}", words.join(", ")));
        return None;
    };
    let known = Quantity::ALL.map(|quantity| (quantity, quantity.word()));
    let quantity = word(reader, node, "name", &known)?;
    let strains = strains(reader, item, table)?;
    let weight = positive(reader, table, "weight", 1.0)?;
    let mut error = quantity.usual_error();
    for (key, unit, value) in [
        ("absolute", quantity.unit(), &mut error.absolute),
        ("relative", "", &mut error.relative),
        ("correlation_strain", STRAIN_UNIT, &mut error.correlation_strain),
    ] {
        let Some(node) = table.get(key) else { continue };
        let number = reader.number(node, key, unit)?;
        if !(number >= 0.0 && number.is_finite()) {
            reader.error(node.span(), format!("{key} = {number} must not be negative"), "");
            return None;
        }
        *value = number;
    }
    if error.absolute == 0.0 && error.relative == 0.0 {
        let help = "give the error of measurement an absolute part";
        reader.error(item.span(), format!("{} would be measured without any error", quantity.word()), help);
        return None;
    }
    Some(ComparedQuantity { quantity, strains, weight, error, span: item.span() })
}

/// The strains: a list, or so many points with equal distances.
fn strains(reader: &mut Reader, item: &Node, table: &DeTable) -> Option<Vec<f64>> {
    if let Some(node) = table.get("strains") {
        if let Some(key) = ["from", "to", "points"].iter().find(|key| table.contains_key(**key)) {
            let message = format!("strains are given by the list and by {key}");
            reader.error(node.span(), message, "keep one of them");
            return None;
        }
        let items = reader.array(node, "strains")?.iter();
        let found =
            items.map(|item| reader.number(item, "strains", STRAIN_UNIT)).collect::<Option<Vec<_>>>()?;
        if found.len() as u64 > MOST_STRAINS {
            let message = format!("there are {} strains; at most {MOST_STRAINS} are possible", found.len());
            reader.error(node.span(), message, "");
            return None;
        }
        let rise = found.windows(2).all(|pair| pair[1] > pair[0]);
        if found.is_empty() || !rise || found[0] <= 0.0 || found[found.len() - 1] >= 1.0 {
            let help = "write e.g. strains = [\"1 %\", \"2 %\", \"5 %\", \"10 %\"]";
            reader.error(node.span(), "strains must be above 0, rise, and stay below 1", help);
            return None;
        }
        return Some(found);
    }
    let ([usual_from, usual_to], usual_points) = USUAL_STRAINS;
    let from = positive(reader, table, "from", usual_from)?;
    let to = positive(reader, table, "to", usual_to)?;
    let points = reader.count(table, "points", 2, MOST_STRAINS).unwrap_or(usual_points as u64) as usize;
    if !(from < to && to < 1.0) {
        let message =
            format!("strains from {from} to {to}: the first must be below the last, which is below 1");
        reader.error(item.span(), message, "");
        return None;
    }
    let step = (to - from) / (points - 1) as f64;
    Some((0..points).map(|k| if k + 1 == points { to } else { from + step * k as f64 }).collect())
}
