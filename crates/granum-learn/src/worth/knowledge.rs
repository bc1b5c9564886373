//! What is known of a test when an output is predicted.

use serde::{Deserialize, Serialize};

use super::plan::WorthPlan;

/// Where the values of the sensors come from when unseen runs are predicted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Source {
    /// They are measured on the run itself.
    #[default]
    Measured,
    /// They are those of other unseen runs at the same coordinate.
    OtherRun,
    /// They are those of the run itself, permuted over its states.
    Permuted,
    /// They are predicted from the properties.
    Predicted,
}

/// What is known of a test when an output is predicted.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Knowledge {
    /// In words: `strain`, `strain + deviator_fabric`, `properties + sensors`.
    pub name: String,
    /// The measured columns beside the coordinate; the name of a histogram stands for all of its bins.
    pub measured: Vec<String>,
    /// True if the properties of the grains and of the packing are known.
    pub properties: bool,
    /// Where the measured columns come from.
    pub source: Source,
}

impl Knowledge {
    fn new(name: impl Into<String>, measured: &[String], properties: bool) -> Knowledge {
        Knowledge { name: name.into(), measured: measured.to_vec(), properties, source: Source::Measured }
    }

    fn from(self, source: Source) -> Knowledge {
        let words = match source {
            Source::Measured => "",
            Source::OtherRun => " of another run",
            Source::Permuted => ", permuted",
            Source::Predicted => "",
        };
        Knowledge { name: format!("{}{words}", self.name), source, ..self }
    }

    /// Everything from which a quantity of the laboratory is predicted.
    pub(super) fn of_sensors(plan: &WorthPlan) -> Vec<Knowledge> {
        let sensors = &plan.sensors;
        let mut all = vec![Knowledge::new("strain alone", &[], false)];
        all.extend(
            sensors.iter().map(|sensor| {
                Knowledge::new(format!("strain + {sensor}"), std::slice::from_ref(sensor), false)
            }),
        );
        if sensors.len() > 2 {
            let pair = &sensors[..2];
            all.push(Knowledge::new(format!("strain + {}", pair.join(" + ")), pair, false));
        }
        let with_all = Knowledge::new("strain + all sensors", sensors, false);
        all.extend([Source::OtherRun, Source::Permuted].map(|source| with_all.clone().from(source)));
        all.push(with_all);
        if !plan.properties.is_empty() {
            all.push(Knowledge::new("properties", &[], true));
            all.push(Knowledge {
                source: Source::Predicted,
                ..Knowledge::new("cascade: properties, sensors predicted from them", sensors, true)
            });
            let both = Knowledge::new("properties + all sensors", sensors, true);
            all.extend([both.clone(), both.from(Source::OtherRun)]);
        }
        all
    }

    /// Everything from which a sensor is predicted.
    pub(super) fn of_outputs(plan: &WorthPlan) -> Vec<Knowledge> {
        let outputs = &plan.outputs;
        let mut all = vec![Knowledge::new("strain alone", &[], false)];
        if outputs.len() > 1 {
            all.extend(outputs.iter().map(|output| {
                Knowledge::new(format!("strain + {output}"), std::slice::from_ref(output), false)
            }));
        }
        all.push(Knowledge::new(format!("strain + {}", outputs.join(" + ")), outputs, false));
        if !plan.properties.is_empty() {
            all.push(Knowledge::new("properties", &[], true));
            all.push(Knowledge::new(format!("properties + {}", outputs.join(" + ")), outputs, true));
        }
        all
    }

    /// The inputs of a surrogate with this knowledge.
    pub(super) fn inputs(&self, plan: &WorthPlan) -> Vec<String> {
        let mut inputs = vec![plan.coordinate.clone()];
        if self.properties {
            inputs.extend(plan.properties.iter().filter(|name| **name != plan.coordinate).cloned());
        }
        // A cascade predicts its sensors.
        if self.source != Source::Predicted {
            inputs.extend(self.measured.iter().filter(|name| **name != plan.coordinate).cloned());
        }
        inputs
    }

    /// True if another knowledge is answered by the same surrogate.
    pub(super) fn is_same_surrogate(&self, other: &Knowledge) -> bool {
        let cascade = |knowledge: &Knowledge| knowledge.source == Source::Predicted;
        self.measured == other.measured
            && self.properties == other.properties
            && cascade(self) == cascade(other)
    }
}
