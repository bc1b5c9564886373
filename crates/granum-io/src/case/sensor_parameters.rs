//! Parameters of sensors that granum does not have: those of sensors that a program has added, and those that the record of another
//! program's run gives.

use toml::de::DeValue;

use super::definition::Case;
use super::field::Field;

impl Case {
    /// The given parameters of sensors that are not among granum's, in the order of their keys.
    pub(super) fn parameters_of_other_sensors(&self) -> Vec<(&str, f64)> {
        self.parameters_where(|field| !field.is_of_granum_sensor())
    }

    /// The given parameters that no known sensor declares, in the order of their keys.
    pub(super) fn undeclared_parameters(&self) -> Vec<(&str, f64)> {
        self.parameters_where(|field| !field.is_of_sensor())
    }

    /// Those of which this holds for the field of the same key, and those without a field.
    fn parameters_where(&self, wanted: impl Fn(&Field) -> bool) -> Vec<(&str, f64)> {
        let fields = self.fields();
        let is_wanted = |key: &str| fields.iter().filter(|field| field.key == key).all(|field| wanted(field));
        let given = self.recording.parameters.iter().map(|(key, value)| (key.as_str(), *value));
        given.filter(|(key, _)| is_wanted(key)).collect()
    }
}

/// The value of a key of `[recording]` that no known sensor declares: a finite number.
pub(super) fn undeclared(value: &DeValue<'_>) -> Option<f64> {
    let text = match value {
        DeValue::Float(number) => number.as_str(),
        DeValue::Integer(number) if number.radix() == 10 => number.as_str(),
        _ => return None,
    };
    text.replace('_', "").parse().ok().filter(|value: &f64| value.is_finite())
}

#[cfg(test)]
mod tests {
    use granum_core::quantity::Dimension;
    use granum_sensors::{Memory, OWN_KEYS, Observation, Sensor, SensorDescription, SensorParameter, Values};

    use super::*;
    use crate::case::{Fields, Reading, Vocabulary};

    const REACH: SensorParameter =
        SensorParameter::new("counting_reach", Dimension::LENGTH, 1e-4, [1e-9, 1.0], "Distance of the count");

    /// A sensor of a program that uses granum.
    struct Counting;
    impl Sensor for Counting {
        fn description(&self) -> SensorDescription {
            SensorDescription::new("counting", "counts").parameters([REACH])
        }
        fn measure(&self, _: &Observation, _: &mut Memory, _: &mut Values) {}
    }

    #[test]
    fn the_keys_of_the_recording_itself_are_those_that_no_sensor_can_have() {
        for field in Fields::standard().iter().filter(|field| field.section == "recording") {
            assert_ne!(field.is_of_sensor(), OWN_KEYS.contains(&field.key), "{}", field.key);
        }
    }

    #[test]
    fn a_parameter_of_an_added_sensor_is_a_key_like_any_other() {
        let text = "[recording]\nsensors = ['counting']\ncounting_reach = '0.2 mm'\n";
        let recorded = "[recording]\ncounting_reach = 2e-4\nother_parameter = 3\nsensors = ['counting']\n";
        // A program that does not know the sensor reads what another has recorded, and nothing else.
        let error = Case::parse(text, "c").unwrap_err().to_string();
        assert!(error.contains("unknown key recording.counting_reach"), "{error}");
        let before = Case::parse_as(recorded, "c", Reading::recorded()).unwrap();
        let digest = before.digest();

        let vocabulary = Vocabulary::standard().with_sensor(Counting).unwrap();
        let parse = |text: &str| Case::parse_as(text, "c", Reading::default().with_vocabulary(&vocabulary));
        let recording = || Reading::recorded().with_vocabulary(&vocabulary);
        let case = parse(text).unwrap();
        assert_eq!(REACH.value(&case.recording), Some(2e-4));
        assert_eq!(parse(&case.resolved_toml()).unwrap(), case);
        assert_ne!(case.digest(), parse("[recording]\nsensors = ['counting']\n").unwrap().digest());
        let template = Case::template_with(&vocabulary);
        assert!(
            template
                .contains("# Distance of the count; of the sensor counting (from 1e-9 m to 1 m).\ncounting_reach = \"1e-4 m\""),
            "{template}"
        );
        assert_eq!(
            Case::schema_with(&vocabulary)["properties"]["recording"]["properties"]["counting_reach"]["default"],
            "1e-4 m"
        );
        let error = parse(&text.replace("0.2 mm", "2 m")).unwrap_err().to_string();
        assert!(
            error.contains(
                "c:3:18: recording.counting_reach = '2 m' is out of bounds; it must be from 1e-9 m to 1 m"
            ),
            "{error}"
        );
        // The default counts as not given.
        assert!(parse(&text.replace("0.2 mm", "0.1 mm")).unwrap().recording.parameters.is_empty());

        let after = Case::parse_as(recorded, "c", recording()).unwrap();
        assert_eq!((&after, after.digest()), (&before, digest));
        assert!(parse(recorded).unwrap_err().to_string().contains("unknown key recording.other_parameter"));
        let back = Case::parse_as(&after.resolved_toml(), "c", recording()).unwrap();
        assert_eq!(back, after);
        let other = after.parameters().into_iter().find(|found| found.key == "recording.other_parameter");
        assert_eq!(other.and_then(|found| found.number()), Some(3.0));
        assert_eq!(after.values()["recording.other_parameter"], "3");
    }

    /// The digests of cases that give parameters of sensors, as they were when these had places of their own.
    #[test]
    fn digests_of_cases_with_parameters_of_sensors_stay() {
        for (text, digest) in [
            (
                "bin_width = 0.1\nlargest_force = 8\n",
                "cfd67e897755e5c7a8f9773380b891b3b4f3cece765880e113aa0c8e01fbac3f",
            ),
            (
                "critical_void_ratio = 0.8\ncritical_slope = 0\nsensors = ['state_parameter']\n",
                "1235073077e103de689d149ee6ce4008991a7401147d479fc71c63d28a459d28",
            ),
            (
                "critical_exponent = 0.7\nbin_width = 0.25\n",
                "304ac0d6e32ec82f67bdbea6760cf960fe83c87a03ae8c19a58b2a481826cf93",
            ),
        ] {
            assert_eq!(Case::parse(&format!("[recording]\n{text}"), "c").unwrap().digest(), digest, "{text}");
        }
    }
}
