//! Rules between fields: each field may be valid by itself while the combination is not.

use granum_dem::config::{AdhesionKind, NormalKind, Spacing};
use granum_dem::contact::PairProperties;
use granum_dem::contact::choice::check;
use granum_dem::preparation::DensityMeasure;
use granum_dem::simulation::{LARGEST_REACH, Properties};
use granum_sensors::force_distribution::bins_of;

use super::definition::Case;
use super::{densities, stresses};
use crate::error::{Error, Result};

/// A rule: the fields concerned (the error points to the first one that the user has given), and what is wrong.
pub(super) struct Rule {
    pub fields: &'static [&'static str],
    pub broken: fn(&Case) -> Option<String>,
}

/// Beginnings of the keys of the contact law and of the grains.
const OF_LAW: [&str; 4] = ["grains", "contact", "material", "pair"];

impl Rule {
    /// True if it concerns the contact law and the grains alone, and neither their preparation nor a test.
    pub(super) fn is_of_law(&self) -> bool {
        self.fields
            .iter()
            .all(|field| field.split('.').next().is_some_and(|section| OF_LAW.contains(&section)))
    }
}

pub(super) const RULES: &[Rule] = &[
    Rule {
        fields: &["preparation.bedding_tilt", "preparation.bedding_spread"],
        broken: |case| {
            let unused = case.preparation.bedding.is_some() && case.grains.are_spheres();
            unused.then(|| {
                "preparation.bedding_tilt means nothing for spheres, which have no long axes; give grains.shape, or leave it out".into()
            })
        },
    },
    Rule {
        fields: &["grains.shape.kind", "grains.shape", "contact.adhesion"],
        broken: |case| {
            let adhesion = case.contact.adhesion;
            let unclear = adhesion.law().shares_liquid() && !case.grains.are_spheres();
            unclear.then(|| {
                format!(
                    "contact.adhesion = {:?} shares the liquid of a grain among its bridges, which is defined for spheres alone: a film belongs \
                     to a body, and a bridge to two of its pieces; choose another law, or grains.shape.kind = \"sphere\"",
                    adhesion.name()
                )
            })
        },
    },
    Rule {
        fields: &["grains.material.interface_energy", "grains.material.youngs_modulus", "grains.diameter"],
        broken: |case| too_sticky(case, "grains.material", case.grains.material.interface_energy),
    },
    Rule {
        fields: &["preparation.interface_energy", "grains.material.youngs_modulus", "grains.diameter"],
        broken: |case| too_sticky(case, "preparation", case.preparation.interface_energy),
    },
    Rule { fields: &["material", "pair"], broken: materials_too_sticky },
    Rule {
        fields: &["preparation.mean_stress", "grains.material.youngs_modulus"],
        broken: stresses::of_sample,
    },
    Rule { fields: &["preparation.compaction_stress"], broken: stresses::of_compaction },
    Rule { fields: &["shear.mean_stress"], broken: stresses::of_shear },
    Rule { fields: &["preparation.stage"], broken: stresses::of_preparation_stages },
    Rule { fields: &["stage"], broken: stresses::of_stages },
    Rule {
        fields: &[
            "preparation.initial_solid_fraction",
            "preparation.solid_fraction",
            "preparation.void_ratio",
            "preparation.relative_density",
        ],
        broken: |case| {
            let p = &case.preparation;
            let initial = p.initial_solid_fraction;
            p.target().filter(|target| *target <= initial)?;
            let measure = DensityMeasure::new(p);
            let same = match measure {
                DensityMeasure::SolidFraction => String::new(),
                _ => format!(" (a {} of {:.3})", measure.name(), measure.value(p, initial)),
            };
            Some(format!(
                "preparation.initial_solid_fraction = {initial}{same} must be looser than preparation.{} = {}: the loose initial state is \
                 compressed to the sample",
                measure.key(),
                measure.target(p)?
            ))
        },
    },
    Rule {
        fields: &["preparation.solid_fraction", "preparation.void_ratio", "preparation.relative_density"],
        broken: densities::of_sample,
    },
    Rule {
        fields: &[
            "preparation.relative_density",
            "preparation.densest_void_ratio",
            "preparation.loosest_void_ratio",
        ],
        broken: limits_missing,
    },
    Rule {
        fields: &["preparation.interface_energy", "contact.adhesion"],
        broken: |case| {
            let both = case.preparation.interface_energy > 0.0
                && case.contact.normal == NormalKind::HERTZ
                && case.contact.adhesion != AdhesionKind::NONE;
            both.then(|| {
                format!(
                    "preparation.interface_energy needs contact.adhesion = \"none\" with normal = \"hertz\", since contacts follow JKR \
                     while they are compacted, and {:?} does not go with that",
                    case.contact.adhesion.name()
                )
            })
        },
    },
    Rule {
        fields: &["preparation.interface_energy", "contact.normal"],
        broken: |case| {
            let unused = case.preparation.interface_energy > 0.0 && !holds_while_compacting(case);
            unused.then(|| {
                format!(
                    "preparation.interface_energy has no effect with contact.normal = {:?}, whose contacts do not depend on it; use a \
                     law that does, or \"hertz\", whose contacts follow JKR while they are compacted, or 0 J/m2",
                    case.contact.normal.name()
                )
            })
        },
    },
    Rule {
        fields: &["grains.diameter", "grains.distribution"],
        broken: |case| {
            let description = case.grains.sizes.distribution.distribution().description();
            let given = case.grains.diameter != Case::default().grains.diameter;
            (given && !description.has_mean).then(|| {
                format!(
                    "grains.diameter means nothing with grains.distribution = {:?}; leave it out",
                    description.name
                )
            })
        },
    },
    Rule {
        fields: &["recording.first_strain", "shear.deviator_strain"],
        broken: |case| {
            let Spacing::Geometric(first) = case.recording.spacing else { return None };
            let end = case.test.shear()?.deviator_strain;
            (first >= end).then(|| {
                format!("recording.first_strain = {first} must be below shear.deviator_strain = {end}, the end of the test")
            })
        },
    },
    Rule {
        fields: &["recording.strains", "shear.deviator_strain"],
        broken: |case| {
            let Spacing::Strains(strains) = &case.recording.spacing else { return None };
            beyond_the_end(case, "recording.strains", strains)
        },
    },
    Rule {
        fields: &["recording.snapshots", "shear.deviator_strain"],
        broken: |case| beyond_the_end(case, "recording.snapshots", &case.recording.snapshots),
    },
    Rule {
        fields: &["recording.bin_width", "recording.largest_force"],
        broken: |case| {
            let [width, largest] = bins_of(&case.recording);
            (width > largest).then(|| {
                format!("recording.bin_width = {width} must not be above recording.largest_force = {largest}")
            })
        },
    },
    Rule {
        fields: &["recording.bin_width", "recording.largest_force"],
        broken: |case| {
            let [width, largest] = bins_of(&case.recording);
            let bins = (largest / width).ceil();
            (bins > 10_000.0).then(|| {
                format!("recording.largest_force / recording.bin_width gives {bins} bins; at most 10000 are possible")
            })
        },
    },
];

/// True if contacts depend on the interface energy of the preparation while they are compacted.
fn holds_while_compacting(case: &Case) -> bool {
    let constants = |interface_energy| {
        let preparation = case.preparation.clone().with(|p| p.interface_energy = interface_energy);
        let properties = case.properties().while_compacting(&preparation, case.grains.mean_friction());
        let sphere = (&properties.material, smallest_radius(case));
        let pair = PairProperties::new(sphere, sphere, case.contact.damping);
        (properties.contact.normal, properties.contact.constants(&pair).to_array())
    };
    constants(case.preparation.interface_energy) != constants(0.0)
}

/// Smallest radius of a grain or of a piece of one, m.
fn smallest_radius(case: &Case) -> f64 {
    case.grains.smallest_piece().unwrap_or(0.5)
        * case.grains.size_range().map_or(case.grains.diameter, |[smallest, _]| smallest)
}

/// What is wrong with the void ratios between which a relative density is measured.
fn limits_missing(case: &Case) -> Option<String> {
    let p = &case.preparation;
    match (p.densest_void_ratio, p.loosest_void_ratio) {
        (Some(densest), Some(loosest)) if densest >= loosest => Some(format!(
            "preparation.densest_void_ratio = {densest} must be below preparation.loosest_void_ratio = {loosest}"
        )),
        (Some(_), Some(_)) => None,
        _ => p.relative_density.map(|density| {
            format!(
                "preparation.relative_density = {density} needs preparation.densest_void_ratio and preparation.loosest_void_ratio; \
                 `granum limits CASE` finds them"
            )
        }),
    }
}

/// The error message if a list of strains continues after the end of the test.
fn beyond_the_end(case: &Case, key: &str, strains: &[f64]) -> Option<String> {
    // In a case with stages the keys have no effect.
    let end = case.test.shear()?.deviator_strain;
    let last = strains.last().filter(|last| **last > end)?;
    Some(format!("{key} goes up to {last}, but the test ends at shear.deviator_strain = {end}"))
}

/// What is wrong where the adhesion of one of several materials reaches beyond the theory of small contacts.
fn materials_too_sticky(case: &Case) -> Option<String> {
    if case.grains.mixture.is_empty() {
        return None;
    }
    let smallest = smallest_radius(case);
    let properties = case.properties();
    let compacting = properties.while_compacting(&case.preparation, case.grains.mean_friction());
    let reach =
        [properties, compacting].iter().filter_map(|p| p.adhesion_reach(smallest).ok()).fold(0.0, f64::max);
    (reach > LARGEST_REACH * smallest).then(|| {
        format!(
            "adhesion between grains of these materials would hold the smallest grains together up to {reach:.2e} m \
             apart, beyond half their radius, where the theory of small contacts fails: lower an interface_energy or \
             raise a youngs_modulus"
        )
    })
}

/// The error message if adhesion is beyond the range of the theory of small contacts.
fn too_sticky(case: &Case, section: &str, interface_energy: f64) -> Option<String> {
    let smallest = smallest_radius(case);
    if !case.grains.mixture.is_empty() {
        return None;
    }
    let mut properties = Properties::new(case.grains.material, case.contact);
    if section == "preparation" {
        properties = properties.while_compacting(&case.preparation, case.grains.material.friction);
    }
    properties.material.interface_energy = interface_energy;
    let largest = LARGEST_REACH * smallest;
    let reach = properties.adhesion_reach(smallest).ok().filter(|reach| *reach > largest)?;
    // The reach is proportional to the energy to the power 2/3.
    let most = interface_energy * libm::pow(largest / reach, 1.5);
    let most = format!("{most:.2e}").parse().unwrap_or(most);
    Some(format!(
        "{section}.interface_energy = {interface_energy} J/m2 would hold the smallest grains together up to \
         {reach:.2e} m apart, beyond half their radius, where the theory of small contacts fails; with this \
         youngs_modulus and diameter it must be at most {most} J/m2"
    ))
}

impl Case {
    /// Checks the bounds of every field and the rules between fields, for a case that was not read from a file.
    ///
    /// # Errors
    /// The first violation that is found, with the key, the value and what would be right.
    pub fn check(&self) -> Result<()> {
        self.check_values()?;
        self.check_stages()?;
        check_rules(RULES.iter(), self)
    }

    /// Checks the contact law and the grains, as [`Case::check`], for what uses nothing else of a case: soft grains that no sample could be
    /// made of are right for two of them.
    ///
    /// # Errors
    /// As [`Case::check`].
    pub fn check_law(&self) -> Result<()> {
        self.check_values()?;
        check_rules(RULES.iter().filter(|rule| rule.is_of_law()), self)
    }

    fn check_values(&self) -> Result<()> {
        for field in self.fields().iter() {
            let Some(value) = field.value(self) else { continue };
            let text = field.toml(&value);
            field.parse(text.trim_matches('"')).map_err(|message| Error::Value {
                name: field.path(),
                value: text.trim_matches('"').to_string(),
                message,
            })?;
        }
        check::check_among(&self.contact, self.vocabulary.laws())
            .map_err(|error| Error::Rule(error.to_string()))?;
        self.grains.check_sizes().map_err(|error| Error::Rule(error.to_string()))?;
        self.grains.check_shapes().map_err(|error| Error::Rule(format!("grains.shape.{error}")))?;
        self.check_bonds()?;
        self.check_materials()
    }
}

fn check_rules<'r>(mut rules: impl Iterator<Item = &'r Rule>, case: &Case) -> Result<()> {
    match rules.find_map(|rule| (rule.broken)(case)) {
        Some(message) => Err(Error::Rule(message)),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A stress of 100 kPa, the default, would press grains of 400 kPa into each other.
    #[test]
    fn soft_grains_are_right_where_no_sample_is_made() {
        let mut case = Case::default();
        case.grains.material.youngs_modulus = 4e5;
        case.grains.material.interface_energy = 0.0;
        case.contact.normal = NormalKind::HERTZ;
        assert!(case.check().unwrap_err().to_string().contains("mean_stress"));
        case.check_law().unwrap();
        case.contact.normal = NormalKind::JKR;
        case.grains.material.interface_energy = 1e6;
        assert!(case.check_law().unwrap_err().to_string().contains("interface_energy"));
        let text = "[grains.material]\nyoungs_modulus = '400 kPa'\n[contact]\nnormal = 'hertz'\n";
        assert!(Case::parse(text, "soft.toml").is_err());
        Case::parse_as(text, "soft.toml", crate::Reading::default().for_law()).unwrap();
    }
}
