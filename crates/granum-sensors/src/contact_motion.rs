//! Rolling and sliding at the contacts, from the motion of the grains (Kuhn and Bagi 2004; Luding 2008).
//!
//! The relative velocity of the two surfaces at a contact has the tangential part
//! `v_s = (1 - n n) (v_j - v_i + L l) - (R_i omega_i + R_j omega_j) x n`, the sliding velocity, with the velocity gradient L of
//! the cell and the branch l; of a grain of several pieces R is the radius of the piece, v the velocity of its centre, `omega x c` of its
//! arm c included, and l joins the centres of mass. Rolling has the velocity `v_r = R* (omega_i - omega_j) x n`,
//! `1/R* = 1/R_i + 1/R_j`, which does not change in a rotation of the pair as a rigid body. A contact counts as rolling where
//! `|v_r| > |v_s|`. The contacts at the limit of friction are those of [`crate::sliding`]: a contact may creep without reaching it.

use granum_core::Part;
use granum_core::assembly::{Assembly, Contact, Vector};
use granum_core::geometry::{apply, cross, dot};

use crate::ratio::{mean, ratio};
use crate::{Memory, Observation, Sensor, SensorColumn, SensorDescription, Subject, Values};

/// The sensor.
pub struct ContactMotion;

impl Sensor for ContactMotion {
    fn description(&self) -> SensorDescription {
        SensorDescription::new(
            "contact_motion",
            "rolling against sliding at the contacts, from the motion of the grains",
        )
        .speaking_of(Subject::Contacts)
        .columns([
            SensorColumn::new(
                "rolling_fraction",
                "1",
                "contacts that roll faster than they slide over all contacts",
            ),
            SensorColumn::new(
                "rolling_sliding_ratio",
                "1",
                "root mean square rolling velocity over that of sliding; 0 where nothing slides",
            ),
        ])
        .needing(&[Part::Contacts, Part::Radii, Part::Velocities, Part::Spins, Part::StrainRate])
    }

    fn measure(&self, observation: &Observation, _: &mut Memory, values: &mut Values) {
        let (mut count, mut rolling) = (0, 0);
        let (mut rolled, mut slid) = (0.0, 0.0);
        for contact in &observation.assembly.contacts {
            let Some([roll, slide]) = squares(observation.assembly, contact) else { continue };
            count += 1;
            rolling += usize::from(roll > slide);
            rolled += roll;
            slid += slide;
        }
        values.extend([mean(f64::from(rolling as u32), count), ratio(rolled, slid).sqrt()]);
    }
}

/// Squares of the velocities of rolling and sliding at a contact; `None` for a grain that does not exist.
fn squares(assembly: &Assembly, contact: &Contact) -> Option<[f64; 2]> {
    let [one, two] = [assembly.pieces.get(contact.i)?, assembly.pieces.get(contact.j)?];
    let (i, j) = (assembly.bodies.get(one.body)?, assembly.bodies.get(two.body)?);
    let n = &contact.normal;
    let affine = apply(&assembly.velocity_gradient, assembly.branch_of_bodies(contact));
    let mut centres: Vector = std::array::from_fn(|a| j.velocity[a] - i.velocity[a] + affine[a]);
    if !assembly.all_spheres() {
        let (of_i, of_j) = (cross(&i.spin, &one.arm), cross(&j.spin, &two.arm));
        centres = std::array::from_fn(|a| centres[a] + of_j[a] - of_i[a]);
    }
    let along = dot(&centres, n);
    let spins = cross(&std::array::from_fn(|a| one.radius * i.spin[a] + two.radius * j.spin[a]), n);
    let slide: Vector = std::array::from_fn(|a| centres[a] - along * n[a] - spins[a]);
    let reduced = ratio(one.radius * two.radius, one.radius + two.radius);
    let roll = cross(&std::array::from_fn(|a| i.spin[a] - j.spin[a]), n).map(|x| reduced * x);
    Some([dot(&roll, &roll), dot(&slide, &slide)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clumps;
    use crate::sensor::measured;
    use granum_core::assembly::Sphere;

    /// Two grains of radii 2 and 1 along x, each with a velocity along y and a spin about z.
    fn pair(velocities: [f64; 2], spins: [f64; 2]) -> Assembly {
        let grain = |k: usize| Sphere {
            radius: [2.0, 1.0][k],
            velocity: [0.0, velocities[k], 0.0],
            spin: [0.0, 0.0, spins[k]],
            ..Default::default()
        };
        let contact =
            Contact { i: 0, j: 1, normal: [1.0, 0.0, 0.0], branch: [3.0, 0.0, 0.0], ..Default::default() };
        Assembly { contacts: vec![contact], ..Default::default() }.with_spheres(vec![grain(0), grain(1)])
    }

    #[test]
    fn gears_roll_and_equal_spins_slide() {
        // The surfaces have the same velocity: 2 x 1 = -1 x -2. Rolling: R* = 2/3, (1 - -2) 2/3 = 2.
        let gears = pair([0.0; 2], [1.0, -2.0]);
        let [roll, slide] = squares(&gears, &gears.contacts[0]).unwrap();
        assert!((roll - 4.0).abs() < 1e-14 && slide < 1e-28, "{roll} {slide}");
        assert_eq!(measured(&ContactMotion, &gears), [1.0, 0.0], "no ratio to no sliding");
        let [roll, slide] = squares(&pair([0.0; 2], [1.0; 2]), &gears.contacts[0]).unwrap();
        assert!(roll == 0.0 && (slide - 9.0).abs() < 1e-14);
        // Sliding of 1 against a rolling of 2.
        let both = pair([0.0, 1.0], [1.0, -2.0]);
        assert!((measured(&ContactMotion, &both)[1] - 2.0).abs() < 1e-14);
    }

    /// A pair that turns as a rigid body neither rolls nor slides: also where the turning is that of the cell.
    #[test]
    fn a_rigid_rotation_is_neither() {
        let turning = pair([0.0, 3.0 * 0.7], [0.7; 2]);
        let mut with_cell = pair([0.0; 2], [0.7; 2]);
        with_cell.velocity_gradient = [[0.0, -0.7, 0.0], [0.7, 0.0, 0.0], [0.0; 3]];
        for assembly in [turning, with_cell] {
            let [roll, slide] = squares(&assembly, &assembly.contacts[0]).unwrap();
            assert!(roll < 1e-28 && slide < 1e-28, "{roll} {slide}");
        }
    }

    /// Clumps that turn together as a rigid body, about any axis and point, neither roll nor slide at any of their contacts, and the contacts
    /// of two grains have their own velocities where only one turns.
    #[test]
    fn clumps_slide_by_the_velocity_of_their_surfaces() {
        let mut assembly = clumps::few();
        let (spin, point) = ([0.3, -0.5, 0.7], [1.0, 4.0, -2.0]);
        for body in &mut assembly.bodies {
            body.spin = spin;
            body.velocity = cross(&spin, &std::array::from_fn(|a| body.position[a] - point[a]));
        }
        for contact in &assembly.contacts {
            let [roll, slide] = squares(&assembly, contact).unwrap();
            assert!(roll < 1e-28 && slide < 1e-28, "{roll} {slide}");
        }
        // The first turns about its centre by 1 about z: the surfaces at (+-0.5, 0.5, 0) move by -0.5 along x, which is slip, and by
        // +-0.5 along y, which is not; both contacts roll by R* = 1/4.
        assembly.bodies.iter_mut().for_each(|body| (body.spin, body.velocity) = ([0.0; 3], [0.0; 3]));
        assembly.bodies[0].spin = [0.0, 0.0, 1.0];
        for contact in &assembly.contacts[..2] {
            let [roll, slide] = squares(&assembly, contact).unwrap();
            assert!((roll - 1.0 / 16.0).abs() < 1e-14 && (slide - 0.25).abs() < 1e-14, "{roll} {slide}");
        }
    }
}
