//! A named path: biaxial compression at constant mean stress in the plane. Axis x is compressed, `(sigma_x + sigma_y) / 2` is held,
//! and z is fixed.

use granum::path::*;

pub const BIAXIAL: Preset = Preset::new(
    "biaxial-at-constant-mean",
    "Plane strain: axis x is compressed, the mean of the stresses along x and y is held, and z is fixed.",
    &[number("axial_strain", "Strain along x at the end.", 0.2, [1e-6, 1.0]), INERTIAL_NUMBER, STATES],
    |values| {
        let end = values.number("axial_strain");
        let (free, fixed) = (Drive::Free, Drive::Fixed);
        let mean = Constraint::stresses([0.5, 0.5, 0.0, 0.0, 0.0, 0.0], Target::current());
        let control =
            Control::new(values.speed(), [Drive::Rate(1.0), free, fixed, fixed, fixed, fixed]).with(mean);
        let until = Until::Reaches { measure: Measure::Strain(0), value: end };
        let record = RecordedStates::equal(Measure::Strain(0), values.states(), end);
        let stage = Stage::new("biaxial compression", control, vec![until]).recording(record);
        vec![stage.with(|stage| stage.resets = true)]
    },
);
