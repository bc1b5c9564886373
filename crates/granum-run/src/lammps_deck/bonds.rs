//! Bonds as `bond_style bpm/rotational` of LAMMPS (Wang 2009), which has granum's model of a bond where that is attached halfway between the
//! centres of its two spheres: the same four springs and dashpots, and the sum of the four loads over their limits as the rule of rupture.
//!
//! ```text
//! bond_coeff n  k_n A  k_s A  k_s J  k_n I  F_n  F_s  M_t  M_b  c_n  c_s  2 c_b/l  2 c_t
//! ```
//! with the limits `sigma_c A, c A, c J/r_b, sigma_c I/r_b` and the dashpots c of stretch, shear, bending and twist. Angles are measured in
//! another way, so that loads of both programs meet to the second order in displacements over lengths and in angles.
//!
//! LAMMPS takes the places of the spheres as unstrained at the first step that sees a bond style, and their orientations as those of its axes. The
//! script therefore has the pairs from the beginning, with bonds that do nothing, and the bonds themselves from the first stage of the test on.

use std::collections::BTreeMap;

use granum_core::assembly::{Assembly, Bond};
use granum_dem::bond::{BondAttachment, BondKind, BondPlaces, BondShape, Bonding};
use granum_dem::simulation::Simulation;
use granum_io::Case;
use granum_io::packing::PackedBond;

use super::deck_error::DeckError;
use super::formula::number;
use super::names::BONDS;
use crate::laboratory::LaboratoryError;

/// A limit that no load of a sample comes near to, N or N m: of loads without a limit.
const NO_LIMIT: f64 = 1e300;
/// Stretch at which a bond without a strength in tension ruptures, m. LAMMPS sends spheres as far as this between processors, so that it is not
/// endless; its share in the sum of the four ratios is that of a stretch over a metre.
const ENDLESS_STRETCH: f64 = 1.0;
/// Largest difference of two radii, over their sum, at which the contact is halfway between the centres.
const ALIKE: f64 = 1e-9;
/// Shortest width of the cell over the longest bond: at half of it LAMMPS could take another image of a sphere.
const LEAST_WIDTH: f64 = 2.2;
/// Parts of its length to which the distance of two centres is written.
const DIGITS: f64 = 1e9;
/// How far LAMMPS looks for the other end of a bond, over the longest bond.
const REACH: f64 = 1.5;

/// What is to be known of a deck with bonds.
pub(super) const REMARKS: &str = "\
#
# Bonds are those of `bond_style bpm/rotational overlay/pair yes smooth no`: the contacts of bonded grains go on beside them. They are made
# where the test begins, by the pairs that granum bonds in the sample that was read, and carry nothing at that moment. Their loads meet granum's to
# the second order in displacements over lengths and in angles; stresses include their dashpots, which granum leaves out. The column `bonds` counts
# those that hold; it is 0 until they are made.
";

/// The bonds of a deck.
#[derive(Clone, Debug)]
pub(super) struct Bonds {
    /// The pairs, each with its type.
    pub(super) listed: Vec<PackedBond>,
    /// Commands that say how stiff and how strong the types are.
    pub(super) coefficients: String,
    /// Bulk modulus that they add to that of the contacts, Pa.
    pub(super) modulus: f64,
    /// Time step with them, s.
    pub(super) time_step: f64,
    /// Distance of the centres of the longest, m.
    longest: f64,
}

impl Bonds {
    /// The bonds that a case makes in a sample before its test; none if it makes none.
    ///
    /// # Errors
    /// [`DeckError`] with the key of `[[bond]]` or the grains that LAMMPS cannot have.
    pub(super) fn new(case: &Case, sample: &Simulation) -> Result<Option<Bonds>, DeckError> {
        let bondings = checked(case)?;
        if bondings.is_empty() {
            return Ok(None);
        }
        let mut bonded = sample.clone();
        for bonding in &bondings {
            bonded.bond(bonding).map_err(LaboratoryError::from)?;
        }
        let assembly = bonded.assembly();
        check_sample(&assembly, &bondings)?;
        let mut types: BTreeMap<String, u32> = BTreeMap::new();
        let (mut listed, mut coefficients) = (Vec::with_capacity(assembly.bonds.len()), String::new());
        let (mut stiffness, mut longest) = (0.0, 0.0f64);
        for bond in &assembly.bonds {
            let Some(bonding) = bonding_of(&bondings, bond) else { continue };
            let numbers = numbers(&assembly, bond, bonding);
            let square: f64 = bond.branch.iter().map(|x| x * x).sum();
            stiffness += numbers[0] * square;
            longest = longest.max(square.sqrt());
            let line = numbers.map(number).join(" ");
            let next = types.len() as u32 + 1;
            let kind = *types.entry(line).or_insert_with_key(|line| {
                coefficients += &format!("bond_coeff {next} {line}\n");
                next
            });
            listed.push(PackedBond { pieces: [bond.i, bond.j], kind });
        }
        check_cell(&assembly, longest)?;
        let modulus = stiffness / (9.0 * assembly.volume());
        Ok(Some(Bonds { listed, coefficients, modulus, time_step: bonded.state().time_step(), longest }))
    }

    /// The commands before the sample is read: bonded grains touch each other as others do.
    pub(super) fn before_sample() -> &'static str {
        "special_bonds lj 1 1 1 coul 1 1 1\n"
    }

    /// The commands after the sample was read: pairs whose bonds do nothing yet. `skin` is that of the lists of neighbours, m.
    pub(super) fn after_sample(&self, skin: f64) -> String {
        format!(
            "# The pairs that will be bonded.\nbond_style zero nocoeff\nbond_coeff *\ncomm_modify cutoff {}\n",
            number(REACH * self.longest + skin)
        )
    }

    /// The variables that count the bonds, and the number that hold, which is 0 until they are made.
    pub(super) fn count() -> &'static str {
        "\n# Bonds that hold: each is known to both of its grains.\n\
         compute held all nbond/atom\n\
         compute bonds all reduce sum c_held\n\
         variable made equal 0\n\
         variable bonds equal 0\n"
    }

    /// The commands that make the bonds, unstrained in the places of this moment.
    pub(super) fn make() -> String {
        format!(
            "\n# ---- The bonds are made ----\n\n\
             bond_style bpm/rotational overlay/pair yes smooth no\n\
             include {BONDS}\n\
             # The first step stores the places and takes the orientations as those of the axes.\n\
             set group all quat 0 0 1 0\n\
             variable made equal 1\n\
             run 0 post no\n\
             variable bonds equal $(v_made*0.5*c_bonds)\n"
        )
    }
}

/// The sets of bonds of a case, if LAMMPS has their laws and the deck their places.
pub(super) fn checked(case: &Case) -> Result<Vec<Bonding>, DeckError> {
    let laws = case.vocabulary.laws();
    let all = case.bonds.iter().enumerate();
    all.map(|(k, bond)| {
        let bonding = bond.bonding(laws);
        let refuse = |key, value: String, why: &str| {
            Err(DeckError::Setting { key, value, why: format!("table {} of the bonds: {why}", k + 1) })
        };
        if bond.before_stage() != 1 {
            let why = "which grains touch where that stage begins is known only to LAMMPS when it is there, and its `create_bonds` chooses pairs \
                       by the distance of their centres, not of their surfaces; make them before stage 1";
            return refuse("bond.before_stage", bond.before_stage().to_string(), why);
        }
        if bonding.places == BondPlaces::Inside {
            let why = "the grains are rigid until these bonds are made, and a script cannot release the bodies of `fix rigid/small` into spheres \
                       that are bonded; make the spheres a packing of their own with the section Bonds, and bond them by places = \"file\"";
            return refuse("bond.places", "\"inside\"".into(), why);
        }
        let name = bonding.law.name();
        if !BondKind::OWN.contains(&bonding.law) {
            let why = "LAMMPS has no such law; parallel, beam and additive can be";
            return refuse("bond.law", format!("{name:?}"), why);
        }
        if bonding.law != BondKind::ADDITIVE && can_rupture(&bonding) {
            let why = "its bonds rupture at the largest ratio of a stress to its strength, those of LAMMPS (bpm/rotational) at the sum of four ratios \
                       of loads to limits; take law = \"additive\", which has that rule, or bonds without strengths";
            return refuse("bond.law", format!("{name:?}"), why);
        }
        Ok(bonding)
    })
    .collect()
}

/// True if the bonds of a cylinder rupture under some load.
fn can_rupture(bonding: &Bonding) -> bool {
    ["tensile_strength", "cohesion"].iter().any(|key| bonding.value(key).is_some_and(f64::is_finite))
}

/// The set of bonds by which a bond was made.
fn bonding_of<'a>(bondings: &'a [Bonding], bond: &Bond) -> Option<&'a Bonding> {
    bondings.get((bond.kind as usize).wrapping_sub(1))
}

/// Refuses grains whose bonds LAMMPS would attach elsewhere, or not turn.
pub(super) fn check_sample(assembly: &Assembly, bondings: &[Bonding]) -> Result<(), DeckError> {
    if !assembly.all_spheres() {
        let why = "some of its grains have several pieces, which `fix rigid/small` moves without the orientations of the pieces that bonds of LAMMPS \
                   (bpm/rotational) are strained by; leave [[bond]] out, or take spheres";
        return Err(DeckError::Sample(why.into()));
    }
    for bond in &assembly.bonds {
        let at_contact =
            bonding_of(bondings, bond).is_some_and(|of| of.attachment == BondAttachment::Contact);
        let [Some(one), Some(two)] = [bond.i, bond.j].map(|k| assembly.bodies.get(k)) else { continue };
        let [a, b] = [one, two].map(|grain| grain.equivalent_radius);
        if at_contact && (a - b).abs() > ALIKE * (a + b) {
            let why = format!(
                "the bonded grains {} and {} have the radii {a:e} m and {b:e} m: granum attaches a bond where they touch, LAMMPS (bpm/rotational) \
                 halfway between their centres, so that shear and bending would be coupled in another way; give [[bond]] attachment = \"middle\", or take \
                 grains of one size",
                one.id, two.id
            );
            return Err(DeckError::Sample(why));
        }
    }
    Ok(())
}

/// Refuses a cell in which the nearest image of a sphere may not be the one that is bonded. Its edges are those of a box of LAMMPS, an upper triangle.
fn check_cell(assembly: &Assembly, longest: f64) -> Result<(), DeckError> {
    let width = (0..3).map(|k| assembly.cell[k][k]).fold(f64::INFINITY, f64::min);
    if width < LEAST_WIDTH * longest {
        let why = format!(
            "its cell is {width:e} m wide and a bond {longest:e} m long: LAMMPS bonds nearest images, which need a width of {LEAST_WIDTH} bonds; \
             take more grains"
        );
        return Err(DeckError::Sample(why));
    }
    Ok(())
}

/// The twelve numbers of a bond for `bond_coeff`.
fn numbers(assembly: &Assembly, bond: &Bond, bonding: &Bonding) -> [f64; 12] {
    let (law, values) = (bonding.law.law(), bonding.values());
    let shape = BondShape { radius: bond.radius, length: bond.length };
    let k = law.stiffness(&shape, &values);
    let factor = bonding.scatter.factor(bonding.seed, bond.id, shape.volume());
    let limits = if bonding.law == BondKind::ADDITIVE {
        law.limits(&shape, &values, factor)
    } else {
        [f64::INFINITY; granum_dem::bond::LIMITS]
    };
    let [tension, shear, bending, twisting] = std::array::from_fn(|n| limits[n].min(NO_LIMIT));
    let dashpots = bonding.dashpots(&k, [bond.i, bond.j].map(|end| mass_and_inertia(assembly, end)));
    let distance = bond.branch.iter().map(|x| x * x).sum::<f64>().sqrt();
    // Without the rounding of places, so that bonds that are alike are of one type.
    let distance = (distance / bond.length * DIGITS).round() / DIGITS * bond.length;
    [
        k.normal,
        k.shear,
        k.twisting,
        k.bending,
        tension.min(k.normal * ENDLESS_STRETCH),
        shear,
        twisting,
        bending,
        dashpots.normal,
        dashpots.shear,
        2.0 * dashpots.bending / distance,
        2.0 * dashpots.twisting,
    ]
}

/// Mass, kg, and moment of inertia, kg m2, of a sphere.
fn mass_and_inertia(assembly: &Assembly, sphere: usize) -> [f64; 2] {
    let body = assembly.bodies.get(sphere);
    body.map_or([0.0; 2], |body| [body.mass, 0.4 * body.mass * body.equivalent_radius.powi(2)])
}
