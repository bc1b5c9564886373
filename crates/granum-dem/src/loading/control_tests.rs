//! The servo of a stage, on elastic solids.

use super::*;

const STILL: Matrix = [[0.0; 3]; 3];
const MEAN: [f64; 6] = [1.0, 1.0, 1.0, 0.0, 0.0, 0.0];

fn solved(control: &Control) -> servo::CellControl {
    control.solve(10.0, &STILL, &STILL, 1e8, None).unwrap()
}

fn held(value: f64) -> Target {
    Target::held(value)
}

/// Both forms of the paper's test give the established control.
#[test]
fn constant_mean_stress_is_a_case_of_the_law() {
    let speed = Speed::StrainRate(10.0);
    let fixed = Drive::Fixed;
    let rates = [Drive::Rate(1.0), Drive::Rate(-0.5), Drive::Rate(-0.5), fixed, fixed, fixed];
    let moving = Control { response: servo::RESPONSE, ..Control::new(speed, rates) }
        .with(Constraint::mean_stress(held(2e4)).moving([0.0, 1.0, 1.0, 0.0, 0.0, 0.0]));
    let paper = servo::CellControl::constant_mean_stress(0, 10.0, 2e4, 300.0);
    assert_eq!(solved(&moving), paper);
    // From the equations alone: the lateral strain rates are equal, and p is controlled through them.
    let free = [Drive::Rate(1.0), Drive::Free, Drive::Free, fixed, fixed, fixed];
    let found = solved(
        &Control::new(speed, free)
            .with(Constraint::strains([0.0, 1.0, -1.0, 0.0, 0.0, 0.0], 0.0))
            .with(Constraint::mean_stress(held(2e4))),
    );
    let row = found.rows[0].unwrap();
    for a in 0..3 {
        assert!((found.rate[a][a] - paper.rate[a][a]).abs() < 1e-12);
    }
    assert!(row.moves[0][0].abs() < 1e-15 && (row.moves[1][1] - row.moves[2][2]).abs() < 1e-15);
    assert!((row.moves[1][1] / row.stiffness - 0.5).abs() < 1e-12);
}

/// On an isotropic elastic solid that differs from the servo's estimate, constant p and b are reached and held.
#[test]
fn two_constraints_are_held_on_an_elastic_solid() {
    let b = 0.5;
    let free = [Drive::Rate(1.0), Drive::Free, Drive::Free, Drive::Fixed, Drive::Fixed, Drive::Fixed];
    let control = Control::new(Speed::StrainRate(10.0), free)
        .with(Constraint::stresses(MEAN, held(2e4)))
        .with(Constraint::stresses([-b, 1.0, b - 1.0, 0.0, 0.0, 0.0], held(0.0)));
    let drive = solved(&control);
    // Bulk modulus 1e8 and shear modulus 0.7e8; in the second case axis 2 is half as stiff, as in an anisotropic sample.
    for soft in [1.0, 0.5] {
        let stiff = |a: usize, c: usize| {
            let lame = 1e8 - 2.0 / 3.0 * 0.7e8;
            (lame + if a == c { 1.4e8 } else { 0.0 }) * if a == 1 || c == 1 { soft } else { 1.0 }
        };
        let (errors, stress) = follow(&drive, stiff, 20_000);
        assert!(errors < 1e-3, "{errors}");
        let found = (stress[1] - stress[2]) / (stress[0] - stress[2]);
        assert!((found - b).abs() < 1e-6 && stress[0] > 2.2e4, "{found} {stress:?}");
    }
}

/// A stress that increases at a given rate does not lag behind its target, on a solid that differs much from the servo's
/// estimate.
#[test]
fn a_moving_target_is_not_lagged_behind() {
    let target = Target::held(2e4).moving(2e7);
    let stress = Drive::Stress(target);
    let fixed = Drive::Fixed;
    for softness in [1.0, 0.2] {
        let control = Control::new(
            Speed::StrainRate(10.0),
            [stress, Drive::Stress(held(2e4)), Drive::Stress(held(2e4)), fixed, fixed, fixed],
        );
        let stiff = |a: usize, c: usize| softness * if a == c { 1.9e8 } else { 0.5e8 };
        let (errors, stress) = follow(&solved(&control), stiff, 40_000);
        assert!(errors < 1e-3, "{errors}");
        assert!((stress[0] / (2e4 + 2e7 * 40_000.0 * 1e-8) - 1.0).abs() < 1e-6, "{stress:?}");
    }
}

/// Applies a control to an elastic solid from 20 kPa; returns the root mean square of the largest error over p in the
/// second half, and the final stresses.
fn follow(drive: &servo::CellControl, stiff: impl Fn(usize, usize) -> f64, steps: usize) -> (f64, [f64; 3]) {
    let (mut stress, mut strain) = ([2e4; 3], [0.0; 3]);
    let mut servo = servo::Servo::default();
    let mut squares = 0.0;
    for step in 0..steps {
        let tensor = |v: &[f64; 3]| -> Matrix {
            std::array::from_fn(|r| std::array::from_fn(|c| if r == c { v[r] } else { 0.0 }))
        };
        let time = step as f64 * 1e-8;
        let sample = servo::ServoInput {
            stress: tensor(&stress),
            strain: tensor(&strain),
            bulk_modulus: 1e8,
            time,
            dt: 1e-8,
        };
        let gradient = servo.gradient(drive, &sample);
        let worst = drive
            .rows()
            .map(|row| (row.value(&sample.stress, &sample.strain) - row.aim(time)).abs())
            .fold(0.0, f64::max);
        if step > steps / 2 {
            squares += (worst / 2e4).powi(2);
        }
        let part: [f64; 3] = std::array::from_fn(|a| -gradient[a][a] * 1e-8);
        for a in 0..3 {
            stress[a] += (0..3).map(|c| stiff(a, c) * part[c]).sum::<f64>();
            strain[a] += part[a];
        }
    }
    ((squares / (steps as f64 / 2.0)).sqrt(), stress)
}

#[test]
fn equations_that_do_not_determine_the_rates_are_named() {
    let free = [Drive::Free, Drive::Free, Drive::Rate(1.0), Drive::Fixed, Drive::Fixed, Drive::Fixed];
    let few = Control::new(Speed::StrainRate(1.0), free).with(Constraint::mean_stress(held(1e4)));
    let text = few.check().unwrap_err().to_string();
    assert!(text.contains("5 equations") && text.contains("constraint 1"), "{text}");
    let twice = few.with(Constraint::stresses([2.0, 2.0, 2.0, 0.0, 0.0, 0.0], held(3e4)));
    let text = twice.check().unwrap_err().to_string();
    assert!(text.contains("constraint 2 repeats or contradicts"), "{text}");
    let good = few.with(Constraint::strains([1.0, -1.0, 0.0, 0.0, 0.0, 0.0], 0.0));
    assert_eq!(good.check(), Ok(()));
}

/// A saturated sample whose pore fluid has a bulk modulus: the mean stress and the volumetric strain times the modulus
/// are controlled together.
#[test]
fn stresses_and_strains_can_stand_in_one_constraint() {
    let fluid = 2e8;
    let free = [Drive::Rate(1.0), Drive::Free, Drive::Free, Drive::Fixed, Drive::Fixed, Drive::Fixed];
    let third = 1.0 / 3.0;
    let control = Control::new(Speed::StrainRate(10.0), free)
        .with(Constraint::strains([0.0, 1.0, -1.0, 0.0, 0.0, 0.0], 0.0))
        .with(Constraint {
            strain: [fluid, fluid, fluid, 0.0, 0.0, 0.0],
            stress: [third, third, third, 0.0, 0.0, 0.0],
            target: held(2e4),
            moves: None,
        });
    // Shear alone does not change the volume of an isotropic solid.
    let (errors, stress) = follow(&solved(&control), |a, c| if a == c { 1.9e8 } else { 0.5e8 }, 20_000);
    assert!(errors < 1e-3 && (stress.iter().sum::<f64>() / 6e4 - 1.0).abs() < 1e-3, "{errors} {stress:?}");
}
