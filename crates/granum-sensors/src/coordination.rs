//! Coordination numbers: contacts per grain, by several definitions.
//!
//! With N_k contacts, N grains, and N_0 and N_1 grains with no contact and with one contact:
//! - coordination number `Z = 2 N_k / N`;
//! - mechanical coordination number `Z_m = (2 N_k - N_1) / (N - N_0 - N_1)` (Thornton 2000): the mean number of contacts of
//!   the grains that have at least two;
//! - compressive coordination number: Z of the contacts in compression only, which carry load;
//! - backbone coordination number: Z after the grains with fewer than two contacts have been removed together with their
//!   contacts, repeatedly until none is left.
//!
//! Rattlers are the grains with fewer than two contacts: N_0 + N_1.

use granum_core::Part;

use crate::ratio::mean;
use crate::{Memory, Observation, Sensor, SensorColumn, SensorDescription, Subject, Values};

/// The sensor.
pub struct CoordinationNumbers;

impl Sensor for CoordinationNumbers {
    fn description(&self) -> SensorDescription {
        SensorDescription::new("coordination", "mean number of contacts per grain, by several definitions")
            .speaking_of(Subject::Bodies)
            .columns([
                SensorColumn::new("coordination_number", "1", "Z = 2 N_k / N over all grains"),
                SensorColumn::new(
                    "mechanical_coordination_number",
                    "1",
                    "Z_m of Thornton (2000): over grains with two contacts or more",
                ),
                SensorColumn::new(
                    "compressive_coordination_number",
                    "1",
                    "Z of the contacts in compression only",
                )
                .needing(&[Part::NormalForces]),
                SensorColumn::new(
                    "backbone_coordination_number",
                    "1",
                    "Z after grains with fewer than two contacts are removed until none is left",
                ),
                SensorColumn::new(
                    "rattler_fraction",
                    "1",
                    "grains with fewer than two contacts over all grains",
                ),
                SensorColumn::new("contacts", "1", "number N_k of contacts"),
            ])
            .needing(&[Part::Contacts])
    }

    fn measure(&self, observation: &Observation, _: &mut Memory, values: &mut Values) {
        let z = Coordination::from_observation(observation);
        values.extend([
            z.all,
            z.mechanical,
            z.compressive,
            z.backbone,
            z.rattler_fraction,
            observation.assembly.contacts.len() as f64,
        ]);
    }
}

/// Coordination numbers of an assembly.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Coordination {
    /// Z = 2 N_k / N.
    pub all: f64,
    /// Z_m (Thornton 2000).
    pub mechanical: f64,
    /// Z of the contacts in compression.
    pub compressive: f64,
    /// Z of the grains that are left after repeated removal of the rattlers.
    pub backbone: f64,
    /// (N_0 + N_1) / N.
    pub rattler_fraction: f64,
}

impl Coordination {
    /// Computes the coordination numbers; 0 where there is no grain to divide by.
    pub fn from_observation(observation: &Observation) -> Self {
        let grains = observation.assembly.bodies.len();
        let mut degree = vec![0u32; grains];
        let mut contacts = Vec::with_capacity(observation.assembly.contacts.len());
        let mut compressive = 0;
        for contact in &observation.assembly.contacts {
            // A contact with a grain that does not exist (in a file of another code) is not counted.
            let Some([i, j]) = observation.assembly.bodies_of(contact) else { continue };
            degree[i] += 1;
            degree[j] += 1;
            compressive += usize::from(contact.normal_force > 0.0);
            contacts.push([i as u32, j as u32]);
        }
        let count = contacts.len();
        let alone = degree.iter().filter(|&&d| d == 0).count();
        let single = degree.iter().filter(|&&d| d == 1).count();
        Coordination {
            all: mean(2.0 * count as f64, grains),
            mechanical: mean((2 * count - single) as f64, grains - alone - single),
            compressive: mean(2.0 * compressive as f64, grains),
            backbone: backbone(contacts, degree),
            rattler_fraction: mean((alone + single) as f64, grains),
        }
    }
}

/// Coordination number of the contacts that are left after grains with fewer than two contacts have been removed until none
/// is left.
fn backbone(mut left: Vec<[u32; 2]>, mut degree: Vec<u32>) -> f64 {
    loop {
        let before = left.len();
        left.retain(|pair| {
            let [i, j] = pair.map(|g| g as usize);
            let kept = degree[i] >= 2 && degree[j] >= 2;
            if !kept {
                degree[i] -= 1;
                degree[j] -= 1;
            }
            kept
        });
        if left.len() == before {
            let grains = degree.iter().filter(|&&d| d >= 2).count();
            return mean(2.0 * left.len() as f64, grains);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice;
    use granum_core::assembly::{Assembly, Contact, Sphere};

    #[test]
    fn lattices_have_six_and_twelve() {
        for (assembly, z) in [
            (lattice::simple_cubic(3, 1e-4, 1e-4, 1e-4), 6.0),
            (lattice::face_centred_cubic(3, 1e-4, 1e-4, 1e-4), 12.0),
        ] {
            let c = Coordination::from_observation(&Observation::new(&assembly));
            assert_eq!(
                c,
                Coordination { all: z, mechanical: z, compressive: z, backbone: z, rattler_fraction: 0.0 }
            );
        }
    }

    /// A ring of three grains with a tail of two, and one isolated grain.
    #[test]
    fn rattlers_are_counted_by_each_definition() {
        let grains = vec![Sphere { radius: 1.0, ..Default::default() }; 6];
        let contacts = [(0, 1), (1, 2), (0, 2), (2, 3), (3, 4)].map(|(i, j)| Contact {
            i,
            j,
            normal_force: if j == 4 { -1.0 } else { 2.0 },
            ..Default::default()
        });
        let assembly = Assembly { contacts: contacts.to_vec(), ..Default::default() }.with_spheres(grains);
        let c = Coordination::from_observation(&Observation::new(&assembly));
        assert!((c.all - 10.0 / 6.0).abs() < 1e-15);
        assert!((c.mechanical - 9.0 / 4.0).abs() < 1e-15, "grains 0 to 3 have 2, 2, 3 and 2 contacts");
        assert!((c.compressive - 8.0 / 6.0).abs() < 1e-15);
        assert!((c.backbone - 2.0).abs() < 1e-15, "the ring is left");
        assert!((c.rattler_fraction - 2.0 / 6.0).abs() < 1e-15);
    }
}
