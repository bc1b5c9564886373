//! The end of a stage, and where it turns round, as variables of the script.

use granum_dem::loading::{Measure, Stage, Until};

use super::formula::{number, of_measure, term};

/// Steps between two checks whether the sample is at rest.
pub(super) const REST_EVERY: u32 = 500;

/// The numbers that the end of a stage compares with, taken where the stage begins.
pub(super) fn constants(stage: &Stage) -> String {
    let mut text = String::new();
    for (k, until) in stage.until.iter().enumerate() {
        if let Until::Reaches { measure, value } = until {
            let measured = of_measure(*measure).unwrap_or("0");
            text += &format!("variable sense{k} equal $(1-2*({}<{measured}))\n", term(*value));
        }
    }
    text
}

/// The numbers that belong to a point at which the stage turned round.
pub(super) fn turned(stage: &Stage) -> String {
    let mut text = String::new();
    for (k, until) in stage.until.iter().enumerate() {
        if let Until::DoubleAmplitude { measure, .. } = until {
            text += &format!("variable turned_at{k} equal $({})\n", of_measure(*measure).unwrap_or("0"));
        }
    }
    text
}

/// Variable `turns`, and `over`, `asked`, `lost` and `too_long`: whether the stage turns round here, is over, met one of its end
/// conditions, lost its stress, or exceeded its limits; `until0`, `until1` and so on are its end conditions. Halts the run there.
pub(super) fn formulas(stage: &Stage, rows: usize, has_ramp: bool) -> String {
    let mut text = String::from("\n# The end of the stage.\n");
    let mut met = Vec::new();
    let mut rest = None;
    for (k, until) in stage.until.iter().enumerate() {
        let condition = match *until {
            Until::Reaches { measure, value } => {
                let measured = of_measure(measure).unwrap_or("0");
                let left =
                    if value == 0.0 { measured.to_string() } else { format!("({measured}-{})", term(value)) };
                format!("(v_sense{k}*{left}>=0)")
            }
            Until::PorePressureRatio(ratio) => format!("(v_p<={}*v_began_p)", number(1.0 - ratio)),
            Until::Reversals(count) => format!("(v_turned>={count})"),
            Until::RampOver if has_ramp => "(v_lasted>=v_ramp_end)".into(),
            Until::RampOver => "1".into(),
            Until::DoubleAmplitude { measure, value } => {
                let measured = of_measure(measure).unwrap_or("0");
                format!("(v_turned>0)*(abs({measured}-v_turned_at{k})>={})", number(value))
            }
            Until::AtRest { unbalanced_force } => {
                rest = Some((k, unbalanced_force));
                continue;
            }
            _ => continue,
        };
        text += &format!("variable until{k} equal {condition}\n");
        met.push(format!("v_until{k}"));
    }
    let lost = if rows > 0 { "(v_p<0.001*v_began_p)*(v_l11+v_l22+v_l33>=0)" } else { "0" };
    text += &format!("variable lost equal {lost}\nvariable too_long equal {}\n", too_long(stage, has_ramp));
    let halts: Vec<&str> = met.iter().map(String::as_str).chain(["v_lost", "v_too_long"]).collect();
    text += &format!("variable done equal {}\n", halts.join("||"));
    match stage.turns {
        None => text += "fix stop all halt 1 v_done > 0.5 error continue message no\n",
        Some(turns) => {
            let measured = of_measure(turns.measure).unwrap_or("0");
            text += &format!(
                "variable turns equal (v_direction>0)*({measured}>={})+(v_direction<0)*({measured}<={})\n\
                 variable halts equal v_done||v_turns\n\
                 fix stop all halt 1 v_halts > 0.5 error continue message no\n",
                term(turns.high),
                term(turns.low)
            );
        }
    }
    let mut over = "v_done".to_string();
    if let Some((k, unbalanced)) = rest {
        let arrived: String = (1..=rows).map(|n| format!("*(abs(v_error{n})<0.005*v_p)")).collect();
        let earliest = 3 * REST_EVERY;
        text += &format!(
            "variable calm equal (v_unbalanced<{}){arrived}\n\
             fix calm all ave/time {REST_EVERY} 1 {REST_EVERY} v_calm ave window 3\n\
             variable until{k} equal (f_calm>0.99)*(step-v_counted>={earliest})\n\
             fix rest all halt {REST_EVERY} v_until{k} > 0.5 error continue message no\n",
            number(unbalanced)
        );
        met.push(format!("v_until{k}"));
        over += &format!("||v_until{k}");
    }
    text + &format!("variable over equal {over}\nvariable asked equal {}\n", met.join("||"))
}

/// True if the stage ends at rest, so that fixes look for it.
pub(super) fn looks_for_rest(stage: &Stage) -> bool {
    stage.until.iter().any(|until| matches!(until, Until::AtRest { .. }))
}

/// As in granum the time of four times the way at full speed, or twice that which the stage is to take, and the way itself.
fn too_long(stage: &Stage, has_ramp: bool) -> String {
    let most = stage.most_arc_length.unwrap_or_else(|| 4.0 * goal(stage).unwrap_or(1.0));
    let mut time = format!("(v_lasted>{}/v_speed)", number(4.0 * most));
    for until in &stage.until {
        match until {
            Until::RampOver if has_ramp => time += "*(v_lasted>2*v_ramp_end)",
            Until::Reaches { measure: Measure::Time, value } => {
                time += &format!("*(v_lasted>{})", number(2.0 * value));
            }
            _ => {}
        }
    }
    match stage.most_arc_length {
        Some(most) => format!("{time}||(v_walked_here>{})", number(most)),
        None => time,
    }
}

/// The strain at which a stage ends, if it ends at one.
pub(super) fn goal(stage: &Stage) -> Option<f64> {
    stage.until.iter().find_map(|until| match until {
        Until::Reaches {
            measure:
                Measure::Strain(_)
                | Measure::AxialDeviatorStrain
                | Measure::VolumetricStrain
                | Measure::DeviatoricStrain,
            value,
        } => Some(value.abs()),
        _ => None,
    })
}
