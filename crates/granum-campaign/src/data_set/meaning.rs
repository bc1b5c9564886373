//! The meanings of the columns of a data set.

use granum_io::Case;
use granum_run::derived_columns::histogram_of_density;
use granum_sensors::Sensors;

use super::layout::{BIN_WIDTH, BINS, CHECK, COUNTED, FIRST_BIN, LIMIT, MEASURE, QUANTITY, VARIABLE};

/// Columns with a meaning of their own.
const KNOWN: [(&str, &str); 26] = [
    ("run", "name of the run: the first digits of the digest of its case"),
    ("states", "number of recorded states"),
    ("grains", "number of grains"),
    ("seed", "seed of the sample"),
    ("passed", "true if the run passed every check"),
    ("checks_failed", "number of checks that the run did not pass"),
    ("failed_checks", "names of the checks that the run did not pass"),
    ("case_digest", "SHA-256 of the case"),
    ("preparation_digest", "SHA-256 of the part of the case that determines the sample"),
    ("digest", "SHA-256 of all results of the run, as granum digest prints it"),
    ("granum_version", "version of granum that executed the run"),
    ("engine", "engine that executed the run"),
    ("engine_version", "version of the engine; empty for granum's own"),
    ("settings", "the keys that the run sets over the base case in case.toml, in their order, as JSON"),
    ("stage", "number of the stage of the test, from 1"),
    ("state", "number of the state in its stage, from 0, the state in which the stage began"),
    ("observations", "number of observations over which the state is averaged"),
    ("arc_length", "arc length of the strain path up to the state"),
    ("seconds", "wall time of the run"),
    ("system", "operating system and processor family"),
    ("instruction_set", "instruction set in use"),
    ("threads", "number of threads in use"),
    ("void_ratio", "volume of voids over volume of grains"),
    ("solid_fraction", "volume of grains over volume of the cell"),
    ("grains.count", "number of grains"),
    ("preparation.seed", "seed of the sample"),
];

/// The meaning of a column of a data set, of a series or of a table of runs, in a line; empty where its name is all that is known.
pub fn of_column(name: &str, base: &Case, sensors: &Sensors) -> String {
    let measured = |name: &str| {
        let known = sensors.columns().find(|column| column.name == name);
        known.map(|column| column.description.to_string())
    };
    let key = || base.fields().named(name).map(|field| field.help.clone());
    if let Some((_, meaning)) = KNOWN.iter().find(|(known, _)| *known == name) {
        return (*meaning).to_string();
    }
    if let Some(meaning) = key() {
        return meaning;
    }
    if let Some(variable) = name.strip_prefix(VARIABLE) {
        return format!("variable {variable} of the plan");
    }
    if let Some(own) = name.strip_prefix("sample.") {
        return format!(
            "of the sample before the test: {}",
            measured(own).unwrap_or_else(|| own.replace('_', " "))
        );
    }
    if let Some(own) = name.strip_prefix(MEASURE) {
        let words = || measured(own).unwrap_or_else(|| own.replace('_', " "));
        return KNOWN
            .iter()
            .find(|(known, _)| *known == own)
            .map_or_else(words, |(_, meaning)| (*meaning).to_string());
    }
    if let Some(check) = name.strip_prefix(CHECK) {
        return match check.strip_suffix(LIMIT) {
            Some(check) => format!("largest value with which the check {check} passes"),
            None => format!("value that the check {check} found"),
        };
    }
    if let Some(histogram) = name.strip_suffix(COUNTED) {
        return format!(
            "number of values that the histogram {histogram} counted, those outside its bins included"
        );
    }
    if let Some(histogram) = name.strip_suffix(BIN_WIDTH) {
        return format!("width w of the bins of the histogram {histogram}");
    }
    if let Some(histogram) = name.strip_suffix(FIRST_BIN) {
        return format!(
            "number b of the first bin of the histogram {histogram}; bin k, from 0, has the centre (b + k + 1/2) w"
        );
    }
    if let Some(histogram) = name.strip_suffix(BINS) {
        return format!("number of bins of the histogram {histogram}");
    }
    if let Some(histogram) = name.strip_suffix(QUANTITY) {
        return format!("what the histogram {histogram} counts");
    }
    if let Some(end) =
        ["_below", "_above"].iter().find_map(|end| name.strip_suffix(end).map(|own| (own, *end)))
    {
        return format!("number of values {} the bins of the histogram {}", &end.1[1..], end.0);
    }
    if let Some(phase) = name.strip_prefix("seconds.") {
        return format!("wall time of the phase {phase}");
    }
    measured(name).unwrap_or_default()
}

/// The meaning of a column of densities.
pub(super) fn of_list(name: &str) -> String {
    let histogram = histogram_of_density(name);
    format!(
        "probability density in each bin of the histogram {histogram}; its bins: {histogram}{BIN_WIDTH}, {histogram}{FIRST_BIN} of the run"
    )
}
