//! What each measure of a test is, for tables and legends.

/// What a measure is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Meaning {
    /// Its name in `run.json`.
    pub name: &'static str,
    /// Its unit: `deg`, `Pa`, or `1` for a number.
    pub unit: &'static str,
    /// Its symbol or a short name, with the markup of reports.
    pub symbol: &'static str,
    /// What it is, with its formula.
    pub meaning: &'static str,
}

const fn measure(
    name: &'static str,
    unit: &'static str,
    symbol: &'static str,
    meaning: &'static str,
) -> Meaning {
    Meaning { name, unit, symbol, meaning }
}

/// The measures of a test that a report shows, in its order.
///
/// Sources: the friction angle is that of Mohr and Coulomb; the dilatancy angle follows Schanz and Vermeer (1996); E50 Schanz, Vermeer
/// and Bonnier (1999); the critical state Roscoe, Schofield and Wroth (1958); liquefaction Seed and Lee (1966) and ASTM D5311; the unconfined yield strength and its ratio to the consolidation stress Jenike (1964).
pub const MEASURES: &[Meaning] = &[
    measure(
        "peak_friction_angle",
        "deg",
        "*φ*_{peak}",
        "peak friction angle: the largest of the states that carry stress; of cohesive grains that of a secant through the origin",
    ),
    measure(
        "critical_friction_angle",
        "deg",
        "*φ*_{late}",
        "critical friction angle: its mean over the last quarter of the strain",
    ),
    measure(
        "cohesive",
        "1",
        "cohesive",
        "1 where the grains attract each other: friction angles are then those of secants through the origin, and grow as the stress falls",
    ),
    measure(
        "peak_stress_ratio",
        "1",
        "peak *q*/*p*",
        "stress ratio of the largest magnitude, negative in extension",
    ),
    measure(
        "late_stress_ratio",
        "1",
        "late *q*/*p*",
        "mean stress ratio over the last quarter of the strain",
    ),
    measure(
        "peak_von_mises_ratio",
        "1",
        "peak *q*_{vM}/*p*",
        "largest ratio of the von Mises stress to the mean stress",
    ),
    measure(
        "late_von_mises_ratio",
        "1",
        "late *q*_{vM}/*p*",
        "mean ratio of the von Mises stress to the mean stress over the last quarter of the strain",
    ),
    measure(
        "axial_strain_at_peak",
        "1",
        "*ε*_{1} at the peak",
        "axial strain at the stress ratio of the largest magnitude, since the start of the test",
    ),
    measure(
        "largest_dilatancy_angle",
        "deg",
        "*ψ*_{max}",
        "largest dilatancy angle, over 1 % of strain, beyond a deviatoric strain of 0.5 %",
    ),
    measure(
        "critical_void_ratio",
        "1",
        "*e*_{late}",
        "critical void ratio: its mean over the last quarter of the strain",
    ),
    measure(
        "critical_void_ratio_drift",
        "1",
        "d*e*/d*ε*_{q}",
        "its drift there, per unit of deviatoric strain: zero at the critical state",
    ),
    measure("critical_mean_stress", "Pa", "*p*_{late}", "mean stress over the last quarter of the strain"),
    measure(
        "critical_mean_stress_drift",
        "Pa",
        "d*p*/d*ε*_{q}",
        "its drift there, per unit of deviatoric strain: zero at the critical state",
    ),
    measure(
        "at_critical_state",
        "1",
        "critical",
        "1 where the end of the test is a critical state, within the limits of the end condition critical_state",
    ),
    measure(
        "secant_modulus_50",
        "Pa",
        "*E*_{50}",
        "secant modulus of the drained triaxial test at half of the largest change of *q*",
    ),
    measure(
        "secant_modulus_50_at_least",
        "Pa",
        "*E*_{50}, at least",
        "lower bound of *E*_{50}: half of the largest change of *q* is reached before the second recorded state",
    ),
    measure(
        "undrained_secant_modulus_50",
        "Pa",
        "*E*_{u50}",
        "secant modulus of the undrained triaxial test at half of the largest change of *q*",
    ),
    measure(
        "undrained_secant_modulus_50_at_least",
        "Pa",
        "*E*_{u50}, at least",
        "lower bound of *E*_{u50}: half of the largest change of *q* is reached before the second recorded state",
    ),
    measure(
        "largest_pore_pressure_ratio",
        "1",
        "largest *r*_{u}",
        "largest ratio *r*_{u} = 1 − *p*/*p*_{0} of the excess pore pressure, since the start of the undrained part",
    ),
    measure(
        "axial_strain_at_liquefaction",
        "1",
        "*ε*_{1} at liquefaction",
        "axial strain at which *r*_{u} reaches 0.95",
    ),
    measure(
        "deviatoric_strain_at_liquefaction",
        "1",
        "*ε*_{q} at liquefaction",
        "deviatoric strain at which *r*_{u} reaches 0.95",
    ),
    measure("cycles", "1", "cycles", "number of cycles, counted in half cycles"),
    measure(
        "double_amplitude_axial_strain",
        "1",
        "double amplitude",
        "largest change of the axial strain since a turning point",
    ),
    measure(
        "cycles_to_liquefaction",
        "1",
        "*N*_{L}",
        "cycles to liquefaction: to *r*_{u} = 0.95 or to a double amplitude of 5 %, whichever comes first",
    ),
    measure(
        "cycles_to_pore_pressure_ratio_95",
        "1",
        "*N* (*r*_{u} = 0.95)",
        "cycles until *r*_{u} reaches 0.95",
    ),
    measure(
        "cycles_to_double_amplitude_5_percent",
        "1",
        "*N* (double amplitude 5 %)",
        "cycles until the double amplitude of the axial strain reaches 5 %",
    ),
    measure(
        "consolidation_stress",
        "Pa",
        "*σ*_{1}",
        "consolidation stress of a powder: the major principal stress, its mean over the last quarter of the strain of the pre-shear",
    ),
    measure(
        "unconfined_yield_strength",
        "Pa",
        "*σ*_{c}",
        "unconfined yield strength: the largest axial less lateral stress of a compression without lateral stress",
    ),
    measure(
        "unconfined_yield_strength_at_least",
        "Pa",
        "*σ*_{c}, at least",
        "lower bound of *σ*_{c}: the axial stress still increases at the end",
    ),
    measure(
        "flow_function_coefficient",
        "1",
        "*ff*_{c}",
        "flow function coefficient *σ*_{1}/*σ*_{c}: below 2 very cohesive, below 4 cohesive, below 10 easy-flowing, above free-flowing",
    ),
    measure(
        "axial_strain_at_failure",
        "1",
        "*ε*_{1} at failure",
        "axial strain at *σ*_{c}, since the start of the compression without lateral stress",
    ),
    measure(
        "tensile_strength",
        "Pa",
        "*σ*_{t}",
        "tensile strength: the largest tension of a stage that asks for more than the sample can carry",
    ),
];

/// What a measure is, by its name.
pub fn meaning(name: &str) -> Option<&'static Meaning> {
    MEASURES.iter().find(|known| known.name == name)
}
