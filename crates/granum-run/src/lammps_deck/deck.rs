//! The deck: sample and script.

use std::io::Write;
use std::path::Path;

use granum_core::assembly::{Assembly, Body, Vector};
use granum_core::{Part, Parts};
use granum_dem::config::{NormalKind, Preparation};
use granum_dem::loading::{Control, Drive, Speed, Stage, Target, Until};
use granum_dem::preparation::is_loose;
use granum_dem::simulation::{Properties, Simulation};
use granum_io::atomic::write_atomically;
use granum_io::formats::lammps_data::LammpsData;
use granum_io::formats::{ObservedAssembly, ResultFormat};
use granum_io::{Case, OutputFolder, Packing};

use super::bodies::Bodies;
use super::bonds::Bonds;
use super::check::checked;
use super::deck_error::DeckError;
use super::drive::{self, Tilt};
use super::head::{Head, Stiffening, head};
use super::hooks::Follow;
use super::laws::{Contacts, pair_lines, rolling_follows_stress};
use super::motion::Motion;
use super::names::{BODIES, BONDS, DATA, SAVE, SCRIPT, SHARES, WEIGHTS};
use super::stage::{self, Setting};
use crate::laboratory::simulation;

/// Fraction of a velocity that is lost per `sqrt(m / k_t)` while a sample comes to rest, as in granum.
const SETTLING: f64 = 0.005;
/// Numbers of a usual sample, with which it is tried whether a deck is possible before there is one: bulk modulus, Pa, diameter, m, and
/// normal force of a contact, N.
const USUAL_MODULUS: f64 = 1e8;
const USUAL_DIAMETER: f64 = 1e-4;
const USUAL_FORCE: f64 = 1e-4;
/// Inertial number of the bound on the strain rates while the sample that was read comes to rest.
const REST_INERTIAL_NUMBER: f64 = 1e-3;

/// The stresses at which the sample comes to rest before its test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Confinement {
    /// Those that it has along each axis.
    Own,
    /// That to which the case prepares its sample.
    Prepared,
}

/// A sample and a script by which LAMMPS tests it as granum does.
///
/// ```
/// use granum_io::packing::PackedGrain;
/// use granum_io::{Case, Packing};
/// use granum_run::lammps_deck::{Confinement, LammpsDeck};
///
/// let case = Case::parse(
///     "[contact]\nnormal = 'hertz'\ntangential = 'no-slip'\n[preparation]\nmean_stress = '5 kPa'\n\
///      [[stage]]\npath = 'drained-triaxial'\n",
///     "case.toml",
/// )?;
/// // Two grains on a lattice, which touch each other across the faces of the cell.
/// let (radius, edge) = (5e-5, 0.99995e-4);
/// let grains = (0..2).map(|k| {
///     let x = (k as f64 + 0.5) * edge;
///     PackedGrain { id: k + 1, position: [x, 0.5 * edge, 0.5 * edge], radius }
/// });
/// let cell = [[2.0 * edge, 0.0, 0.0], [0.0, edge, 0.0], [0.0, 0.0, edge]];
/// let packing = Packing::new([0.0; 3], cell, grains.collect());
/// let deck = LammpsDeck::new(&case, &packing, Confinement::Own)?;
/// assert!(deck.script().contains("pair_coeff * * hertz/material 70000000000.0"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct LammpsDeck {
    assembly: Assembly,
    properties: Properties,
    script: String,
    /// The commands that write a restart file, of a deck that a program follows.
    save: Option<String>,
    bodies: Option<Bodies>,
    bonds: Option<Bonds>,
}

/// Refuses bonds in a run that a program follows: what LAMMPS tells it has neither their loads nor their ruptures.
fn without_bonds(case: &Case) -> Result<(), DeckError> {
    match case.bonds.len() {
        0 => Ok(()),
        count => Err(DeckError::Setting {
            key: "bond",
            value: format!("{count} tables"),
            why: "a run by LAMMPS reads grains and contacts back, but neither the loads of bonds nor their ruptures, so that stresses and energies would \
                  lack them; write a deck with `granum export --to lammps`, which LAMMPS can run by itself, or take --engine native"
                .into(),
        }),
    }
}

impl LammpsDeck {
    /// The deck of a case's test on a sample. The script first brings the sample to rest, since it begins without tangential forces,
    /// unless the first stage does so.
    ///
    /// # Errors
    /// [`DeckError`] with the key, the stage or the sample that LAMMPS cannot have.
    pub fn new(case: &Case, packing: &Packing, confinement: Confinement) -> Result<LammpsDeck, DeckError> {
        LammpsDeck::with(case, packing, confinement, None)
    }

    /// The same deck, which tells a program how far it is and does what that asks for.
    pub(crate) fn followed(
        case: &Case,
        packing: &Packing,
        confinement: Confinement,
    ) -> Result<LammpsDeck, DeckError> {
        let follow = Follow::new(&case.test_stages(), case.recording.observations_per_state);
        LammpsDeck::with(case, packing, confinement, Some(&follow))
    }

    /// Refuses a case whose test no deck can have, whatever its sample.
    pub(crate) fn check(case: &Case) -> Result<(), DeckError> {
        without_bonds(case)?;
        let stages = case.test_stages();
        let properties = case.properties().with_densities(density(&stages)?);
        let motions: Vec<Motion> =
            stages.iter().map(|stage| checked(stage, USUAL_MODULUS)).collect::<Result<_, _>>()?;
        only_tilt(&stages, &motions)?;
        let names: Vec<String> =
            properties.mixture.components.iter().map(|component| component.name.clone()).collect();
        let radius = 0.5 * case.grains.mean_diameter().unwrap_or(USUAL_DIAMETER);
        let of = Contacts { radius, force: USUAL_FORCE, follows: false, newer: false };
        pair_lines(&properties, &names, of).map(|_| ())
    }

    fn with(
        case: &Case,
        packing: &Packing,
        confinement: Confinement,
        follow: Option<&Follow>,
    ) -> Result<LammpsDeck, DeckError> {
        if follow.is_some() {
            without_bonds(case)?;
        }
        if follow.is_some() && !packing.bodies.is_empty() {
            let why = "some of its grains have several pieces, of which a run by LAMMPS is not read; write its deck with `granum export --to \
                       lammps`";
            return Err(DeckError::Sample(why.into()));
        }
        let stages = case.test_stages();
        let density = density(&stages)?;
        let mut sample = simulation(packing, case.properties().with_densities(density))?;
        sample.set_time_step_factor(case.numerics.time_step_factor);
        check(&sample, &case.preparation)?;
        let bonds = Bonds::new(case, &sample)?;
        let stages = with_rest(case, stages, &sample, confinement);
        let assembly = sample.assembly();
        let state = sample.state();
        let modulus = state.bulk_modulus();
        let motions: Vec<Motion> =
            stages.iter().map(|stage| checked(stage, modulus)).collect::<Result<_, _>>()?;
        let bodies = Bodies::new(&assembly, corner(&assembly))?;
        let [radius, mass] = means(&assembly.bodies);
        // What touches and is slowed down by a drag are pieces.
        let contact_radius = bodies.as_ref().map_or(radius, |bodies| bodies.piece_radius);
        let moved = bodies.as_ref().map_or(1.0, |bodies| bodies.atoms as f64 / assembly.bodies.len() as f64);
        let stiffening = stiffening(case.contact.normal);
        let pair = |follows| {
            let force = mean_force(&assembly);
            let of = Contacts { radius: contact_radius, force, follows, newer: bonds.is_some() };
            pair_lines(sample.properties(), &assembly.materials, of)
        };
        let moments = case.contact.rolling.law().acts();
        let follows = stiffening != Stiffening::None && rolling_follows_stress(&case.contact);
        let setting = Setting {
            unit_rate: sample.strain_rate(1.0, 1.0),
            modulus,
            drag: mass / moved * SETTLING * case.numerics.time_step_factor / state.time_step(),
            tilt: only_tilt(&stages, &motions)?,
            laws: if follows { pair(true)? } else { String::new() },
            follow,
            bodies: bodies.is_some(),
            bonds: bonds.is_some(),
        };
        let cube = |grain: &Body| grain.equivalent_radius.powi(3);
        let mut script = head(&Head {
            pair: &pair(false)?,
            moments,
            sheared: setting.tilt.is_some(),
            grains: assembly.bodies.len(),
            bodies: bodies.as_ref(),
            bonds: bonds.as_ref(),
            diameter: 2.0 * radius,
            volume: 4.0 / 3.0 * std::f64::consts::PI * assembly.bodies.iter().map(cube).sum::<f64>(),
            mean_stress: state.mean_stress(),
            modulus,
            time_step: state.time_step(),
            stiffening,
            follow,
        });
        // Stages count from 1, as in granum; what precedes them is stage 0.
        let first = if stages.len() > case.test_stages().len() { 0 } else { 1 };
        for (k, stage) in stages.iter().enumerate() {
            if bonds.is_some() && first + k == 1 {
                script += &Bonds::make();
                script += &super::head::look(true);
            }
            script += &stage::text(first + k, stage, &setting)?;
        }
        script += "\nprint \"all stages are complete\"\n";
        let properties = sample.properties().clone();
        Ok(LammpsDeck { assembly, properties, script, save: follow.map(Follow::save), bodies, bonds })
    }

    /// The script.
    pub fn script(&self) -> &str {
        &self.script
    }

    /// The sample with which the test begins.
    pub(crate) fn assembly(&self) -> &Assembly {
        &self.assembly
    }

    /// The properties of the contacts, with the densities of the test.
    pub(crate) fn properties(&self) -> &Properties {
        &self.properties
    }

    /// Number of grains.
    pub fn grains(&self) -> usize {
        self.assembly.bodies.len()
    }

    /// Writes sample and script into a folder.
    ///
    /// # Errors
    /// If the folder holds something else, or holds a deck and `force` is not set, or a file cannot be written.
    pub fn write(&self, folder: &Path, force: bool) -> Result<(), DeckError> {
        self.write_into(OutputFolder::create(folder, force)?.path())
    }

    /// Writes the files into a folder that exists.
    pub(crate) fn write_into(&self, folder: &Path) -> Result<(), DeckError> {
        let origin = corner(&self.assembly);
        let parts = Parts::new(&[Part::Cell, Part::Positions, Part::Radii, Part::Masses]);
        let mut observation = ObservedAssembly::new(self.assembly.clone(), parts, origin);
        if let Some(bonds) = &self.bonds {
            observation.listed_bonds = bonds.listed.clone();
        }
        LammpsData.write(&folder.join(DATA), &[observation])?;
        write_atomically(&folder.join(SCRIPT), |file| file.write_all(self.script.as_bytes()))?;
        if let Some(bodies) = &self.bodies {
            for (name, text) in
                [(BODIES, &bodies.infile), (WEIGHTS, &bodies.weights), (SHARES, &bodies.shares)]
            {
                write_atomically(&folder.join(name), |file| file.write_all(text.as_bytes()))?;
            }
        }
        if let Some(bonds) = &self.bonds {
            write_atomically(&folder.join(BONDS), |file| file.write_all(bonds.coefficients.as_bytes()))?;
        }
        if let Some(save) = &self.save {
            write_atomically(&folder.join(SAVE), |file| file.write_all(save.as_bytes()))?;
        }
        Ok(())
    }
}

/// The corner of a box that is centred on the origin, about which LAMMPS strains it.
fn corner(assembly: &Assembly) -> Vector {
    let edges = &assembly.cell;
    std::array::from_fn(|a| -0.5 * (edges[a][0] + edges[a][1] + edges[a][2]))
}

/// The factor on the densities in all stages but those in which the sample comes to rest.
fn density(stages: &[Stage]) -> Result<f64, DeckError> {
    let mut factors =
        stages.iter().filter(|stage| !stage.settling && !stage.is_mark()).map(|stage| stage.density_scaling);
    let first = factors.next().unwrap_or(1.0);
    match factors.find(|factor| *factor != first) {
        None => Ok(first),
        Some(other) => Err(DeckError::Setting {
            key: "stage.density_scaling",
            value: super::formula::number(other),
            why: format!("another stage has {first}; give all stages the same"),
        }),
    }
}

/// Whether LAMMPS can begin with a sample.
fn check(sample: &Simulation, preparation: &Preparation) -> Result<(), DeckError> {
    let edges = sample.state().cell().edges;
    if [edges[1][0], edges[2][0], edges[2][1]] != [0.0; 3] {
        let why = "its cell was sheared without rotation, and a box of LAMMPS has its first edge along x and its second in the plane \
                   of x and y";
        return Err(DeckError::Sample(why.into()));
    }
    if is_loose(sample, preparation) || sample.state().mean_stress() <= 0.0 {
        let why = "it is loose, and LAMMPS would have to compact it as granum does; make a sample of it with `granum prepare --packing`, \
                   and export that";
        return Err(DeckError::Sample(why.into()));
    }
    Ok(())
}

/// The stages with one before them in which the sample comes to rest, where the first does not do so.
fn with_rest(case: &Case, stages: Vec<Stage>, sample: &Simulation, confinement: Confinement) -> Vec<Stage> {
    // Bonds are made where the sample is at rest, also if the first stage of the test brings it to another stress.
    if case.bonds.is_empty() && stages.first().is_some_and(|stage| stage.settling) {
        return stages;
    }
    let own = sample.state().stress();
    let test = case.test_definition();
    let wanted = match confinement {
        Confinement::Prepared => Some(test.mean_stress(case.preparation.mean_stress)),
        Confinement::Own => test.initial_mean_stress,
    };
    let held = |a: usize| Drive::Stress(Target::held(wanted.unwrap_or(own[a][a])));
    let speed = Speed::InertialNumber { number: REST_INERTIAL_NUMBER, at: None };
    let drives = [held(0), held(1), held(2), Drive::Fixed, Drive::Fixed, Drive::Fixed];
    let control = Control { servo_limit: 1.0, ..Control::new(speed, drives) };
    let until = Until::AtRest { unbalanced_force: case.preparation.unbalanced_force };
    let rest = Stage::new("rest", control, vec![until]).with(|stage| {
        stage.settling = true;
        stage.resets = true;
    });
    [rest].into_iter().chain(stages).collect()
}

/// The one tilt of the box that the stages change.
fn only_tilt(stages: &[Stage], motions: &[Motion]) -> Result<Option<Tilt>, DeckError> {
    let mut found = None;
    for (stage, motion) in stages.iter().zip(motions) {
        for tilt in drive::tilts(motion) {
            if found.is_some_and(|other| other != tilt) {
                let why = "a box of LAMMPS is sheared in xy or in yz, but not in both in one test".into();
                return Err(DeckError::Stage { stage: stage.name.clone(), why });
            }
            found = Some(tilt);
        }
    }
    Ok(found)
}

fn stiffening(normal: NormalKind) -> Stiffening {
    if normal == NormalKind::HOOKE {
        Stiffening::None
    } else if normal == NormalKind::JKR {
        Stiffening::Adhesive
    } else {
        Stiffening::Hertz
    }
}

/// Mean radius, m, and mean mass, kg.
fn means(grains: &[Body]) -> [f64; 2] {
    let count = grains.len().max(1) as f64;
    let sum = |of: fn(&Body) -> f64| grains.iter().map(of).sum::<f64>() / count;
    [sum(|grain| grain.equivalent_radius), sum(|grain| grain.mass)]
}

/// Mean normal force of the contacts in compression, N.
fn mean_force(assembly: &Assembly) -> f64 {
    let forces = || assembly.contacts.iter().map(|contact| contact.normal_force).filter(|force| *force > 0.0);
    forces().sum::<f64>() / forces().count().max(1) as f64
}
