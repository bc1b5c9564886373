//! A named path: plane strain. Axis x is compressed, the stress along y is held, and z is fixed.

use granum::path::*;

pub const PLANE_STRAIN: Preset = Preset {
    name: "plane-strain",
    help: "Plane strain: axis x is compressed, the stress along y is held, and z is fixed.",
    parameters: &[
        Parameter {
            key: "axial_strain",
            unit: "1",
            help: "Strain along x at the end.",
            default: Default::Value(0.2),
            bounds: [1e-6, 1.0],
        },
        INERTIAL_NUMBER,
        STATES,
    ],
    stages: |values| {
        let end = values.number("axial_strain");
        let (fixed, held) = (Drive::Fixed, Drive::Stress(Target::default()));
        let control = Control::of(values.speed(), [Drive::Rate(1.0), held, fixed, fixed, fixed, fixed]);
        let until = Until::Reaches { measure: Measure::Strain(0), value: end };
        let record = Record::equal(Measure::Strain(0), values.states(), end);
        vec![Stage { resets: true, ..Stage::new("plane strain", control, vec![until]).recording(record) }]
    },
};
