//! Contact laws as `pair_coeff` of LAMMPS's `pair_style granular`.
//!
//! | granum | LAMMPS |
//! |---|---|
//! | `hertz`, `hooke`, `jkr` | `hertz/material`, `hooke`, `jkr` with half the interface energy |
//! | `no-slip` | `mindlin_rescale/force` with `8 G*`; with `hooke` `linear_history` with `k_t/k_n k_n` |
//! | `damping` | `tsuji` with the restitution at which its dashpot is that of granum; the tangential one by `(k_t/k_n)^(1/2)` |
//! | `elastic-plastic` | `rolling sds` |
//! | `elastic-plastic-twisting` | `rolling sds`, `twisting sds` |
//! | `spring-dashpot-slider` | `rolling sds` with the same three numbers |
//!
//! The rolling stiffness of the elastic-plastic laws follows the normal stiffness of each contact, in LAMMPS all contacts have one value: that of
//! a contact of mean radii under the mean normal force of the sample. The script changes it with the mean stress at every row of
//! its curve. With the convention `pseudo-force x R*` of LAMMPS, `k = 9/4 k_n mu_r^2`,
//! `gamma = 2 zeta_r (I_r k_theta)^(1/2) / R*^2` and `mu = mu_r`.

use granum_dem::config::{ContactModel, NormalKind, RollingKind, TangentialKind};
use granum_dem::contact::law::pair_properties::PairProperties;
use granum_dem::material::Material;
use granum_dem::simulation::Properties;

use super::deck_error::DeckError;
use super::formula::number;

/// What the lines depend on beside the laws.
#[derive(Clone, Copy, Debug)]
pub(super) struct Contacts {
    /// Mean radius of what touches, m.
    pub(super) radius: f64,
    /// Mean normal force, N.
    pub(super) force: f64,
    /// True if the resistance to rolling is that of the present mean stress, by the variable `stiffer`, and not that of the sample.
    pub(super) follows: bool,
    /// True for versions of LAMMPS whose `damping tsuji` has a factor of the root of two.
    pub(super) newer: bool,
}

/// Lines `pair_coeff`.
pub(super) fn pair_lines(
    properties: &Properties,
    names: &[String],
    of: Contacts,
) -> Result<String, DeckError> {
    let contact = &properties.contact;
    check(properties)?;
    let mut text = String::new();
    let alike = |material: &Material| Some((material.youngs_modulus, material.poissons_ratio));
    if names.is_empty() {
        let material = &properties.material;
        let side = (material, of.radius);
        let pair = PairProperties::new(side, side, contact.damping);
        text += &line("* *", contact, &pair, alike(material), of)?;
        return Ok(text);
    }
    for (i, one) in names.iter().enumerate() {
        for (j, other) in names.iter().enumerate().skip(i) {
            let pair = (properties.pair([one, other], [of.radius; 2]))
                .map_err(|error| DeckError::Sample(error.to_string()))?;
            let own = properties.mixture.components.iter().find(|component| component.name == *one);
            let own = own.filter(|_| i == j).and_then(|component| alike(&component.material));
            text += &line(&format!("{} {}", i + 1, j + 1), contact, &pair, own, of)?;
        }
    }
    Ok(text)
}

fn check(properties: &Properties) -> Result<(), DeckError> {
    let contact = &properties.contact;
    let refuse = |key, value: &str, why: &str| {
        Err(DeckError::Setting { key, value: format!("{value:?}"), why: why.into() })
    };
    if ![NormalKind::HERTZ, NormalKind::HOOKE, NormalKind::JKR].contains(&contact.normal) {
        return refuse(
            "contact.normal",
            contact.normal.name(),
            "of its normal laws hertz, hooke and jkr can be",
        );
    }
    if contact.tangential != TangentialKind::NO_SLIP {
        return refuse("contact.tangential", contact.tangential.name(), "it has no such law; no-slip can be");
    }
    if contact.adhesion.law().acts() {
        return refuse("contact.adhesion", contact.adhesion.name(), "nothing but none can be");
    }
    if ![
        RollingKind::NONE,
        RollingKind::ELASTIC_PLASTIC,
        RollingKind::ELASTIC_PLASTIC_TWISTING,
        RollingKind::SPRING_DASHPOT_SLIDER,
    ]
    .contains(&contact.rolling)
    {
        let why = "none, elastic-plastic, elastic-plastic-twisting and spring-dashpot-slider can be";
        return refuse("contact.rolling", contact.rolling.name(), why);
    }
    let mixture = &properties.mixture;
    let own = mixture.components.iter().find(|component| !component.parameters.is_empty());
    let rule = mixture.pairs.iter().find(|rule| !rule.parameters.is_empty());
    if let Some(name) = own.map(|c| c.name.clone()).or_else(|| rule.map(|r| r.between.join(" and "))) {
        let why = "parameters of contact laws must be the same for all materials; give them in [contact]";
        return refuse("[[material]] or [[pair]]", &name, why);
    }
    Ok(())
}

/// Whether the resistance to rolling grows with the normal stiffness of the contacts.
pub(super) fn rolling_follows_stress(contact: &ContactModel) -> bool {
    contact.rolling.law().acts() && contact.rolling != RollingKind::SPRING_DASHPOT_SLIDER
}

/// Coefficient and damping of twisting, where the law has them.
fn twisting(contact: &ContactModel) -> Option<[f64; 2]> {
    let law = contact.rolling.law().description();
    (law.name == "elastic-plastic-twisting")
        .then(|| [value(contact, "twisting_friction"), value(contact, "twisting_damping")])
}

/// The value of a parameter of one of the laws.
fn value(contact: &ContactModel, key: &str) -> f64 {
    let laws = [
        contact.normal.law().description(),
        contact.tangential.law().description(),
        contact.rolling.law().description(),
    ];
    let parameter = laws.iter().flat_map(|law| law.parameters).find(|parameter| parameter.key == key);
    parameter.map_or(0.0, |parameter| contact.parameters.value(parameter))
}

/// The line of a pair of types. `material` is Young's modulus and Poisson's ratio where the two are alike.
fn line(
    types: &str,
    contact: &ContactModel,
    pair: &PairProperties,
    material: Option<(f64, f64)>,
    of: Contacts,
) -> Result<String, DeckError> {
    let hooke = contact.normal == NormalKind::HOOKE;
    // Tsuji's dashpot is taken on N/alpha, two thirds of the stiffness of Hertz's law.
    let own_convention = if hooke { 2.0 } else { 6f64.sqrt() } * contact.damping;
    let coefficient = if of.newer { own_convention / std::f64::consts::SQRT_2 } else { own_convention };
    let Some(restitution) = restitution(coefficient) else {
        let most = tsuji(0.0) * contact.damping / coefficient;
        let why = format!(
            "its dashpots cannot be stronger than {most:.3} of critical damping with this normal law"
        );
        return Err(DeckError::Setting { key: "contact.damping", value: number(contact.damping), why });
    };
    let (modulus, ratio) = material.unwrap_or((2.0 * pair.effective_modulus, 0.0));
    let elastic = format!("{} {} {}", number(modulus), number(restitution), number(ratio));
    let (normal, tangential) = if hooke {
        let stiffness = value(contact, "normal_stiffness");
        let share = value(contact, "tangential_stiffness_ratio");
        let tangential = format!("linear_history {} {}", number(share * stiffness), number(share.sqrt()));
        (format!("hooke {} {}", number(stiffness), number(restitution)), tangential)
    } else {
        let stiffness = 8.0 * pair.effective_shear_modulus;
        let share = stiffness / (2.0 * pair.effective_modulus);
        let tangential = format!("mindlin_rescale/force {} {}", number(stiffness), number(share.sqrt()));
        let normal = if contact.normal == NormalKind::JKR {
            format!("jkr {elastic} {}", number(0.5 * pair.interface_energy))
        } else {
            format!("hertz/material {elastic}")
        };
        (normal, tangential)
    };
    let mut text = format!(
        "pair_coeff {types} {normal} tangential {tangential} {} damping tsuji",
        number(pair.friction)
    );
    if contact.rolling.law().acts() {
        text += &moments(contact, pair, of);
    }
    Ok(text + "\n")
}

/// The words for rolling and twisting.
fn moments(contact: &ContactModel, pair: &PairProperties, of: Contacts) -> String {
    if contact.rolling == RollingKind::SPRING_DASHPOT_SLIDER {
        let of = ["rolling_stiffness", "rolling_viscosity", "rolling_friction"];
        let [spring, dashpot, friction] = of.map(|key| number(value(contact, key)));
        return format!(" rolling sds {spring} {dashpot} {friction}");
    }
    let [stiffness, _] = contact.stiffness_under(pair, of.force);
    let radius = pair.effective_radius;
    let now = |value: f64, factor: &str| match of.follows {
        true => format!("$({}*{factor})", number(value)),
        false => number(value),
    };
    let springs = |spring: f64, dashpot: f64| {
        format!("{} {}", now(spring, "v_stiffer"), now(dashpot, "sqrt(v_stiffer)"))
    };
    let [friction, damping] = ["rolling_friction", "rolling_damping"].map(|key| value(contact, key));
    let spring = 2.25 * stiffness * (friction * radius).powi(2);
    let dashpot = 2.0 * damping * (pair.rolling_inertia * spring).sqrt();
    let square = radius * radius;
    let mut text =
        format!(" rolling sds {} {}", springs(spring / square, dashpot / square), number(friction));
    if let Some([friction, damping]) = twisting(contact) {
        let arm = friction * radius;
        let spring = 2.25 * stiffness * arm * arm;
        // 1/I_i + 1/I_j of spheres about their centres, where rolling is about the contact.
        let dashpot = 2.0 * damping * (2.0 / 7.0 * pair.rolling_inertia * spring).sqrt();
        text += &format!(" twisting sds {} {}", springs(spring, dashpot), number(arm));
    }
    text
}

/// Tsuji's coefficient of damping, as LAMMPS computes it of a restitution.
fn tsuji(e: f64) -> f64 {
    const TERMS: [f64; 7] = [1.2728, -4.2783, 11.087, -22.348, 27.467, -18.022, 4.8218];
    TERMS.iter().rev().fold(0.0, |sum, c| sum * e + c)
}

/// The restitution for which it is a given value; none if there is none.
fn restitution(coefficient: f64) -> Option<f64> {
    if coefficient > tsuji(0.0) {
        return None;
    }
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if tsuji(middle) > coefficient {
            low = middle;
        } else {
            high = middle;
        }
    }
    Some(0.5 * (low + high))
}
