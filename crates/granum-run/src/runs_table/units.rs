//! The SI units of measures, as far as they are known.

use granum_sensors::Sensors;

/// Measures whose unit follows neither from a sensor nor from their name.
const KNOWN: [(&str, &str); 3] =
    [("critical_mean_stress_drift", "Pa"), ("preparation_stress", "Pa"), ("mean_stress", "Pa")];
/// Words before and after the name of a quantity.
const BEFORE: [&str; 6] = ["peak_", "late_", "critical_", "largest_", "undrained_", "sample_"];
const AFTER: [&str; 3] = ["_at_peak", "_at_least", "_at_liquefaction"];

/// The unit of a measure; empty for a pure number, or where it is not known.
pub fn of_measure(name: &str, sensors: &Sensors) -> String {
    if let Some((_, unit)) = KNOWN.iter().find(|(known, _)| *known == name) {
        return (*unit).to_string();
    }
    let mut core = name;
    for after in AFTER {
        core = core.strip_suffix(after).unwrap_or(core);
    }
    for before in BEFORE {
        core = core.strip_prefix(before).unwrap_or(core);
    }
    let columns = sensors.descriptions().flat_map(|sensor| &sensor.columns);
    for column in columns {
        if column.name == name || column.name == core {
            return if column.unit == "1" { String::new() } else { column.unit.to_string() };
        }
    }
    match core {
        _ if core.ends_with("_angle") => "deg".into(),
        _ if core.contains("_modulus") || core.ends_with("_stress") => "Pa".into(),
        _ => String::new(),
    }
}
