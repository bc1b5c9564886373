//! The contact laws chosen for a simulation, with the values of their parameters.

use granum_simd::{Isa, LANES, Row8};
use serde::{Deserialize, Serialize};

use crate::contact::choice::kind::{AdhesionKind, NormalKind, RollingKind, TangentialKind};
use crate::contact::choice::parameters::ParameterValues;
use crate::contact::evaluation::observed::ObservedBatch;
use crate::contact::law::description::LawParameter;

/// The contact laws: normal, tangential and moment law, with the parameters of these laws, and the damping.
///
/// ```
/// use granum_dem::config::{ContactModel, NormalKind, RollingKind, TangentialKind};
///
/// let mut contact = ContactModel::new(NormalKind::HERTZ, TangentialKind::NO_SLIP, 0.1);
/// contact.rolling = RollingKind::ELASTIC_PLASTIC;
/// contact.parameters.set("rolling_friction", 0.2)?;
/// assert_eq!(contact.rolling.name(), "elastic-plastic");
/// # Ok::<(), granum_dem::contact::choice::parameters::TooManyParameters>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ContactModel {
    /// Normal law.
    pub normal: NormalKind,
    /// Tangential law.
    pub tangential: TangentialKind,
    /// Law of the moments of a contact: resistance to rolling and twisting.
    pub rolling: RollingKind,
    /// Additional adhesion law, which may act on separated grains.
    pub adhesion: AdhesionKind,
    /// Fraction zeta of critical damping in the contact dashpots.
    pub damping: f64,
    /// Values given to the parameters of the laws; the others have their defaults.
    pub parameters: ParameterValues,
}

/// The form in files: in formats with named fields, what is not in use is omitted.
#[derive(Serialize, Deserialize)]
struct ContactForm {
    normal: NormalKind,
    tangential: TangentialKind,
    damping: f64,
    #[serde(default = "no_moments", skip_serializing_if = "is_none")]
    rolling: RollingKind,
    #[serde(default = "no_adhesion", skip_serializing_if = "is_no_adhesion")]
    adhesion: AdhesionKind,
    #[serde(default, skip_serializing_if = "ParameterValues::is_empty")]
    parameters: ParameterValues,
}

fn no_moments() -> RollingKind {
    RollingKind::NONE
}

fn is_none(rolling: &RollingKind) -> bool {
    *rolling == RollingKind::NONE
}

fn no_adhesion() -> AdhesionKind {
    AdhesionKind::NONE
}

fn is_no_adhesion(adhesion: &AdhesionKind) -> bool {
    *adhesion == AdhesionKind::NONE
}

impl Serialize for ContactModel {
    fn serialize<S: serde::Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let ContactModel { normal, tangential, rolling, adhesion, damping, parameters } = *self;
        if to.is_human_readable() {
            return ContactForm { normal, tangential, damping, rolling, adhesion, parameters }.serialize(to);
        }
        (normal, tangential, rolling, adhesion, damping, parameters).serialize(to)
    }
}

impl<'d> Deserialize<'d> for ContactModel {
    fn deserialize<D: serde::Deserializer<'d>>(from: D) -> Result<ContactModel, D::Error> {
        if from.is_human_readable() {
            let ContactForm { normal, tangential, damping, rolling, adhesion, parameters } =
                ContactForm::deserialize(from)?;
            return Ok(ContactModel { normal, tangential, rolling, adhesion, damping, parameters });
        }
        let (normal, tangential, rolling, adhesion, damping, parameters) = Deserialize::deserialize(from)?;
        Ok(ContactModel { normal, tangential, rolling, adhesion, damping, parameters })
    }
}

impl ContactModel {
    /// A normal and a tangential law with a fraction of critical damping, without a moment law and without an adhesion law;
    /// parameters have their defaults.
    pub const fn new(normal: NormalKind, tangential: TangentialKind, damping: f64) -> ContactModel {
        let (rolling, adhesion) = (RollingKind::NONE, AdhesionKind::NONE);
        ContactModel { normal, tangential, rolling, adhesion, damping, parameters: ParameterValues::NONE }
    }

    /// The same with a value for every parameter of its laws, where none is given the default: two models that mean the same are
    /// then equal, and have the same bytes in a checkpoint.
    pub fn with_all_parameters(mut self) -> ContactModel {
        for parameter in parameters_of(&self) {
            // A registered set has room for the parameters of its laws; more are refused before a simulation begins.
            let _ = self.parameters.set(parameter.key, self.parameters.value(parameter));
        }
        self
    }

    /// Largest stable `dt sqrt(k_t / m)` of a grain that spins in phase with its neighbours, at Z contacts of the tangential
    /// stiffness k_t: `sqrt(6/5Z) (sqrt(1 + x^2) - x)`, `x = zeta sqrt(5Z/3)`.
    ///
    /// This mode has `w^2 = 10/3 Z k_t / m` and the damping ratio x; dashpots that use velocities half a step old are stable
    /// up to `w dt = 2 (sqrt(1 + x^2) - x)`.
    pub fn stable_fraction(&self, contacts: f64) -> f64 {
        let x = self.damping * (5.0 * contacts / 3.0).sqrt();
        (1.2 / contacts).sqrt() * (libm::hypot(x, 1.0) - x)
    }
}

impl Default for ContactModel {
    fn default() -> Self {
        ContactModel::new(NormalKind::JKR, TangentialKind::MINDLIN_DERESIEWICZ, 0.1)
    }
}

impl ContactModel {
    /// Evaluates the laws of the set for these pairs.
    pub(crate) fn observe(&self, isa: Isa, batches: &mut [ObservedBatch]) {
        self.normal.law().observe(isa, batches);
        self.tangential.law().observe(isa, batches);
        let (rolling, adhesion) = (self.rolling.law(), self.adhesion.law());
        for batch in batches {
            if rolling.acts() {
                let (constants, memory) = (&batch.constants.rolling, &batch.memory.moments);
                batch.rolling_energy =
                    Row8(std::array::from_fn(|l| rolling.energy(&lane(constants, l), &lane(memory, l))));
            }
            if adhesion.acts() {
                for l in 0..LANES {
                    (batch.attraction.0[l], batch.attraction_energy.0[l]) = (0.0, 0.0);
                    if batch.attracting >> l & 1 != 0 {
                        let constants = lane(&batch.constants.adhesion, l);
                        let history = lane(&batch.memory.adhesion, l);
                        let (overlap, touching) = (batch.overlap.0[l], batch.touching >> l & 1 != 0);
                        batch.attraction.0[l] = adhesion.force(&constants, overlap, touching, &history);
                        batch.attraction_energy.0[l] = adhesion.energy(&constants, overlap, &history);
                    }
                }
            }
        }
    }
}

/// The numbers of one lane of rows.
fn lane<const N: usize>(rows: &[Row8; N], l: usize) -> [f64; N] {
    rows.map(|row| row.0[l])
}

/// The parameters that the laws of a set use.
pub fn parameters_of(contact: &ContactModel) -> Vec<&'static LawParameter> {
    let area = contact.normal.law().traits().contact_area;
    let laws = [
        contact.normal.law().description(),
        contact.tangential.law().description(),
        contact.rolling.law().description(),
        contact.adhesion.law().description(),
    ];
    let used = laws.into_iter().flat_map(|law| law.parameters).filter(|p| !(p.without_area && area));
    used.collect()
}
