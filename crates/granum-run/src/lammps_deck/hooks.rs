//! What a script tells to a program that follows it, and what it is asked for.
//!
//! A deck that is followed writes a line into the file `events` for the beginning and the end of each stage, and for each row; at the
//! end of each row all grains and contacts are written into files of their own. After each row it reads the file `request`: `go`,
//! `save` (write a restart file), or `stop` (write one and quit). The file is a command that sets a variable: an included file is read by
//! one processor for all, so that all see the same request, and no variable is deleted, after which fixes would use the one behind it. A
//! restart file has beside it a file with the numbers of the script.

use granum_dem::config::Spacing;
use granum_dem::loading::{Stage, Target};
use granum_dem::servo::Row;

use super::drive::target_mean_stress;
use super::names::{CONTACTS, EVENTS, GRAINS, REQUEST, RESTART, SAVE, STATE};

/// How a program follows the run of a deck.
#[derive(Clone, Debug)]
pub struct Follow {
    /// Observations of a recorded state.
    pub observations: usize,
    /// Largest number of end conditions of a stage.
    pub(super) conditions: usize,
}

impl Follow {
    /// To record the states of these stages, each with a number of observations.
    pub fn new(stages: &[Stage], observations: usize) -> Follow {
        let conditions = stages.iter().map(|stage| stage.until.len()).max().unwrap_or(0).max(1);
        Follow { observations: observations.max(1), conditions }
    }

    /// The numbers that a restart needs: name, and the variable that has its present value.
    fn numbers(&self) -> Vec<(String, String)> {
        let same = |name: &str| (name.to_string(), name.to_string());
        let mut all: Vec<(String, String)> = KEPT.iter().map(|name| same(name)).collect();
        // A restart file does not have the time.
        all.push(("saved_at".into(), "now".into()));
        all.extend([("g12_before".into(), "g12".into()), ("g23_before".into(), "g23".into())]);
        for n in 1..=6 {
            all.extend(KEPT_OF_STRESS.iter().map(|name| same(&format!("{name}{n}"))));
            all.push((format!("before{n}"), format!("integral{n}")));
            all.push((format!("sum_before{n}"), format!("sum{n}")));
        }
        for k in 0..self.conditions {
            all.extend(["sense", "turned_at"].map(|name| same(&format!("{name}{k}"))));
        }
        all
    }

    /// The commands by which the script writes a restart file.
    pub(super) fn save(&self) -> String {
        let mut text = format!("write_restart {RESTART}$(step:%.0f)\n");
        let mut word = "file";
        for (name, value) in self.numbers() {
            text += &format!(
                "print \"variable {name} equal $(v_{value}:%.17g)\" {word} {STATE}$(step:%.0f) screen no\n"
            );
            word = "append";
        }
        text + &format!(
            "print \"{COMPLETE}\" append {STATE}$(step:%.0f) screen no\n\
             print \"saved,$(step:%.0f)\" append {EVENTS} screen no\n\
             if \"${{request}} == stop\" then \"quit 0\"\n"
        )
    }

    /// Variables, computes and dumps, before the first `run`.
    pub(super) fn head(&self) -> String {
        let mut text = String::from(
            "\n# For the program that follows this run.\nvariable resumed string no\nvariable request string go\n",
        );
        // Those of the test have been given above.
        for (name, value) in self.numbers().into_iter().skip(OF_TEST) {
            let is_given = ["now", "g12", "g23"].contains(&value.as_str());
            if !is_given {
                text += &format!("variable {name} equal 0\n");
            }
            if value != name && !is_given {
                text += &format!("variable {value} equal 0\n");
            }
        }
        text + &format!(
            "variable dump_at equal $(step)\n\
             variable due equal (step<v_dump_at)*v_dump_at+(step>=v_dump_at)*{NEVER}\n\
             compute pairs all property/local patom1 patom2\n\
             compute forces all pair/local fx fy fz p1 p2 p3\n\
             dump grains all custom 1000 {GRAINS}* id x y z vx vy vz omegax omegay omegaz tqx tqy tqz\n\
             dump_modify grains every v_due first yes format float %.16g\n\
             dump contacts all local 1000 {CONTACTS}* c_pairs[1] c_pairs[2] c_forces[1] c_forces[2] c_forces[3] c_forces[4] c_forces[5] c_forces[6]\n\
             dump_modify contacts every v_due first yes format float %.12g\n"
        )
    }
}

/// A step that no run reaches and that LAMMPS can count to.
const NEVER: u32 = 2_000_000_000;
/// The last line of the file beside a restart file.
pub(crate) const COMPLETE: &str = "# complete";
/// The text of the columns of a dump of contacts.
pub(crate) const COLUMNS_OF_CONTACTS: [&str; 8] = ["patom1", "patom2", "fx", "fy", "fz", "p1", "p2", "p3"];

/// How many of the following numbers belong to the test and not to a stage.
const OF_TEST: usize = 11;
/// Numbers of the test, and of a stage, that keep their values until its end or until the next row.
const KEPT: [&str; 28] = [
    "stage",
    "x0",
    "y0",
    "z0",
    "time0",
    "walked",
    "a11",
    "a22",
    "a33",
    "a12",
    "a23",
    "began",
    "began_at",
    "began_p",
    "began_arc",
    "leg_at",
    "speed",
    "ease",
    "ramp_end",
    "direction",
    "turned",
    "every",
    "pace1",
    "pace2",
    "pace3",
    "pace4",
    "pace5",
    "pace6",
];
/// The same of each controlled stress.
const KEPT_OF_STRESS: [&str; 4] = ["target", "rate", "held", "held_since"];

/// The sequence that begins with a restart file, or goes on with the first stage.
pub(super) fn resume() -> String {
    format!(
        "if \"${{resume}} == 0\" then \"jump SELF first\"\ninclude {STATE}${{resume}}\nvariable shift equal $(v_saved_at-time)\n\
         variable resumed string yes\n\
         jump SELF set_$(v_stage:%.0f)\nlabel first\n"
    )
}

/// What is done about a request after a row, unless something else happens at its end. LAMMPS initialises everything when it writes a
/// restart file, so that `anew`, quoted commands, has to take the lengths of the box from there.
pub(super) fn request(pauses: &str, anew: &str) -> String {
    format!(
        "include {REQUEST}\n\
         if \"${{request}} != go && $({pauses}) < 0.5\" then \"include {SAVE}\"{anew} \"variable pre string yes\"\n"
    )
}

/// Formulas that the lines of a stage need.
pub(super) fn formulas(rows: &[(Row, Target)]) -> String {
    format!("variable target_p equal {}\n", target_mean_stress(rows).unwrap_or_else(|| "0".into()))
}

/// What a line says of an instant, beside the number of the stage.
const INSTANT: [&str; 18] = [
    "v_since",
    "dt",
    "v_e11",
    "v_e22",
    "v_e33",
    "v_g12",
    "v_g23",
    "v_arc",
    "v_l11",
    "v_l22",
    "v_l33",
    "v_l12",
    "v_l23",
    "v_target_p",
    "v_s11",
    "v_s22",
    "v_s33",
    "v_von_mises",
];

fn instant(kind: &str) -> String {
    let values: Vec<String> = INSTANT.iter().map(|value| format!("$({value}:%.17g)")).collect();
    format!("print \"{kind},$(v_stage:%.0f),$(step:%.0f),{}\" append {EVENTS} screen no\n", values.join(","))
}

/// The line of a row.
pub(super) fn observed() -> String {
    instant("row")
}

/// The line of the beginning of a stage, before which the cell is not strained by it.
pub(super) fn began() -> String {
    let zero = "variable l11 equal 0\nvariable l22 equal 0\nvariable l33 equal 0\nvariable l12 equal 0\nvariable l23 equal 0\n\
                variable target_p equal 0\n";
    format!("{zero}{}", instant("begin"))
}

/// Variables with the reasons for which the stage may be over.
pub(super) fn reasons(stage: &Stage) -> String {
    let conditions = 0..stage.until.len();
    let met: String = conditions.map(|k| format!("variable met{k} equal $(v_until{k})\n")).collect();
    format!("{met}variable was_lost equal $(v_lost)\nvariable was_long equal $(v_too_long)\n")
}

/// The line of the end of a stage: steps, time, way, mean stress at the end and at the beginning, whether it lost its stress or exceeded
/// its limits, which of its end conditions it met, and how well each controlled stress was held.
pub(super) fn ended(stage: &Stage, rows: usize) -> String {
    let mut words: Vec<String> = [
        "$(step-v_began:%.0f)",
        "$(v_lasted:%.17g)",
        "$(v_walked_here:%.17g)",
        "$(v_p:%.17g)",
        "$(v_began_p:%.17g)",
    ]
    .map(String::from)
    .to_vec();
    words.extend(["was_lost", "was_long"].map(|name| format!("$(v_{name}:%.0f)")));
    words.extend((0..stage.until.len()).map(|k| format!("$(v_met{k}:%.0f)")));
    words.extend((1..=rows).map(|n| format!("$(v_held{n}*sqrt(v_sum{n}/(step-v_held_since{n}+1e-9)):%.9g)")));
    format!("print \"end,$(v_stage:%.0f),{}\" append {EVENTS} screen no\n", words.join(","))
}

/// Strain of a row, at unit speed, so that every observation of a recorded state has a row of its own: two thirds of the way between
/// two of them, since the deviator strain may be half as fast again as the fastest component.
pub(super) fn spacing(stage: &Stage, observations: usize) -> Option<f64> {
    let record = &stage.record;
    let end = record.end;
    let between = match &record.spacing {
        Spacing::Every(interval) => *interval,
        Spacing::Equal => end / record.states.max(1) as f64,
        Spacing::Geometric(first) => first.max(1e-4 * end),
        Spacing::Strains(strains) => {
            let before = std::iter::once(0.0).chain(strains.iter().copied());
            let gaps = strains.iter().zip(before).map(|(strain, before)| strain - before);
            gaps.fold(f64::INFINITY, f64::min)
        }
    };
    (between > 0.0 && between.is_finite()).then_some(2.0 / 3.0 * between / observations as f64)
}
