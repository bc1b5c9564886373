//! Readings of a laboratory's file that are probably not what they are taken for, each with the evidence and how to say what is meant.
//!
//! Nothing is changed by a doubt: it is told, and who knows better states the convention.

use std::f64::consts::SQRT_2;

use granum_core::quantity::format_number;

use super::conventions::{Conventions, DeviatorMeasure};
use super::laboratory_test::{LaboratoryDoubt, LaboratoryTest, Readings};

/// Smallest and largest mean stress at the start of a test of soil or powder, Pa, that is believed.
const PRESSURES: [f64; 2] = [1e3, 20e6];
/// Tests go beyond this axial strain.
const LEAST_STRAIN: f64 = 0.005;
/// A slope at the start below this share of the steepest later one is bedding and no stiffness.
const BEDDING_SLOPE: f64 = 0.04;

/// The doubts about a test.
pub(super) fn doubts(
    test: &LaboratoryTest,
    readings: &Readings,
    stated: &Conventions,
) -> Vec<LaboratoryDoubt> {
    let checks = [
        strain_unit(test),
        stress_unit(test),
        deviator_measure(test, readings, stated),
        total_stress(test, readings, stated),
        kind_of_strain(test, readings, stated),
        sign_of_volume(readings),
        bedding(test, stated),
        name(test),
    ];
    checks.into_iter().flatten().collect()
}

fn doubt(evidence: String, remedy: impl Into<String>) -> Option<LaboratoryDoubt> {
    Some(LaboratoryDoubt { evidence, remedy: remedy.into() })
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most: f64, value| most.max(value.abs()))
}

fn strain_unit(test: &LaboratoryTest) -> Option<LaboratoryDoubt> {
    let most = largest(&test.axial_strain);
    if most >= LEAST_STRAIN || most == 0.0 {
        return None;
    }
    let evidence = format!("the axial strain ends at {} %", format_number(100.0 * most));
    doubt(
        evidence,
        "if the column holds shares and not per cent, state its unit: --map axial_strain='COLUMN (1)'",
    )
}

fn stress_unit(test: &LaboratoryTest) -> Option<LaboratoryDoubt> {
    let first = *test.mean_stress.first()?;
    if first == 0.0 || (PRESSURES[0]..=PRESSURES[1]).contains(&first) {
        return None;
    }
    let evidence = format!("the mean stress at the start is {} Pa", format_number(first));
    doubt(
        evidence,
        "stresses of such tests are 1 kPa to 20 MPa; state the unit: --map axial_stress='COLUMN (kPa)' and so on",
    )
}

/// In a drained test with constant lateral stress q rises three times as fast as p.
fn deviator_measure(
    test: &LaboratoryTest,
    readings: &Readings,
    stated: &Conventions,
) -> Option<LaboratoryDoubt> {
    if stated.deviator.is_some() {
        return None;
    }
    let q = readings.column("deviator_stress");
    let [axial, lateral] = ["axial_stress", "lateral_stress"].map(|name| readings.column(name));
    let (found, seen) = if !axial.is_empty() && axial.len() == lateral.len() && axial.len() == q.len() {
        let (mut product, mut square) = (0.0, 0.0);
        for ((q, a), l) in q.iter().zip(&axial).zip(&lateral) {
            product += q * (a - l);
            square += (a - l) * (a - l);
        }
        (product / square, "the difference of axial and lateral stress")
    } else {
        let p = &test.mean_stress;
        if q.is_empty() || q.len() != p.len() || !axial.is_empty() {
            return None;
        }
        // Drained at constant lateral stress: a straight path from the start.
        let [first_p, first_q] = [p.first()?, q.first()?];
        let path: Vec<[f64; 2]> = p.iter().zip(&q).map(|(p, q)| [p - first_p, q - first_q]).collect();
        (straight_slope(&path)? / 3.0, "three times the rise of the mean stress")
    };
    let near = |share: f64| (found / share - 1.0).abs() < 0.03;
    if near(1.0) || !found.is_finite() {
        return None;
    }
    let names = DeviatorMeasure::ALL.iter().find(|(measure, _)| near(measure.share()));
    let evidence = format!("the deviator stress is {found:.3} times {seen}");
    match names {
        Some((_, word)) => doubt(
            evidence,
            format!("it is taken as axial minus lateral stress; if it is not: --as deviator_stress={word}"),
        ),
        None if near(SQRT_2) || near(1.0 / SQRT_2) => doubt(
            evidence,
            "a factor of sqrt(2) is in its definition; give axial_stress and lateral_stress instead",
        ),
        None => None,
    }
}

/// The slope of a path that is straight to one per cent of its length; `None` for a bent or a short one.
fn straight_slope(path: &[[f64; 2]]) -> Option<f64> {
    let (mut product, mut square) = (0.0, 0.0);
    for [x, y] in path {
        product += x * y;
        square += x * x;
    }
    let slope = product / square;
    let length = path.iter().fold(0.0f64, |most, [_, y]| most.max(y.abs()));
    let bent = path.iter().any(|[x, y]| (y - slope * x).abs() > 0.03 * length);
    (slope.is_finite() && slope > 0.0 && path.len() > 4 && !bent).then_some(slope)
}

/// Without change of volume the pore pressure changes, and the effective lateral stress with it: one that does not is a total stress.
fn total_stress(test: &LaboratoryTest, readings: &Readings, stated: &Conventions) -> Option<LaboratoryDoubt> {
    let lateral = readings.column("lateral_stress");
    let first = *lateral.first()?;
    let constant = lateral.iter().all(|value| (value - first).abs() < 0.02 * first.abs());
    let no_volume = !test.volumetric_strain.is_empty() && largest(&test.volumetric_strain) < 2e-4;
    if stated.total_stress.is_some() || !(constant && no_volume && largest(&test.axial_strain) > 0.02) {
        return None;
    }
    let evidence =
        "the volume does not change while the lateral stress stays constant, as a total stress does"
            .to_string();
    doubt(
        evidence,
        "stresses are taken as effective ones; if they are total: --as stress=total, with a column pore_pressure",
    )
}

/// Void ratio and volumetric strain tell each other, by one law for each kind of strain.
fn kind_of_strain(
    test: &LaboratoryTest,
    readings: &Readings,
    stated: &Conventions,
) -> Option<LaboratoryDoubt> {
    let (e, strain) = (readings.column("void_ratio"), readings.signed("volumetric_strain"));
    if e.len() != strain.len() || largest(&strain) < 0.02 || test.axial_strain.is_empty() {
        return None;
    }
    let first = *e.first()?;
    let misfit = |volume: fn(f64) -> f64| {
        let apart = e.iter().zip(&strain).map(|(e, v)| ((1.0 + first) * volume(*v) - 1.0 - e).abs());
        apart.fold(0.0, f64::max)
    };
    let [engineering, logarithmic] = [misfit(|v| 1.0 - v), misfit(|v| libm::exp(-v))];
    let is_logarithmic = stated.logarithmic == Some(true);
    let (own, other, word, taken) = if is_logarithmic {
        (logarithmic, engineering, "engineering", "logarithmic")
    } else {
        (engineering, logarithmic, "logarithmic", "engineering")
    };
    if own < 5.0 * other || own < 5e-4 {
        return None;
    }
    let evidence = format!(
        "void ratio and volumetric strain differ by up to {own:.4} in e as {taken} strains, and by {other:.4} as {word} ones"
    );
    doubt(evidence, format!("if strains are {word}: --as strain={word}"))
}

/// A void ratio that rises where the volumetric strain says contraction.
fn sign_of_volume(readings: &Readings) -> Option<LaboratoryDoubt> {
    let (e, strain) = (readings.column("void_ratio"), readings.signed("volumetric_strain"));
    if e.len() != strain.len() || largest(&strain) < 0.005 {
        return None;
    }
    let first = *e.first()?;
    let misfit = |sign: f64| {
        let apart = e.iter().zip(&strain).map(|(e, v)| ((1.0 + first) * (1.0 - sign * v) - 1.0 - e).abs());
        apart.fold(0.0, f64::max)
    };
    if misfit(1.0) < 5.0 * misfit(-1.0) {
        return None;
    }
    doubt(
        "the void ratio rises where the volumetric strain, taken as positive in compression, says contraction".into(),
        "if it is positive in dilation: --compression volumetric_strain=negative",
    )
}

/// A stiffness at the start of a hundredth of the rest is a plate that settles, or a membrane that is pressed in.
fn bedding(test: &LaboratoryTest, stated: &Conventions) -> Option<LaboratoryDoubt> {
    let (x, q) = (&test.axial_strain, &test.deviator_stress);
    if stated.bedding_strain.is_some() || x.len() != q.len() || x.len() < 6 {
        return None;
    }
    let slope = |k: usize| (q[k + 1] - q[k]) / (x[k + 1] - x[k]);
    let slopes: Vec<f64> = (0..x.len() - 1).map(|k| if x[k + 1] > x[k] { slope(k) } else { 0.0 }).collect();
    let steepest = slopes.iter().copied().fold(0.0, f64::max);
    let soft = slopes.iter().take_while(|slope| **slope < BEDDING_SLOPE * steepest).count();
    if soft == 0 || soft + 2 > slopes.len() || x[soft] <= x[0] || x[soft] > 0.05 {
        return None;
    }
    let evidence = format!(
        "up to an axial strain of {} % the deviator stress rises with less than {} % of its steepest slope",
        format_number(100.0 * x[soft]),
        format_number(100.0 * BEDDING_SLOPE)
    );
    let end = format_number(100.0 * x[soft]);
    doubt(
        evidence,
        format!("if the plate settled on the sample: --as bedding_strain='{end} %' leaves that out"),
    )
}

/// A pressure in the name of a test, such as `dense-100kPa`, that is not that of its first reading.
fn name(test: &LaboratoryTest) -> Option<LaboratoryDoubt> {
    let lower = test.name.to_lowercase();
    let before = lower.split("kpa").next().filter(|before| before.len() < lower.len())?;
    let digits: String =
        before.trim_end_matches([' ', '_', '-']).chars().rev().take_while(char::is_ascii_digit).collect();
    let named = digits.chars().rev().collect::<String>().parse::<f64>().ok()? * 1e3;
    let first = *test.mean_stress.first()?;
    if (first / named - 1.0).abs() < 0.25 || named == 0.0 {
        return None;
    }
    let evidence = format!(
        "the name of the test says {} kPa, and its first reading a mean stress of {} kPa",
        format_number(named / 1e3),
        format_number((first / 1e2).round() / 10.0)
    );
    doubt(
        evidence,
        "look which of them is right: units, columns, or readings that were left out at the start",
    )
}

#[cfg(test)]
mod tests {
    use super::super::tests::tests;
    use super::*;

    /// A test along a path with constant lateral stress: axial strain in per cent, axial and lateral stress in kPa.
    fn found(header: &str, row: impl Fn(f64) -> String) -> Vec<String> {
        let rows: Vec<String> = (0..40).map(|k| row(f64::from(k) * 0.5)).collect();
        let text = format!("{header}\n{}\n", rows.join("\n"));
        let test = tests(&text, &Conventions::default()).unwrap().remove(0);
        test.doubts.iter().map(ToString::to_string).collect()
    }

    fn q(strain: f64) -> f64 {
        250.0 * strain / (1.0 + strain)
    }

    const STRESSES: &str = "axial_strain (%),axial_stress (kPa),lateral_stress (kPa)";

    #[test]
    fn a_sound_test_is_not_doubted() {
        let sound = found(&format!("{STRESSES},volumetric_strain (%)"), |e| {
            format!("{e},{},100,{}", 100.0 + q(e), 0.3 - 0.2 * e)
        });
        assert_eq!(sound, Vec::<String>::new());
        let invariants = found("axial_strain (%),deviator_stress (kPa),mean_stress (kPa)", |e| {
            format!("{e},{},{}", q(e), 100.0 + q(e) / 3.0)
        });
        assert_eq!(invariants, Vec::<String>::new());
    }

    #[test]
    fn other_measures_of_the_deviator_are_named() {
        let header = "axial_strain (%),deviator_stress (kPa),mean_stress (kPa)";
        for (share, part) in [
            (0.5, "--as deviator_stress=half"),
            ((2.0f64 / 3.0).sqrt(), "--as deviator_stress=norm"),
            (SQRT_2 / 3.0, "--as deviator_stress=octahedral"),
            (SQRT_2, "factor of sqrt(2)"),
        ] {
            let doubts = found(header, |e| format!("{e},{},{}", share * q(e), 100.0 + q(e) / 3.0));
            assert!(doubts.len() == 1 && doubts[0].contains(part), "{share}: {doubts:?}");
        }
        // Where all stresses are given the path does not matter.
        let doubts = found(&format!("{STRESSES},deviator_stress (kPa)"), |e| {
            format!("{e},{},{},{}", 100.0 + q(e) - e, 100.0 - e, 0.5 * q(e))
        });
        assert!(doubts.len() == 1 && doubts[0].contains("half"), "{doubts:?}");
        // An undrained path bends, and tells nothing.
        let bent = found(header, |e| format!("{e},{},{}", q(e), 100.0 - 3.0 * e + 0.2 * e * e));
        assert_eq!(bent, Vec::<String>::new());
    }

    #[test]
    fn a_volumetric_strain_of_the_other_sign_is_doubted() {
        let header = format!("{STRESSES},volumetric_strain (%),void_ratio");
        let row = |sign: f64| {
            move |e: f64| {
                let volume = -0.3 * e;
                format!("{e},{},100,{volume},{}", 100.0 + q(e), 1.7 * (1.0 - sign * volume / 100.0) - 1.0)
            }
        };
        assert_eq!(found(&header, row(1.0)), Vec::<String>::new());
        let doubts = found(&header, row(-1.0));
        assert!(
            doubts.len() == 1 && doubts[0].contains("--compression volumetric_strain=negative"),
            "{doubts:?}"
        );
    }

    #[test]
    fn units_total_stresses_bedding_and_names_are_doubted() {
        let unit = found(&STRESSES.replace("kPa", "Pa"), |e| format!("{e},{},100", 100.0 + q(e)));
        assert!(unit.len() == 1 && unit[0].contains("at the start is 100 Pa"), "{unit:?}");
        let share = found(STRESSES, |e| format!("{},{},100", e / 100.0, 100.0 + q(e)));
        assert!(share.len() == 1 && share[0].contains("ends at 0.195 %"), "{share:?}");
        let total =
            found(&format!("{STRESSES},volumetric_strain (%)"), |e| format!("{e},{},100,0", 100.0 + q(e)));
        assert!(total.len() == 1 && total[0].contains("--as stress=total"), "{total:?}");
        let settled =
            found(STRESSES, |e| format!("{e},{},100", 100.0 + if e < 1.2 { 0.5 * e } else { q(e - 1.0) }));
        assert!(settled.len() == 1 && settled[0].contains("--as bedding_strain='1 %'"), "{settled:?}");
        let twice =
            found(STRESSES, |e| format!("{},{},100", (e - 0.5f64).max(0.0), 100.0 + q((e - 0.5).max(0.0))));
        assert_eq!(twice, Vec::<String>::new(), "the first reading, written twice, is no bedding");
        let named = found(&format!("{STRESSES},test"), |e| format!("{e},{},100,loose 400 kPa", 100.0 + q(e)));
        assert!(named.len() == 1 && named[0].contains("says 400 kPa"), "{named:?}");
    }

    #[test]
    fn the_void_ratio_tells_the_kind_of_strain() {
        let header = format!("{STRESSES},volumetric_strain (%),void_ratio");
        let row = |logarithmic: bool| {
            move |e: f64| {
                let volume = -0.004 * e;
                let ratio = if logarithmic { (-volume).exp() } else { 1.0 - volume };
                format!("{e},{},100,{},{}", 100.0 + q(e), 100.0 * volume, 1.7 * ratio - 1.0)
            }
        };
        assert_eq!(found(&header, row(false)), Vec::<String>::new());
        let doubts = found(&header, row(true));
        assert!(doubts.len() == 1 && doubts[0].contains("--as strain=logarithmic"), "{doubts:?}");
        let doubts = found(&format!("# strain = logarithmic\n{header}"), row(false));
        assert!(doubts.len() == 1 && doubts[0].contains("--as strain=engineering"), "{doubts:?}");
    }
}
