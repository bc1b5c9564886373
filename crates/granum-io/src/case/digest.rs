//! Digests of the input that determines a result, so that a finished run is reused only for the same case.

use granum_core::digest;

use super::definition::Case;
use super::field::{Field, Value};
use super::fields::RENAMED;

/// Sections that determine the sample.
const PREPARATION: [&str; 6] =
    ["grains", "grains.shape", "grains.material", "contact", "preparation", "numerics"];

/// Parameters of sensors that are in every digest, since they were keys of the first cases.
const ALWAYS: [&str; 2] = ["recording.bin_width", "recording.largest_force"];

/// Keys that were added after the first digests had been published: they are omitted where they are not in use, so that a
/// case without them keeps its digest.
const LATER: [&str; 25] = [
    "grains.size_measure",
    "grains.shape.kind",
    "grains.shape.spheres",
    "preparation.bedding_tilt",
    "preparation.bedding_spread",
    "grains.distribution",
    "grains.smallest",
    "grains.largest",
    "grains.sieve_curve",
    "preparation.rolling_friction",
    "preparation.compaction_stress",
    "preparation.cycles",
    "preparation.cycle_strain",
    "preparation.void_ratio",
    "preparation.relative_density",
    "preparation.densest_void_ratio",
    "preparation.loosest_void_ratio",
    "recording.first_strain",
    "recording.strains",
    "recording.snapshots",
    "recording.sensors",
    "contact.rolling",
    "contact.adhesion",
    "contact.rupture_coefficient",
    "numerics.largest_overlap",
];

impl Case {
    /// SHA-256 (hexadecimal) of the whole case: equal exactly if every field has the same bits.
    pub fn digest(&self) -> String {
        self.digest_with(None)
    }

    /// SHA-256 (hexadecimal) of the whole case and, if a packing replaces the random insertion, of that packing, given by
    /// the SHA-256 of its file.
    pub fn digest_with(&self, packing: Option<&str>) -> String {
        self.digest_of("granum case 1", packing, |_| true)
    }

    /// SHA-256 (hexadecimal) of the input that determines the sample: grains, contact law, preparation and time step.
    pub fn preparation_digest(&self) -> String {
        self.preparation_digest_with(None)
    }

    /// SHA-256 (hexadecimal) of the input that determines a sample made from a packing, as for [`Case::digest_with`].
    pub fn preparation_digest_with(&self, packing: Option<&str>) -> String {
        self.digest_of("granum preparation 1", packing, |section| PREPARATION.contains(&section))
    }

    fn digest_of(&self, title: &str, packing: Option<&str>, wanted: fn(&str) -> bool) -> String {
        let mut text = format!("{title}\n");
        if let Some(sha256) = packing {
            text.push_str(&format!("packing={sha256}\n"));
        }
        let standard = Case::default();
        let fields = self.fields();
        for field in fields.iter().filter(|field| wanted(field.section)) {
            let value = self.counted(field);
            let unused = match &value {
                Some(Value::List(values)) => values.is_empty(),
                Some(Value::Names(names)) => names.is_empty(),
                Some(Value::Curve(points)) => points.is_empty(),
                Some(Value::Spheres(spheres)) => spheres.is_empty(),
                Some(Value::Number(None)) | None => true,
                Some(Value::Choice(name)) => *name == "none",
                Some(_) => false,
            };
            let later = LATER.contains(&field.path().as_str());
            if field.is_of_sensor() && !ALWAYS.contains(&field.path().as_str()) {
                let given = self.recording.parameters.get(field.key);
                if let Some(value) = given.filter(|_| field.is_of_granum_sensor()) {
                    text.push_str(&format!("{}={:016x}\n", field.path(), value.to_bits()));
                }
                continue;
            }
            if unused && (field.is_of_law() || field.is_of_sizes() || field.is_of_shapes() || later) {
                continue;
            }
            if later && (value == field.value(&standard) || field.is_default_of_law(&value)) {
                continue;
            }
            let value = match value {
                Some(Value::Number(Some(value))) => format!("{:016x}", value.to_bits()),
                Some(Value::Number(None)) | None => "-".to_string(),
                Some(Value::Count(value)) => value.to_string(),
                Some(Value::Choice(name)) => name.to_string(),
                Some(Value::Names(names)) => names.join(" "),
                Some(Value::Curve(points)) => {
                    points.iter().flatten().map(|value| format!("{:016x} ", value.to_bits())).collect()
                }
                Some(Value::Spheres(spheres)) => {
                    spheres.iter().flatten().map(|value| format!("{:016x} ", value.to_bits())).collect()
                }
                Some(Value::List(values)) => {
                    values.iter().map(|value| format!("{:016x} ", value.to_bits())).collect()
                }
            };
            text.push_str(&format!("{}={value}\n", name(field)));
        }
        if wanted("recording") {
            // These have a place of their own, so that the digest is the same in a program that does not know the sensor.
            for (key, value) in self.parameters_of_other_sensors() {
                text.push_str(&format!("recording.{key}={:016x}\n", value.to_bits()));
            }
        }
        if wanted("grains.shape") {
            text.push_str(&self.shapes_toml());
        }
        if wanted("grains.material") {
            text.push_str(&self.materials_for_digest());
        }
        if wanted("preparation") {
            text.push_str(&self.preparation_stages_toml());
        }
        if wanted("bond") {
            text.push_str(&self.bonds_toml());
        }
        if wanted("stage") {
            text.push_str(&self.stages_toml());
        }
        digest::sha256(text.as_bytes())
    }
}

/// The name of a key in digests, which is the first name that it had.
fn name(field: &Field) -> String {
    let path = field.path();
    let first = RENAMED.iter().find(|[_, new]| *new == path);
    first.map_or(path, |[old, _]| (*old).to_string())
}

/// True if a key determines the sample, and not only its subsequent use.
pub fn decides_sample(key: &str) -> bool {
    key.rsplit_once('.').is_some_and(|(section, _)| PREPARATION.contains(&section))
}
