//! Writing a case: resolved (SI numbers, stored with a result) and as a template that explains the keys.

use super::bare_number::with_units;
use super::definition::Case;
use super::field::Field;
use super::fields::SECTIONS;
use super::read::LARGEST_FILE;
use super::reading::Reading;
use super::shape_value::SHAPE;
use super::vocabulary::Vocabulary;
use crate::error::{Error, Result};
use granum_core::quantity::format_number;

const TEMPLATE_HEAD: &str = "\
# A granum case: all inputs that determine a result.
#
# Quantities are strings with a unit (\"70 GPa\", \"0.1 mm\", \"2650 kg/m3\") or plain numbers in SI units. Every key
# may be left out; the values below are the defaults, the sample and test of Antony, Zhou and Wang (2006).
";

const TEMPLATE_TAIL: &str = "
# Several shapes, with their shares of the mass; each may be of one material or of some sizes alone. A mesh or an image of
# grains is read from a file.
# [[grains.shape]]
# kind = \"sphere\"
# share = 0.3
# [[grains.shape]]
# kind = \"mesh\"
# file = \"grain.stl\"
# pieces = 20

# Several materials: keys that a table leaves out are taken from [grains.material] and [contact]. Elastic moduli of a
# pair follow from contact theory, other properties from a mean, unless [[pair]] gives them.
# [[material]]
# name = \"glass\"
# share = 0.7
# [[material]]
# name = \"rubber\"
# youngs_modulus = \"5 MPa\"
# friction = 0.9
# [[pair]]
# between = [\"glass\", \"rubber\"]
# friction = 0.7

# Loading paths between the compaction of the sample and its relaxation, with the friction of the preparation.
# [[preparation.stage]]
# path = \"oedometer\"
# axial_stress = \"200 kPa\"

# Bonds, as of cement, made before a stage (by default the first); the grains must not attract each other otherwise.
# [[bond]]
# law = \"parallel\"
# radius = 0.5
# modulus = \"5 GPa\"
# tensile_strength = \"5 MPa\"
# cohesion = \"10 MPa\"

# Another test: stages instead of [shear], each a named path (`granum run --list` shows all) or an explicit control.
# [[stage]]
# path = \"drained-triaxial\"
# axial_strain = 0.2
";

const RESOLVED_HEAD: &str = "\
# The resolved case of a granum run: every key, in SI units. It can be run again as it is.
";

impl Case {
    /// A commented case file with every key at its default, with units.
    pub fn template() -> String {
        Case::template_with(&Vocabulary::standard())
    }

    /// The same with the keys of the contact laws of a program.
    pub fn template_with(vocabulary: &Vocabulary) -> String {
        let mut text = TEMPLATE_HEAD.to_string();
        let case = Case { vocabulary: vocabulary.clone(), ..Case::default() };
        for [section, help] in SECTIONS {
            text.push_str(&format!("\n# {help}\n[{section}]\n"));
            for field in case.fields().iter().filter(|field| field.section == *section) {
                text.push_str(&comment(field));
                // A field that is not in use by default is the other form of the rate, or a parameter of another law.
                let unused = if field.value(&case).is_none() { "# " } else { "" };
                let plain = field.example.parse::<f64>().is_ok();
                let value = if plain { field.example.clone() } else { format!("\"{}\"", field.example) };
                text.push_str(&format!("{unused}{} = {value}\n", field.key));
            }
        }
        text + TEMPLATE_TAIL
    }

    /// The whole case as TOML in SI units, with units in comments; it is read back as the same case, bit for bit.
    pub fn resolved_toml(&self) -> String {
        self.resolved_toml_with(None)
    }

    /// The same as [`Case::resolved_toml`], with a remark on every key that is not used because a packing of this name
    /// replaced the random insertion.
    pub fn resolved_toml_with(&self, packing: Option<&str>) -> String {
        let mut text = RESOLVED_HEAD.to_string();
        if let Some(name) = packing {
            // A line break in the name of a file must not end the comment.
            let name = name.replace(char::is_control, " ");
            text.push_str(&format!("# The grains are those of the packing {name}.\n"));
        }
        let all = self.fields();
        for [section, _] in SECTIONS {
            if *section == SHAPE && (self.grains.shapes.is_empty() || self.has_shape_tables()) {
                continue;
            }
            let of_section = all.iter().filter(|field| field.section == *section);
            let fields: Vec<_> = of_section.filter(|field| self.test.uses(&field.path())).collect();
            if fields.is_empty() {
                continue;
            }
            text.push_str(&format!("\n[{section}]\n"));
            for field in fields {
                let Some(value) = field.value(self) else { continue };
                let unit = field.si_unit();
                let unused = packing.is_some() && self.unused_with_packing().any(|key| key == field.path());
                let comment = match (unit.as_str(), unused) {
                    (_, true) => "  # no effect in this run: the grains are those of the packing".to_string(),
                    ("", false) => String::new(),
                    (unit, false) => format!("  # {unit}"),
                };
                text.push_str(&format!("{} = {}{comment}\n", field.key, field.toml(&value)));
            }
            if *section == "recording" {
                for (key, value) in self.undeclared_parameters() {
                    text.push_str(&format!("{key} = {}\n", format_number(value)));
                }
            }
        }
        text.push_str(&self.shapes_toml());
        text.push_str(&self.bonds_toml());
        text.push_str(&self.materials_toml());
        text.push_str(&self.preparation_stages_toml());
        text.push_str(&self.stages_toml());
        with_units(text, self)
    }

    /// The text of [`Case::resolved_toml_with`], after it was read back as the same case.
    ///
    /// # Errors
    /// [`Error::Rule`] if no file can be written from which this case would be read.
    pub fn readable_toml(&self, packing: Option<&str>) -> Result<String> {
        self.test.check()?;
        let text = self.resolved_toml_with(packing);
        let cannot = |why: String| {
            Error::Rule(format!(
                "this case cannot be written to a file from which it would be read again: {why}"
            ))
        };
        if text.len() as u64 > LARGEST_FILE {
            let size = text.len();
            return Err(cannot(format!(
                "it comes to {size} bytes, and case files have at most {LARGEST_FILE}"
            )));
        }
        let reading = Reading::default().with_vocabulary(&self.vocabulary);
        let read = Case::parse_as(&text, "case.toml", reading).map_err(|error| cannot(error.to_string()))?;
        if read.digest() != self.digest() {
            return Err(cannot("what is read has other values".into()));
        }
        Ok(text)
    }
}

/// Help text, bounds and words of a field as comment lines of at most 110 characters.
fn comment(field: &Field) -> String {
    let mut words = field.help.trim_end_matches('.').to_string();
    let options: Vec<_> =
        field.words().iter().map(|[word, meaning]| format!("\"{word}\": {meaning}")).collect();
    if field.example.parse::<f64>().is_ok() || options.is_empty() {
        words.push_str(&format!(" ({})", field.bounds_text()));
    } else if options.len() == 1 {
        words.push_str(&format!(" ({}, or {})", field.bounds_text(), options[0]));
    }
    words.push('.');
    let mut lines = wrap(&words);
    if options.len() > 1 || field.example.parse::<f64>().is_ok() {
        lines.extend(options.iter().flat_map(|option| wrap(&format!("  {option}"))));
    }
    lines.iter().map(|line| format!("# {line}\n")).collect()
}

fn wrap(text: &str) -> Vec<String> {
    let indent: String = text.chars().take_while(|c| *c == ' ').collect();
    let mut lines = vec![indent.clone()];
    for word in text.split_whitespace() {
        let last = lines.len() - 1;
        if lines[last].len() + word.len() > 107 {
            lines.push(format!("{indent}{}{word}", if indent.is_empty() { "" } else { "  " }));
        } else {
            let space = if lines[last].trim().is_empty() { "" } else { " " };
            lines[last] += &format!("{space}{word}");
        }
    }
    lines
}
