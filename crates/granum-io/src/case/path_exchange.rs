//! What becomes of the test of a case when a named path takes its place.

use granum_core::quantity::format_number;
use granum_dem::loading::preset::{Given, PathParameter, PathParameterKind, PathValue, Preset};

use super::case_stage::CaseStage;
use super::case_test::{CaseTest, is_of_shear};
use super::definition::Case;

/// Keys that set the speed of a stage together: what sets it anew takes the place of all of them.
const SPEED: [&str; 3] = ["strain_rate", "inertial_number", "density_scaling"];

/// What becomes of the test of a case when a named path takes its place.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PathExchange {
    /// The test that is replaced, in words: the name of its path, or `[shear]`.
    pub test: String,
    /// Parameters that the case gives to its path and that the new path has, too, with their values as text.
    pub carried: Vec<(String, String)>,
    /// What the case gives to its test and the new path has no use for, with the values as text.
    pub replaced: Vec<(String, String)>,
    /// What the case has beside a single named path and no path can take over, in words.
    pub lost: Option<String>,
}

impl Case {
    /// What becomes of the test of this case when the path `name` takes its place with the parameters `set` of its own
    /// ([`Case::with_path`]); `None` if there is no such path.
    ///
    /// ```
    /// let case = granum_io::Case::parse("[[stage]]\npath = 'drained-triaxial'\naxial_strain = 0.3\nlateral_stress = 1e5\n", "sand.toml")?;
    /// let change = case.path_exchange("undrained-triaxial", &[]).expect("there is such a path");
    /// assert_eq!(change.carried, [("axial_strain".to_string(), "0.3".to_string())]);
    /// assert_eq!(change.replaced, [("lateral_stress".to_string(), "100000".to_string())]);
    /// # Ok::<(), granum_io::Error>(())
    /// ```
    pub fn path_exchange(&self, name: &str, set: &[&str]) -> Option<PathExchange> {
        let new = self.vocabulary.paths().named(name)?;
        Some(match &self.test {
            CaseTest::Shear(_) => PathExchange {
                test: "[shear]".into(),
                replaced: self.shear_keys_given(),
                ..PathExchange::default()
            },
            CaseTest::Stages(stages) => match stages.as_slice() {
                [CaseStage::Path { path, parameters, .. }] => exchange(path, parameters, new, set),
                [CaseStage::Control(_)] => PathExchange {
                    lost: Some("its stage with an explicit control".into()),
                    ..PathExchange::default()
                },
                [CaseStage::Repeat { .. }] => PathExchange {
                    lost: Some("its stage that repeats others".into()),
                    ..PathExchange::default()
                },
                all => PathExchange {
                    lost: Some(format!("all of its {} stages", all.len())),
                    ..PathExchange::default()
                },
            },
        })
    }

    /// The keys of `[shear]`, and those of the recording that belong to it, which differ from their defaults.
    fn shear_keys_given(&self) -> Vec<(String, String)> {
        let usual = Case { vocabulary: self.vocabulary.clone(), ..Case::default() };
        let fields = self.fields();
        let changed = fields
            .iter()
            .filter(|field| is_of_shear(&field.path()) && field.value(self) != field.value(&usual));
        changed.map(|field| (field.path(), field.shown(self))).collect()
    }
}

fn exchange(old: &Preset, parameters: &Given, new: &Preset, set: &[&str]) -> PathExchange {
    let mut change = PathExchange { test: old.name.to_string(), ..PathExchange::default() };
    let sets_speed = set.iter().any(|key| SPEED.contains(key));
    for parameter in old.parameters() {
        let key = parameter.key;
        let Some(value) = parameters.get(key).filter(|_| !set.contains(&key)) else { continue };
        let same = new
            .parameter(key)
            .filter(|same| is_alike(parameter, same) && !(sets_speed && SPEED.contains(&key)));
        match (text(value), same) {
            (Some(text), Some(_)) => change.carried.push((key.to_string(), text)),
            (text, _) => change.replaced.push((key.to_string(), text.unwrap_or_else(|| "...".into()))),
        }
    }
    change
}

/// True if a value of one parameter means the same as one of the other.
fn is_alike(a: &PathParameter, b: &PathParameter) -> bool {
    let same_kind = match (a.kind, b.kind) {
        (PathParameterKind::Word(a), PathParameterKind::Word(b)) => a == b,
        (a, b) => std::mem::discriminant(&a) == std::mem::discriminant(&b),
    };
    same_kind && a.unit == b.unit
}

/// A value as a setting has it; `None` for a history, which is no text.
fn text(value: &PathValue) -> Option<String> {
    match value {
        PathValue::Number(number) => Some(format_number(*number)),
        PathValue::Word(word) => Some(word.clone()),
        PathValue::List(values) => {
            Some(values.iter().copied().map(format_number).collect::<Vec<_>>().join(", "))
        }
        PathValue::History(_) => None,
    }
}
