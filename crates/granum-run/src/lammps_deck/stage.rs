//! A stage of a test as a part of the script.

use granum_dem::loading::Stage;

use super::check::checked;
use super::deck_error::DeckError;
use super::drive::{self, AXES, ENTRIES, Tilt, is_sheared};
use super::ends::{self, REST_EVERY};
use super::formula::number;
use super::head::{COLUMNS, at_ends, look};
use super::hooks::{self, Follow};
use super::motion::Motion;

/// Rows of the curve of a stage that ends at a strain.
const ROWS: f64 = 100.0;
/// Fewest and most steps of a row.
const STEPS_OF_ROW: [u32; 2] = [10, 2000];

/// What all stages share.
pub(super) struct Setting<'a> {
    /// Strain rate of an inertial number of one at a mean stress of one pascal, 1/s.
    pub(super) unit_rate: f64,
    /// Bulk modulus that constraints of strains and stresses are weighed with, Pa.
    pub(super) modulus: f64,
    /// Coefficient of the drag while a sample comes to rest, kg/s.
    pub(super) drag: f64,
    /// The tilt of the box that changes in some stage.
    pub(super) tilt: Option<Tilt>,
    /// Laws that change with the mean stress; empty if none do.
    pub(super) laws: String,
    /// How a program follows the run, if one does.
    pub(super) follow: Option<&'a Follow>,
    /// True if grains have several pieces.
    pub(super) bodies: bool,
    /// True if grains are bonded.
    pub(super) bonds: bool,
}

impl Setting<'_> {
    /// The variables with the place by which a grain follows the homogeneous strain, that of its centre.
    fn place(&self) -> [&'static str; 3] {
        if self.bodies { ["v_b_x", "v_b_y", "v_b_z"] } else { AXES }
    }
}

/// How the rows of a stage follow each other.
///
/// Found with the spring-dashpot-slider in two tests of the same sample: with an initialisation at each of 190 rows q/p was 0.08 % and p
/// 0.13 % too low at constant volume, in proportion to the time step and to the number of rows.
const RENEWAL: &str = "\
# LAMMPS is initialised again only where the time step has to change by a tenth: with each initialisation the box is a step ahead of
# the grains, which disturbs the contacts across its faces. The single step before it makes LAMMPS count the contacts with a new list of
# neighbours afterwards; at the end of a stage it counts them, since a run that is halted does not.
";

/// A step at the end of a run that was halted, after which contacts are counted and, for a program that follows, grains are written.
fn last_step(follow: Option<&Follow>) -> &'static str {
    match follow {
        Some(_) => "\"variable dump_at equal $(step+1)\" \"run 1 pre no post no\"",
        None => "\"run 1 pre no post no\"",
    }
}

/// Adds the chord from the last row to the way that the strain has gone, as granum does it for chords of 1e-5.
const WALK: &str = "\
if \"$(v_arc-v_walked) >= 1e-5\" then \"variable walked equal $(v_arc)\" \"variable a11 equal $(v_e11)\" \
\"variable a22 equal $(v_e22)\" \"variable a33 equal $(v_e33)\" \"variable a12 equal $(v_g12)\" \"variable a23 equal $(v_g23)\"
";

/// Bodies have velocities of their own, which a force of one step changes; the first half of it acts before that step, and the second in it.
const ONE_PUSH: &str = "\
fix push all addforce v_push_x v_push_y v_push_z
run 1 post no
unfix push
";

/// The text of a stage, of a number from 0.
pub(super) fn text(at: usize, stage: &Stage, setting: &Setting) -> Result<String, DeckError> {
    let motion = checked(stage, setting.modulus)?;
    let name: String = stage.name.chars().filter(|c| !c.is_control() && !"\"$&,".contains(*c)).collect();
    let turns = stage.turns.is_some();
    let follow = setting.follow;
    let mut text = format!(
        "\n# ---- Stage {at}: {name} ----\n\nprint \"stage {at}: {name}\"\nvariable stage equal {at}\n"
    );
    if stage.resets {
        text += "variable x0 equal $(lx)\nvariable y0 equal $(ly)\nvariable z0 equal $(lz)\nvariable time0 equal $(v_now)\n\
                 variable g12_before equal 0\nvariable g23_before equal 0\n\
                 variable g12 equal v_g12_before\nvariable g23 equal v_g23_before\n";
        text += super::head::NO_WAY;
    }
    text += &begin(stage, &motion, setting);
    if follow.is_some() {
        text += &hooks::began();
        // A run that goes on from a restart file has the numbers above from its own file.
        text += &format!("label set_{at}\n{}", drive::values(&motion));
    }
    text += &formulas(stage, &motion, setting);
    if follow.is_some() {
        text += &format!("if \"${{resumed}} == yes\" then \"jump SELF go_{at}\"\n");
    }
    text += &format!("label begin_{at}\n");
    text += &start(at, stage, &motion, setting);
    text += &format!("label go_{at}\n{}", follow.map_or("", |_| "variable resumed string no\n"));
    text += &rows(at, stage, &motion, setting);
    if turns {
        text += &turn(at, stage, &motion, setting);
    }
    text += &format!(
        "label over_{at}\n\
         print \"stage {at} ended at step $(step:%.0f), axial strain $(v_e11:%.6g), p = $(v_p:%.6g) Pa\"\n"
    );
    if follow.is_some() {
        text += &hooks::ended(stage, motion.rows.len());
    }
    text += &end(&motion, stage, setting);
    text += &format!(
        "if \"${{met}} < 0.5\" then \"print 'stage {at} met none of its end conditions: the stages after it are not run'\" \"quit 0\"\n"
    );
    Ok(text)
}

/// The numbers that the stage begins with.
fn begin(stage: &Stage, motion: &Motion, setting: &Setting) -> String {
    let mut text = String::from(
        "variable began equal $(step)\nvariable began_at equal $(v_now)\nvariable began_p equal $(v_p)\n\
         variable began_arc equal $(v_arc)\nvariable leg_at equal $(v_now)\n",
    );
    for n in 1..=motion.rows.len() {
        text += &format!("variable before{n} equal 0\n");
        if setting.follow.is_some() {
            text += &format!(
                "variable held{n} equal 0\nvariable held_since{n} equal 0\nvariable sum_before{n} equal 0\n"
            );
        }
    }
    if stage.turns.is_some() {
        text += "variable direction equal 1\nvariable turned equal 0\n";
    }
    text += &drive::values(motion);
    text += &drive::constants(&stage.control, motion, setting.unit_rate);
    text += &ends::constants(stage);
    text += &ends::turned(stage);
    text + &length_of_row(stage, setting)
}

/// The formulas and fixes of the stage.
fn formulas(stage: &Stage, motion: &Motion, setting: &Setting) -> String {
    let turns = stage.turns.is_some();
    let mut text = String::from("variable counted equal $(step)\n");
    text += drive::shares(stage.control.eases);
    text += &drive::servo(motion, stage.control.servo_limit, turns, setting.follow.is_some());
    text += &drive::deformation(motion, setting.tilt, turns);
    text += &ends::formulas(stage, motion.rows.len(), motion.has_ramp());
    if stage.settling {
        text += &format!("fix drag all viscous {}\n", number(setting.drag));
    }
    if setting.follow.is_some() {
        text += &hooks::formulas(&motion.rows);
    }
    let means: Vec<&str> = COLUMNS.iter().map(|(_, what)| *what).collect();
    text + &format!("fix mean all ave/time 1 1 1 {} ave window ${{every}}\n", means.join(" "))
}

/// The rows of the stage, one after another.
fn rows(at: usize, stage: &Stage, motion: &Motion, setting: &Setting) -> String {
    let follow = setting.follow;
    let from_here = drive::from_here(motion, setting.tilt);
    // Laws of several types take effect with an initialisation only.
    let renew = if setting.laws.lines().count() > 1 { "1" } else { "abs(v_step_now/dt-1)>0.1" };
    let quoted: String = from_here.lines().map(|line| format!(" \"{line}\"")).collect();
    let due = follow.map_or("", |_| "variable dump_at equal $(step+v_every)\n");
    let mut text = format!("{RENEWAL}variable renew equal {renew}\ntimestep $(v_step_now)\n{from_here}");
    text += &format!(
        "variable pre string yes\nlabel stage_{at}\n{laws}{due}run ${{every}} pre ${{pre}} post no\nvariable pre string no\n\
         variable ended equal $(v_over)\nvariable met equal $(v_asked)\nvariable renewed equal $(v_renew)\n",
        laws = setting.laws
    );
    let mut pauses = "v_ended+v_renewed".to_string();
    if stage.turns.is_some() {
        text += "variable turning equal $(v_turns)\n";
        pauses += "+v_turning";
    }
    if follow.is_some() {
        text += &hooks::reasons(stage);
    }
    let (last, look, row) = (last_step(follow), look(setting.bonds), row(false, setting.bonds));
    text += &format!("if \"$({pauses}) > 0.5\" then {last}\n{look}{row}{WALK}");
    if follow.is_some() {
        text += &drive::holds(motion);
        text += &hooks::observed();
        text += &hooks::request(&pauses, &quoted);
    }
    if stage.turns.is_some() {
        text += &format!("if \"$(v_turning) > 0.5\" then \"jump SELF turn_{at}\"\n");
    }
    text + &format!(
        "if \"$(v_renewed) > 0.5\" then \"timestep $(v_step_now)\"{quoted} \"variable pre string yes\"\n\
         if \"$(v_ended) <= 0.5\" then \"jump SELF stage_{at}\"\n"
    ) + &if stage.turns.is_some() { format!("jump SELF over_{at}\n") } else { String::new() }
}

/// Turns the stage round: rates and the rates of targets change their sign, and grow again.
fn turn(at: usize, stage: &Stage, motion: &Motion, setting: &Setting) -> String {
    let mut text = format!(
        "label turn_{at}\nvariable turned equal $(v_turned+1)\nvariable met equal $(v_asked)\n{reasons}\
         if \"$(v_over) > 0.5\" then \"jump SELF over_{at}\"\n",
        reasons = if setting.follow.is_some() { hooks::reasons(stage) } else { String::new() }
    );
    text += &still(motion, true, setting);
    text += "variable direction equal $(-v_direction)\nvariable leg_at equal $(v_now)\n";
    for (k, (_, target)) in motion.rows.iter().enumerate() {
        if target.rate != 0.0 || target.ramp.is_some() {
            // A changing stress turns round at its present value, even if its target was ahead of it.
            text += &format!("variable target{n} equal $(v_value{n})\n", n = k + 1);
        }
    }
    text += &ends::turned(stage);
    text + &format!("jump SELF begin_{at}\n")
}

/// Number of steps of a row, and the row at the start of the stage.
fn length_of_row(stage: &Stage, setting: &Setting) -> String {
    let strain = match setting.follow {
        Some(follow) => hooks::spacing(stage, follow.observations),
        None => ends::goal(stage).map(|strain| strain / ROWS).or(match stage.record.spacing {
            granum_dem::config::Spacing::Every(interval) => Some(interval),
            _ => None,
        }),
    };
    let strain = strain.filter(|_| !stage.settling).unwrap_or(1.0);
    let [least, most] = STEPS_OF_ROW;
    let most = if stage.settling { REST_EVERY } else { most };
    format!(
        "\n# Rows of the curve: means over so many steps.\n{}\
         variable steps equal $(ceil({}/(v_speed*v_step_now)))\n\
         variable every equal $((v_steps<{least})*{least}+(v_steps>={least})*(v_steps<={most})*v_steps+(v_steps>{most})*{most}:%.0f)\n",
        row(true, setting.bonds),
        number(strain),
    )
}

/// Prints a row, of present values or of means; of what is counted only now and then, the mean of the two ends.
fn row(now: bool, bonds: bool) -> String {
    let mut words = vec!["$(v_stage:%.0f)".to_string(), "$(step:%.0f)".to_string()];
    for (k, (_, what)) in COLUMNS.iter().enumerate() {
        words.push(if now { format!("$({what}:%.9g)") } else { format!("$(f_mean[{}]:%.9g)", k + 1) });
    }
    words.extend(at_ends(bonds).iter().map(|(_, [before, at_end])| {
        let what = if now { (*at_end).to_string() } else { format!("0.5*({before}+{at_end})") };
        format!("$({what}:%.6g)")
    }));
    format!("print \"{}\" append ${{out}} screen no\n", words.join(","))
}

/// Gives the grains the velocities of the homogeneous strain, at once or as the rates grow; by the contacts alone they would get
/// them with a shock.
fn start(at: usize, stage: &Stage, motion: &Motion, setting: &Setting) -> String {
    let turns = stage.turns.is_some();
    let flow = drive::homogeneous(motion, turns, setting.place());
    if flow.iter().all(|part| part == "0") {
        return String::new();
    }
    let eases = stage.control.eases;
    let mut text = String::from("\n# The grains get the velocities of the homogeneous strain.\n");
    for (axis, flow) in AXES.into_iter().zip(&flow) {
        text += &if setting.bodies {
            let time = if eases { "$(v_ease)" } else { "dt" };
            format!("variable push_{axis} atom c_late[2]*({flow})/{time}\n")
        } else if eases {
            format!("variable push_{axis} atom mass*({flow})/$(v_ease)\n")
        } else {
            format!("variable push_{axis} atom v{axis}+({flow})\n")
        };
    }
    if !eases && setting.bodies {
        return text + &drive::from_here(motion, setting.tilt) + ONE_PUSH;
    }
    if !eases {
        return text + "velocity all set v_push_x v_push_y v_push_z\n";
    }
    let over = if turns { "v_over||v_turns" } else { "v_over" };
    let follow = setting.follow;
    let (due, observed) = match follow {
        Some(_) => ("variable dump_at equal $(step+v_part)\n", hooks::observed()),
        None => ("", String::new()),
    };
    text + &format!(
        "fix push all addforce v_push_x v_push_y v_push_z\ntimestep $(v_step_now)\n{from_here}\
         variable left equal ceil((v_ease-v_elapsed)/dt-1e-6)\nvariable pre string yes\n\
         label start_{at}\nvariable part equal $((v_left<v_every)*v_left+(v_left>=v_every)*v_every:%.0f)\n\
         {due}run ${{part}} pre ${{pre}} post no\nvariable pre string no\nvariable ended equal $({over}||(v_left<1))\n\
         if \"$(v_ended) > 0.5\" then {last}\n{look}{row}{WALK}{observed}\
         if \"$(v_ended) <= 0.5\" then \"jump SELF start_{at}\"\nunfix push\n",
        from_here = drive::from_here(motion, setting.tilt),
        last = last_step(follow),
        look = look(setting.bonds),
        row = row(false, setting.bonds)
    )
}

/// Takes the velocities of the homogeneous strain away.
fn still(motion: &Motion, turns: bool, setting: &Setting) -> String {
    let flow = drive::homogeneous(motion, turns, setting.place());
    if flow.iter().all(|part| part == "0") {
        return String::new();
    }
    let mut text = String::new();
    for (axis, flow) in AXES.into_iter().zip(&flow) {
        text += &match setting.bodies {
            true => format!("variable push_{axis} atom -c_late[2]*$(v_share)*({flow})/dt\n"),
            false => format!("variable push_{axis} atom v{axis}-$(v_share)*({flow})\n"),
        };
    }
    if setting.bodies {
        // A run of its own, in which the box counts from where it is.
        return text + &drive::from_here(motion, setting.tilt) + ONE_PUSH;
    }
    text + "velocity all set v_push_x v_push_y v_push_z\n"
}

/// Takes away what belongs to the stage.
fn end(motion: &Motion, stage: &Stage, setting: &Setting) -> String {
    let judged = setting.follow.is_some();
    let mut text = still(motion, stage.turns.is_some(), setting);
    if setting.bodies {
        text += "variable rate_x equal 0\nvariable rate_y equal 0\nvariable rate_z equal 0\nvariable rate_xy equal 0\nvariable rate_yz equal 0\n";
    }
    if is_sheared(motion) {
        text += "variable g12_before equal $(v_g12)\nvariable g23_before equal $(v_g23)\n\
                 variable g12 equal v_g12_before\nvariable g23 equal v_g23_before\nunfix angles\n";
    }
    let any = |there: bool, fix: &'static str| there.then_some(fix);
    let moved = ENTRIES.iter().any(|(r, c, _)| motion.moves(*r, *c));
    let (rests, held) = (ends::looks_for_rest(stage), !motion.rows.is_empty());
    let fixes = [
        any(true, "stop"),
        any(rests, "rest"),
        any(rests, "calm"),
        any(true, "mean"),
        any(moved, "cell"),
        any(held, "integrals"),
        any(held && judged, "errors"),
        any(stage.settling, "drag"),
    ];
    text = fixes.into_iter().flatten().fold(text, |text, fix| text + &format!("unfix {fix}\n"));
    if judged {
        for n in 1..=motion.rows.len() {
            text += &format!("variable integral{n} equal 0\nvariable sum{n} equal 0\n");
        }
    }
    text
}
