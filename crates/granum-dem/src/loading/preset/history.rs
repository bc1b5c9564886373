//! A history of strains or stresses from a file: the loading follows straight lines from row to row.

use super::{
    INERTIAL_NUMBER, PathParameter, PathParameterDefault, PathParameterKind, Preset, STATES, optional, word,
};
use crate::loading::{
    Control, Drive, History, HistoryQuantity, Measure, Ramp, RecordedStates, Speed, Stage, Target, Until,
};

pub(super) const PRESET: Preset = Preset {
    name: "history",
    help: "Strains or stresses from a CSV file, row by row: the cell follows straight lines between the rows.",
    own: PARAMETERS,
    faults: |_| None,
    stages: |values| {
        let Some(history) = values.history("file") else { return Vec::new() };
        let sign = if values.is("compression", "negative") { -1.0 } else { 1.0 };
        let record =
            values.optional("interval").map(|interval| RecordedStates::every(Measure::ArcLength, interval));
        let mut stages: Vec<Stage> = (history.rows.iter().enumerate())
            .map(|(k, row)| {
                let control = control(history, row, sign, values.speed());
                let stage = Stage::new(format!("row {}", k + 1), control, vec![Until::RampOver]);
                let record = record.clone().unwrap_or_default();
                Stage { resets: k == 0, most_arc_length: Some(0.5), record, ..stage }
            })
            .collect();
        stages.push(Stage::mark("end"));
        stages
    },
};

/// The control from the present state of the sample to a row.
fn control(history: &History, row: &[f64], sign: f64, speed: Speed) -> Control {
    let mut components = [Drive::Fixed; 6];
    for (column, value) in history.columns.iter().zip(row) {
        let end = Ramp::To(sign * value + 0.0);
        components[column.component()] = match column {
            HistoryQuantity::Strain(_) => Drive::Ramp(end),
            HistoryQuantity::Stress(_) => Drive::Stress(Target::ramp(end)),
        };
    }
    Control::new(speed, components)
}

const PARAMETERS: &[PathParameter] = &[
    PathParameter {
        key: "file",
        kind: PathParameterKind::History,
        help: "CSV file with columns among xx_strain, yy_strain, zz_strain, yz_strain, zx_strain, xy_strain and the same with \
               _stress, with units as in `xx_stress (kPa)`; strains are logarithmic and count from the start of the path. A column \
               time is accepted but not used: the response of the grains does not depend on it.",
        default: PathParameterDefault::Needed,
        ..STATES
    },
    word(
        "compression",
        "Sign of compression in the file.",
        &[
            ["positive", "as in granum and soil mechanics"],
            ["negative", "as in most finite-element programs"],
        ],
    ),
    PathParameter {
        help: "Speed: inertial number I of the largest strain rate at the mean stress at the start of each row. For \
               stresses the strain is estimated from the contacts.",
        ..INERTIAL_NUMBER
    },
    optional(
        "interval",
        "Arc length of strain between the states that are recorded between the rows.",
        "at the rows only",
        [1e-7, 1.0],
    ),
];
