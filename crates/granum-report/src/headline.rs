//! The main numbers of a run, with the convention of signs and the meaning of symbols.

use granum_run::strength::COHESIVE;

use super::data::RunReport;
use super::figure::literal;
use super::numbers::significant;
use super::{path, strength};

/// The conventions for signs and axes, which every report states once.
pub const SIGNS: &str = "Compression is positive, for stress, strain and normal force. Axis 1 is the axis of compression, \
                         axes 2 and 3 are averaged: *q* = *σ*_{1} − *σ*_{3}, *p* = (*σ*_{1} + *σ*_{2} + *σ*_{3})/3, \
                         *ε*_{d} = *ε*_{1} − *ε*_{3}, *φ*_{d} = *φ*_{1} − *φ*_{3}. Strains are logarithmic.";

/// The same for tests along any path.
const SIGNS_OF_ANY_TEST: &str = "Compression is positive, for stress, strain and normal force. *p* is the mean stress; *q* of a triaxial test is \
                               the axial less the mean lateral stress, *q*_{vM} = √(3 *J*_{2}) of any other test the von Mises stress; \
                               *ε*_{q} = √(2/3 *e*:*e*) with the deviator *e* of the strain. Axis 1 is *x*. Strains are \
                               logarithmic and count from the start of the last stage that resets them.";

/// Of a test that has not ended, or was stopped.
pub(crate) const UNFINISHED: &str =
    "The test did not reach its end; the states recorded until now are shown.";

/// The convention of signs and the meaning of symbols.
pub(crate) fn signs(run: &RunReport) -> &'static str {
    if run.is_at_constant_p() { SIGNS } else { SIGNS_OF_ANY_TEST }
}

/// The main numbers of a test.
pub(crate) fn of_test(run: &RunReport) -> Vec<[String; 3]> {
    let tile = |value: Option<f64>, name: &str, remark: String| {
        Some([significant(value?, 3), name.to_owned(), remark])
    };
    let measures = run.measures();
    let measure = |name: &str| measures.get(name).copied();
    let (symbol, strain) = match measure("deviator_strain_at_peak") {
        Some(strain) => ("*ε*_{d}", Some(strain)),
        None => ("*ε*_{q}", measure("deviatoric_strain_at_peak")),
    };
    let where_peak = strain.map_or(String::new(), |e| format!("at {symbol} = {}", significant(e, 2)));
    let mut out: Vec<Option<[String; 3]>> = vec![
        tile(measure("peak_stress_ratio"), "peak *q*/*p*", where_peak.clone()),
        tile(measure("peak_von_mises_ratio"), "peak *q*_{vM}/*p*", where_peak),
    ];
    if !path::Traits::from_stages(&run.case.test_stages()).goes_to_and_fro() {
        let remark = || "mean over the last quarter of the strain".to_owned();
        out.push(tile(measure("late_stress_ratio"), "late *q*/*p*", remark()));
        out.push(tile(measure("late_von_mises_ratio"), "late *q*_{vM}/*p*", remark()));
    }
    let degrees = |name: &str| measure(name).map(|angle| format!("{angle:.1}°"));
    out.push(degrees("peak_friction_angle").map(|peak| {
        let late = degrees("critical_friction_angle").map_or(String::new(), |late| format!("late: {late}"));
        let is_secant = measures.contains_key(COHESIVE);
        let name = if is_secant {
            "peak friction angle, of a secant: the grains are cohesive"
        } else {
            "peak friction angle"
        };
        [peak, name.into(), late]
    }));
    out.push(strength::liquefaction(&measures));
    for (name, value) in run.run.measures.iter().filter(|(name, _)| name.starts_with("k0_")) {
        let stage = literal(&name.trim_start_matches("k0_").replace('_', " "));
        let remark = format!("at the end of the stage {stage}");
        out.push(tile(Some(*value), "*K*_{0} = *σ*_{3}/*σ*_{1}", remark));
    }
    out.push(tile(run.first("solid_fraction"), "solid fraction before the test", String::new()));
    let z = run
        .first("coordination_number")
        .map_or(String::new(), |z| format!("*Z* = {} over all grains", significant(z, 3)));
    let of_sample = run.first("mechanical_coordination_number");
    out.push(tile(of_sample, "mechanical coordination number before the test", z));
    let flags = &run.run.quality;
    let held = flags.iter().filter(|flag| flag.passed).count();
    out.push((!flags.is_empty()).then(|| {
        let held = format!("{held} of {}", flags.len());
        [held, "quality checks passed".into(), "servo, rate, overlap, energy".into()]
    }));
    out.into_iter().flatten().collect()
}

/// The main numbers of a sample that was not sheared.
pub(crate) fn of_sample(run: &RunReport) -> Vec<[String; 3]> {
    let mut out = Vec::new();
    let mut tile = |name: &str, title: &str| {
        if let Some(value) = run.run.measures.get(name) {
            out.push([significant(*value, 3), title.to_owned(), String::new()]);
        }
    };
    tile("solid_fraction", "solid fraction");
    tile("coordination_number", "coordination number of all grains");
    tile("mechanical_coordination_number", "mechanical coordination number");
    tile("preparation_friction", "preparation friction");
    out
}
