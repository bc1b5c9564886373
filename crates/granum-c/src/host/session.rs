//! The points of a host: samples that are prepared when they are first asked for, and the store of all states.

use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use granum_core::geometry::Matrix;
use granum_dem::simulation::Simulation;
use granum_io::Case;
use granum_learn::SurrogateMethods;
use granum_point::{Increment, MaterialPoint, PointError, State, Store, Tangent, Trust};
use granum_run::Laboratory;

use super::configuration::{Configuration, InitialStress, MaterialConfiguration, TangentKind};
use crate::failure::Failure;

/// Share of the first stiffness of the sample that stands for the stiffness of a sample without load.
const UNLOADED: f64 = 0.01;

/// A sample, or why it cannot be made, once it was asked for.
type Sample = OnceLock<Result<Arc<MaterialPoint>, String>>;

/// The points of a host.
pub struct Session {
    configuration: Configuration,
    /// Folder of the configuration.
    folder: PathBuf,
    /// The samples of each material.
    samples: Vec<Vec<Sample>>,
    store: Store,
}

/// A question of a host about a point.
#[derive(Clone, Copy, Debug)]
pub struct PointQuestion {
    /// Number of the material, from 1.
    pub material: usize,
    /// Name of the point, from 1.
    pub name: u64,
    /// Ticket of its state; zero for the first one.
    pub ticket: u64,
    /// The stress that the host has, Pa, compression positive.
    pub stress: Matrix,
    /// True if the host carries only xx, yy, zz and xy, as in plane strain: the other components of the stress are those of the sample.
    pub is_plane: bool,
    /// The increment.
    pub increment: Increment,
}

/// The answer to a host.
#[derive(Clone, Debug)]
pub struct PointAnswer {
    /// Ticket of the new state.
    pub ticket: u64,
    /// The new state.
    pub state: State,
    /// The stiffness, Pa, if it was asked for.
    pub stiffness: Option<[[f64; 6]; 6]>,
}

impl Session {
    /// Reads a configuration and, if it names one that is there, the file of its states.
    ///
    /// # Errors
    /// [`Failure`] if one of them cannot be used.
    pub fn open(path: &Path) -> Result<Session, Failure> {
        let configuration = Configuration::read(path)?;
        let folder = path.parent().map_or_else(PathBuf::new, Path::to_path_buf);
        let store = match configuration.restart.as_ref().map(|restart| folder.join(restart)) {
            Some(restart) if restart.exists() => Store::load(&restart)?,
            _ => Store::new(),
        };
        let samples = configuration
            .materials
            .iter()
            .map(|material| (0..material.samples).map(|_| OnceLock::new()).collect())
            .collect();
        Ok(Session { configuration, folder, samples, store })
    }

    /// The configuration.
    pub fn configuration(&self) -> &Configuration {
        &self.configuration
    }

    /// The states of all points.
    pub fn store(&self) -> &Store {
        &self.store
    }

    /// Takes the states of another store in place of its own.
    ///
    /// # Errors
    /// As [`Store::load`].
    pub fn with_states(&self, path: &Path) -> Result<Session, Failure> {
        let samples = self.samples.iter().map(|samples| samples.to_vec()).collect();
        let (configuration, folder) = (self.configuration.clone(), self.folder.clone());
        Ok(Session { configuration, folder, samples, store: Store::load(path)? })
    }

    /// The material point of a name, whose sample is prepared if it is the first to ask for it.
    ///
    /// # Errors
    /// [`Failure::Argument`] if there is no such material, [`Failure::Sample`] if its sample cannot be made.
    pub fn point(&self, material: usize, name: u64) -> Result<Arc<MaterialPoint>, Failure> {
        let count = self.samples.len();
        let Some(samples) = material.checked_sub(1).and_then(|k| self.samples.get(k)) else {
            return Err(Failure::Argument(format!(
                "there is no material {material}: PROPS(1) must be 1 to {count}, as the configuration has them"
            )));
        };
        // There is at least one sample.
        let which = name % samples.len() as u64;
        let Some(sample) = samples.get(which as usize) else {
            return Err(Failure::Argument(format!("material {material} has no sample {which}")));
        };
        let made =
            sample.get_or_init(|| self.prepared(material, which).map(Arc::new).map_err(|f| f.to_string()));
        made.clone().map_err(Failure::Sample)
    }

    fn prepared(&self, material: usize, which: u64) -> Result<MaterialPoint, Failure> {
        let configuration = &self.configuration.materials[material - 1];
        let controls = configuration.controls();
        let Some(surrogate) = &configuration.surrogate else {
            return Ok(MaterialPoint::new(self.sample(configuration, which)?, controls)?);
        };
        let path = self.folder.join(surrogate);
        let loaded = SurrogateMethods::standard().load(&path);
        let loaded = loaded.map_err(|error| Failure::File { path, what: error.to_string() })?.into();
        let inputs = &configuration.inputs;
        Ok(match configuration.largest_trusted_deviation {
            None => MaterialPoint::from_surrogate(loaded, inputs, controls)?,
            Some(largest_deviation) => {
                let sample = self.sample(configuration, which)?;
                let keeps_stress = configuration.takeover_keeps_stress;
                let trust = Trust { largest_deviation, keeps_stress };
                MaterialPoint::hybrid(loaded, inputs, sample, trust, controls)?
            }
        })
    }

    /// The grains of a material.
    fn sample(&self, configuration: &MaterialConfiguration, which: u64) -> Result<Simulation, Failure> {
        if let Some(sample) = &configuration.sample {
            let folder = self.folder.join(sample);
            let state = Laboratory::here().last_state(&folder);
            return state.map_err(|error| Failure::File { path: folder, what: error.to_string() });
        }
        let path = self.folder.join(configuration.case.as_deref().unwrap_or(Path::new("")));
        let mut case = Case::read(&path)
            .map_err(|error| Failure::File { path: path.clone(), what: error.to_string() })?;
        case.preparation.seed = case.preparation.seed.wrapping_add(which);
        Ok(MaterialPoint::sample_of_case(&case)?)
    }

    /// Answers a question.
    ///
    /// # Errors
    /// [`Failure`]; the states of the point are then as they were.
    pub fn answer(&self, question: &PointQuestion, wants_stiffness: bool) -> Result<PointAnswer, Failure> {
        let point = self.point(question.material, question.name)?;
        let configuration = &self.configuration.materials[question.material - 1];
        let mut ticket = question.ticket;
        if ticket == 0 {
            let start = point.start();
            ticket = start.identity().ticket();
            if self.store.put_if_absent(question.name, &start) != ticket {
                // The host has begun anew.
                self.store.put(question.name, start);
            }
        }
        let without_stress = question.stress.iter().flatten().all(|stress| *stress == 0.0);
        let takes_sample = configuration.initial_stress == InitialStress::Sample;
        let is_own = question.ticket == 0 && without_stress && takes_sample;
        let mut stress = question.stress;
        if question.is_plane && !is_own {
            let own = self.store.state(question.name, ticket, &point)?.stress();
            for [r, c] in [[1, 2], [2, 1], [2, 0], [0, 2]] {
                stress[r][c] = own[r][c];
            }
        }
        let imposed = if is_own { None } else { Some(&stress) };
        let answer = self.store.advance(question.name, ticket, &point, imposed, &question.increment)?;
        let stiffness = match wants_stiffness {
            false => None,
            true => {
                let at_the_end = matches!(configuration.tangent, TangentKind::Probes | TangentKind::Secant);
                let state = match at_the_end {
                    true => answer.state.clone(),
                    false => self.store.state(question.name, ticket, &point)?,
                };
                Some(stiffness(&point, &state, configuration.tangent())?)
            }
        };
        Ok(PointAnswer { ticket: answer.ticket, state: answer.state, stiffness })
    }
}

/// The stiffness of a state; of one that carries no load a small share of that of the sample, so that a host can go on.
fn stiffness(point: &MaterialPoint, state: &State, tangent: Tangent) -> Result<[[f64; 6]; 6], Failure> {
    // The secant of the first state is its affine stiffness, and the probed one of a surrogate.
    let floor = || Ok(point.tangent(&point.start(), Tangent::Secant)?.0.map(|row| row.map(|x| UNLOADED * x)));
    if state.mean_stress() <= point.least_mean_stress() {
        return floor();
    }
    match point.tangent(state, tangent) {
        Ok(found) => Ok(found.0),
        Err(PointError::Stiffness(granum_run::stiffness::StiffnessError::Unloaded(_))) => floor(),
        Err(error) => Err(error.into()),
    }
}
