//! The measures of a finished test as lines of text.

use granum_core::words;
use granum_io::RunRecord;
use granum_run::strength::{COHESIVE, SECANT_REMARK, flow_class};

/// What a test says of its material, in a few lines.
pub fn lines(record: &RunRecord) -> Vec<String> {
    let of = Measures(record);
    let powder = [of.unconfined_strength(), of.tensile_strength()];
    [of.peak_and_late(), of.liquefaction(), of.cycles(), of.strength(), of.cohesion(), of.critical_state()]
        .into_iter()
        .chain(powder)
        .flatten()
        .collect()
}

struct Measures<'a>(&'a RunRecord);

impl Measures<'_> {
    fn value(&self, name: &str) -> Option<f64> {
        self.0.measures.get(name).copied()
    }

    /// Peak and late values of the stress ratio, the fabric and the density.
    fn peak_and_late(&self) -> Option<String> {
        let value = |name: &str| self.value(name);
        let (name, peak, late) = match (value("peak_stress_ratio"), value("peak_von_mises_ratio")) {
            (Some(peak), _) => ("q/p", peak, value("late_stress_ratio")),
            (None, peak) => ("q_vM/p", peak?, value("late_von_mises_ratio")),
        };
        let (strain, at) = match (value("deviator_strain_at_peak"), value("deviatoric_strain_at_peak")) {
            (Some(at), _) => ("deviator", at),
            (None, at) => ("deviatoric", at?),
        };
        let late: Vec<String> = [
            late.map(|ratio| format!("{name} {ratio:.3}")),
            value("late_deviator_fabric").map(|fabric| format!("phi_d {fabric:.4}")),
            value("late_solid_fraction").map(|solid| format!("solid fraction {solid:.4}")),
        ]
        .into_iter()
        .flatten()
        .collect();
        let means = match late.is_empty() {
            true => String::new(),
            false => format!("; means over the last quarter of the strain: {}", late.join(", ")),
        };
        Some(format!("test: peak {name} {peak:.3} at {strain} strain {at:.4}{means}"))
    }

    /// Whether and when an undrained sample liquefied.
    fn liquefaction(&self) -> Option<String> {
        let largest = self.value("largest_pore_pressure_ratio")?;
        let cycles = self.value("cycles_to_liquefaction");
        if self.value("liquefied")? == 0.0 {
            return Some(format!(
                "undrained: the sample did not liquefy; pore pressure ratio r_u = 1 - p/p_0 up to {largest:.3}"
            ));
        }
        let strain = ["axial", "deviatoric"].into_iter().find_map(|kind| {
            let strain = self.value(&format!("{kind}_strain_at_liquefaction"))?;
            Some(format!(
                " at {} {kind} strain of {}",
                if kind == "axial" { "an" } else { "a" },
                words::percent(strain, 3)
            ))
        });
        let when = match cycles {
            Some(cycles) => format!(" after {cycles} cycles ({})", self.criteria()),
            None => format!(" (r_u = 0.95){}", strain.unwrap_or_default()),
        };
        Some(format!(
            "liquefied{when}; r_u = 1 - p/p_0 up to {largest:.3}. Peaks are those of states with 5 % of p_0 or more"
        ))
    }

    /// The cycles to each criterion of liquefaction.
    fn criteria(&self) -> String {
        let of = |name: &str, what: &str| match self.value(name) {
            Some(cycles) => format!("{what}: {cycles}"),
            None => format!("{what}: not reached"),
        };
        let pressure = of("cycles_to_pore_pressure_ratio_95", "r_u = 0.95");
        format!(
            "{pressure}; {}",
            of("cycles_to_double_amplitude_5_percent", "double amplitude of 5 % axial strain")
        )
    }

    fn cycles(&self) -> Option<String> {
        let cycles = self.value("cycles")?;
        let amplitude = self.value("double_amplitude_axial_strain").map_or(String::new(), |value| {
            format!(", largest double amplitude of the axial strain {:.3} %", 100.0 * value)
        });
        Some(format!("cycles: {cycles}{amplitude}"))
    }

    fn strength(&self) -> Option<String> {
        let degrees = |name: &str, what: &str| Some(format!("{what} {:.1} deg", self.value(name)?));
        let modulus = |name: &str, what: &str| Some(format!("{what} {:.3} MPa", self.value(name)? / 1e6));
        let parts: Vec<String> = [
            degrees("peak_friction_angle", "peak friction angle"),
            degrees("critical_friction_angle", "late"),
            degrees("largest_dilatancy_angle", "largest dilatancy angle"),
            modulus("secant_modulus_50", "E50"),
            modulus("secant_modulus_50_at_least", "E50 at least"),
            modulus("undrained_secant_modulus_50", "undrained E50"),
            modulus("undrained_secant_modulus_50_at_least", "undrained E50 at least"),
        ]
        .into_iter()
        .flatten()
        .collect();
        (!parts.is_empty()).then(|| format!("strength: {}", parts.join(", ")))
    }

    /// Unconfined yield strength of a powder, with its class.
    fn unconfined_strength(&self) -> Option<String> {
        let (strength, bound) = match self.value("unconfined_yield_strength") {
            Some(strength) => (strength, ""),
            None => (self.value("unconfined_yield_strength_at_least")?, "at least "),
        };
        let after = self.value("consolidation_stress").map_or(String::new(), |stress| {
            format!(" after a consolidation stress of {:.3} kPa", stress / 1e3)
        });
        let class = match self.value("flow_function_coefficient") {
            Some(coefficient) => format!(": ff_c {coefficient:.2}, {}", flow_class(coefficient)),
            None if strength == 0.0 => format!(": no cohesion, {}", flow_class(f64::INFINITY)),
            None => "; it still increases at the end: more axial_strain shows its peak".into(),
        };
        Some(format!("powder: unconfined yield strength {bound}{:.3} kPa{after}{class}", strength / 1e3))
    }

    fn tensile_strength(&self) -> Option<String> {
        Some(format!("tensile strength: {:.4} kPa", self.value("tensile_strength")? / 1e3))
    }

    /// What the friction angles of cohesive grains are.
    fn cohesion(&self) -> Option<String> {
        self.value("peak_friction_angle")?;
        self.value(COHESIVE).map(|_| format!("remark: {SECANT_REMARK} (granum compare)"))
    }

    /// The late state, and how much it still changes in ten per cent of strain.
    fn critical_state(&self) -> Option<String> {
        let (void, p) = (self.value("critical_void_ratio")?, self.value("critical_mean_stress")?);
        let drift = |name: &str| self.value(name).unwrap_or(f64::NAN) * 0.1;
        let is_critical = match self.value("at_critical_state") {
            Some(1.0) => ": a critical state, within the limits of critical_state",
            Some(_) => ": not a critical state, within the limits of critical_state",
            None => "",
        };
        Some(format!(
            "late state: void ratio {void:.4} at p {:.2} kPa, drifting by {} and {} kPa in 10 % of deviatoric strain (0 at the \
             critical state){is_critical}",
            p / 1e3,
            words::signed(drift("critical_void_ratio_drift"), 4),
            words::signed(drift("critical_mean_stress_drift") / 1e3, 2),
        ))
    }
}
