//! The registry of sensors. A new sensor needs a file and a line in [`Sensors::standard`]; a program that uses this library adds
//! its own sensors with [`Sensors::with`].

mod measuring;

use std::sync::{Arc, LazyLock};

use granum_core::assembly::Vector;
use granum_core::names::suggestion;
use granum_core::{Assembly, RegistrationError};
use granum_dem::bond::BOND_CHANNELS;
use granum_dem::config::{RecordedColumns, Recording};
use granum_dem::contact::EnergyChannel;
use granum_dem::contact::choice::registry::Laws;

use crate::declared::{DeclaredParameter, OWN_KEYS, declared_parameters};
use crate::energy_channel::ChannelEnergy;
use crate::histogram::Bins;
use crate::neighbours::{Neighbours, TOO_MUCH_WORK, most_work};
use crate::{Memory, Observation, Sensor, SensorColumn, SensorDescription, Values};
use crate::{
    agglomerate_voids, anisotropies, attraction, bond_fabric, bonds, chain_buckling, contact_motion,
    contacts_per_pair, coordination, coordination_by_size, d2min, dilatancy, directions, energy, fabric,
    force_chains, force_distribution, fragments, friction_angle, granular_temperature, inertial_number,
    invariants, liquid, local_solid_fraction, networks, nonaffine_displacement, orientation, overlap,
    overlap_distribution, pair_fabric, pair_forces, pair_sliding, radial_distribution, rolling, rose,
    rupture_energies, rupture_rate, second_order_work, servo, sliding, solid_fraction, spin, state_parameter,
    strain, stress, stress_asymmetry, unbalanced_force, void_ratio,
};

pub use self::measuring::{LeftOut, MeasuredSeries, Measurement};

/// When a sensor is recorded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Recorded {
    /// In every test.
    Always,
    /// In every test with all columns ([`RecordedColumns::All`]), and where a case names it: it is newer than the section `[shear]`.
    SinceStages,
    /// In every test of grains of several pieces ([`Sensors::for_clumps`]), and where a case names it.
    OfClumps,
    /// In every test with bonds ([`Sensors::for_bonds`]), and where a case names it.
    OfBonds,
    /// In every test of agglomerates ([`Sensors::for_agglomerates`]), and where a case names it.
    OfAgglomerates,
    /// The same; it is measured of all grains.
    NamedOrOfAgglomerates,
    /// Where a case names it in `recording.sensors`.
    WhereNamed,
}

/// Of which kinds measured grains are.
#[derive(Clone, Copy)]
pub(crate) struct Kinds {
    /// True if every grain is a sphere.
    pub(crate) all_spheres: bool,
    /// True if there are or were bonds.
    pub(crate) bonded: bool,
    /// True if bonds made agglomerates of the grains.
    pub(crate) agglomerates: bool,
}

impl Kinds {
    /// The kinds of all these assemblies.
    pub(crate) fn new<'a>(assemblies: impl Iterator<Item = &'a Assembly> + Clone) -> Kinds {
        let bonded = assemblies.clone().any(Assembly::is_bonded);
        let agglomerates = bonded && assemblies.clone().any(fragments::are_agglomerates);
        Kinds { all_spheres: { assemblies }.all(Assembly::all_spheres), bonded, agglomerates }
    }
}

/// Reasons why a sensor cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SensorError {
    /// There is none of that name.
    #[error("there is no sensor {name:?}; {suggestion}")]
    Unknown {
        /// The name.
        name: String,
        /// The nearest name, or all existing names.
        suggestion: String,
    },
    /// The recording names it, but lacks a parameter that it needs.
    #[error("the sensor {sensor:?}: {what}")]
    Lacks {
        /// The sensor.
        sensor: &'static str,
        /// The parameter that it needs, and how to set it.
        what: String,
    },
}

/// A sensor with its description.
pub(crate) struct Known {
    pub(crate) sensor: Box<dyn Sensor>,
    pub(crate) description: SensorDescription,
    recorded: Recorded,
}

impl Known {
    /// The reason why it cannot be used with the parameters of a recording.
    fn lacks(&self, recording: &Recording) -> Option<String> {
        let needed = self.description.parameters.iter().find_map(|parameter| parameter.lack(recording));
        needed.or_else(|| self.sensor.lacks(recording))
    }

    /// True if it measures such grains without being asked: some sensors say nothing of grains that all have one piece, of grains without
    /// bonds, or of bonded grains that are no agglomerates.
    pub(crate) fn applies(&self, to: Kinds) -> bool {
        match self.recorded {
            Recorded::OfClumps => !to.all_spheres,
            Recorded::OfBonds => to.bonded,
            Recorded::OfAgglomerates => to.agglomerates,
            _ => true,
        }
    }

    /// The reason if the sensor would have to look at too many neighbours.
    pub(crate) fn costs_too_much(&self, assembly: &Assembly) -> Option<&'static str> {
        let (grains, reach) = (&assembly.bodies, self.sensor.reach(assembly));
        if reach <= 0.0 {
            return None;
        }
        let positions: Vec<Vector> = grains.iter().map(|grain| grain.position).collect();
        let neighbours = Neighbours::new(&assembly.cell, &positions, reach)?;
        let most = most_work(grains.len());
        (neighbours.work(0..grains.len(), most) > most).then_some(TOO_MUCH_WORK)
    }
}

/// The sensors that a program knows, in the order of their columns.
///
/// ```
/// use granum_core::{Assembly, Part, Parts};
/// use granum_sensors::Sensors;
///
/// // The sensors that can be evaluated on spheres with known positions, and the reasons why the others cannot.
/// let parts = Parts::new(&[Part::Cell, Part::Positions, Part::Radii]);
/// let measured = Sensors::standard().measure(&Assembly::default(), parts);
/// assert_eq!(measured.value("solid_fraction"), Some(0.0));
/// let fabric = measured.left_out.iter().find(|left_out| left_out.sensor == "fabric").unwrap();
/// assert_eq!(fabric.to_string(), "fabric: the data have no contacts");
/// ```
#[derive(Clone)]
pub struct Sensors {
    known: Vec<Arc<Known>>,
    /// True if a test with them has grains of several pieces.
    clumps: bool,
    /// True if a test with them has bonds.
    bonds: bool,
    /// True if a test with them has agglomerates.
    agglomerates: bool,
}

/// [`Sensors::standard`], made once.
static STANDARD: LazyLock<Sensors> = LazyLock::new(|| {
    use Recorded::{
        Always, NamedOrOfAgglomerates, OfAgglomerates, OfBonds, OfClumps, SinceStages, WhereNamed,
    };
    let mut sensors = Sensors { known: Vec::new(), clumps: false, bonds: false, agglomerates: false };
    sensors.add(Always, strain::Strain);
    sensors.add(Always, stress::StressSensor);
    sensors.add(Always, servo::Servo);
    sensors.add(Always, fabric::Fabric);
    sensors.add(Always, force_distribution::ForceDistribution);
    sensors.add(Always, coordination::CoordinationNumbers);
    sensors.add(Always, solid_fraction::SolidFraction);
    sensors.add(Always, sliding::Sliding);
    sensors.add(Always, inertial_number::InertialNumber);
    sensors.add(Always, unbalanced_force::UnbalancedForce);
    sensors.add(Always, overlap::Overlap);
    sensors.add(Always, energy::Energy);
    sensors.add(Always, rolling::Rolling);
    sensors.add(Always, attraction::Attraction);
    sensors.add(Always, liquid::LiquidVolumes);
    Laws::standard().channels().into_iter().for_each(|channel| sensors.add(Always, ChannelEnergy(*channel)));
    sensors.add(Always, rose::RoseOfContacts);
    sensors.add(SinceStages, invariants::Invariants);
    sensors.add(WhereNamed, overlap_distribution::OverlapDistribution);
    sensors.add(WhereNamed, nonaffine_displacement::NonaffineDisplacement);
    sensors.add(WhereNamed, second_order_work::SecondOrderWork);
    sensors.add(NamedOrOfAgglomerates, void_ratio::VoidRatio);
    sensors.add(WhereNamed, friction_angle::FrictionAngle);
    sensors.add(WhereNamed, dilatancy::Dilatancy);
    sensors.add(WhereNamed, state_parameter::StateParameter);
    sensors.add(WhereNamed, networks::Networks);
    sensors.add(WhereNamed, anisotropies::Anisotropies);
    sensors.add(WhereNamed, directions::Directions);
    sensors.add(WhereNamed, contact_motion::ContactMotion);
    sensors.add(WhereNamed, granular_temperature::GranularTemperature);
    sensors.add(WhereNamed, coordination_by_size::CoordinationBySize);
    sensors.add(WhereNamed, radial_distribution::RadialDistribution);
    sensors.add(WhereNamed, d2min::D2Min);
    sensors.add(WhereNamed, force_chains::ForceChains);
    sensors.add(WhereNamed, chain_buckling::ChainBuckling);
    sensors.add(WhereNamed, local_solid_fraction::LocalSolidFraction);
    sensors.add(OfClumps, contacts_per_pair::ContactsPerPair);
    sensors.add(OfClumps, pair_forces::PairForces);
    sensors.add(OfClumps, pair_sliding::PairSliding);
    sensors.add(OfClumps, pair_fabric::PairFabric);
    sensors.add(OfClumps, orientation::Orientation);
    sensors.add(OfClumps, spin::Spin);
    sensors.add(OfClumps, stress_asymmetry::StressAsymmetry);
    sensors.add(OfBonds, bonds::Bonds);
    sensors.add(OfBonds, bond_fabric::BondFabric);
    sensors.add(OfBonds, fragments::Fragments);
    sensors.add(OfBonds, rupture_energies::RuptureEnergies);
    sensors.add(OfBonds, rupture_rate::RuptureRate);
    sensors.add(OfAgglomerates, agglomerate_voids::AgglomerateVoids);
    BOND_CHANNELS.into_iter().for_each(|channel| sensors.add(OfBonds, ChannelEnergy(channel)));
    sensors
});

impl Sensors {
    /// The sensors that come with granum.
    pub fn standard() -> Sensors {
        STANDARD.clone()
    }

    /// The same sensors for a test whose grains have several pieces, or have one each: only of the former are the pairs of grains, the
    /// directions of their axes and the like recorded, unless a case names them. Without a call they are those of grains of one piece.
    ///
    /// ```
    /// use granum_dem::config::{RecordedColumns, Recording};
    /// use granum_sensors::Sensors;
    ///
    /// let of = |clumps: bool| {
    ///     Sensors::standard().for_clumps(clumps).of_test(&Recording::default(), RecordedColumns::All)
    /// };
    /// assert!(of(true)?.contains(&"contacts_per_pair") && !of(false)?.contains(&"contacts_per_pair"));
    /// # Ok::<(), granum_sensors::SensorError>(())
    /// ```
    pub fn for_clumps(&self, clumps: bool) -> Sensors {
        Sensors { clumps, ..self.clone() }
    }

    /// The same sensors for a test with bonds, or without: only with bonds are these, the fragments and the like recorded, unless a case names
    /// them. Without a call they are those of grains without bonds.
    pub fn for_bonds(&self, bonds: bool) -> Sensors {
        Sensors { bonds, ..self.clone() }
    }

    /// The same sensors for a test of agglomerates, or not: only of agglomerates are the voids between and inside of them recorded, unless a
    /// case names them. Without a call they are not.
    pub fn for_agglomerates(&self, agglomerates: bool) -> Sensors {
        Sensors { agglomerates, ..self.clone() }
    }

    /// The same sensors and one more for each of these energy channels of a contact law, which every test records.
    ///
    /// # Errors
    /// [`RegistrationError::Key`] if the column of another sensor has the key of a channel.
    pub fn with_channels(mut self, channels: &[EnergyChannel]) -> Result<Sensors, RegistrationError> {
        for channel in channels {
            let sensor = ChannelEnergy(*channel);
            let description = sensor.description();
            // Laws can share a channel.
            if !self.known.iter().any(|known| known.description == description) {
                self.check(&sensor)?;
                self.add(Recorded::Always, sensor);
            }
        }
        Ok(self)
    }

    /// The same sensors and one more, which is recorded where a case names it in `recording.sensors`. Case files that
    /// are read with these sensors can give the parameters that it declares, as keys of `[recording]`.
    ///
    /// # Errors
    /// [`RegistrationError`] if a name is taken, or it measures another number of values than it has columns.
    pub fn with(mut self, sensor: impl Sensor + 'static) -> Result<Sensors, RegistrationError> {
        self.check(&sensor)?;
        self.add(Recorded::WhereNamed, sensor);
        Ok(self)
    }

    fn add(&mut self, recorded: Recorded, sensor: impl Sensor + 'static) {
        let description = sensor.description();
        self.known.push(Arc::new(Known { sensor: Box::new(sensor), description, recorded }));
    }

    /// Refuses a sensor whose names are taken, or which measures another number of values than it has columns.
    fn check(&self, sensor: &dyn Sensor) -> Result<(), RegistrationError> {
        let description = sensor.description();
        let (what, name) = ("sensor", description.name);
        let bins = sensor.histograms(&Recording::default());
        let names = self.descriptions().map(|known| known.name);
        RegistrationError::check_name(what, name, names)?;
        let declared = self.declared_parameters();
        for parameter in &description.parameters {
            let is_other = |known: &DeclaredParameter| {
                known.parameter.key == parameter.key && known.parameter != *parameter
            };
            let is_taken = OWN_KEYS.contains(&parameter.key) || declared.iter().any(is_other);
            RegistrationError::check_key(what, name, "parameter", parameter.key, is_taken)?;
        }
        let mut columns: Vec<&str> = self.columns().map(|column| column.name).collect();
        columns.extend(["stage", "state", "observations"]);
        for column in &description.columns {
            RegistrationError::check_key(what, name, "column", column.name, columns.contains(&column.name))?;
            columns.push(column.name);
        }
        let mut histograms: Vec<&str> =
            self.bins(&Recording::default()).iter().map(|bins| bins.name).collect();
        for bins in &bins {
            RegistrationError::check_key(
                what,
                name,
                "histogram",
                bins.name,
                histograms.contains(&bins.name),
            )?;
            RegistrationError::check_key(what, name, "quantity of a histogram", bins.quantity, false)?;
            histograms.push(bins.name);
        }
        let (mut row, mut counts) = (Vec::new(), bins.iter().map(Bins::empty).collect::<Vec<_>>());
        let nothing = Assembly::default();
        sensor.measure(
            &Observation::new(&nothing),
            &mut Memory::new(),
            &mut Values::new(&mut row, &mut counts),
        );
        let (columns, values) = (description.columns.len(), row.len());
        if values == columns {
            return Ok(());
        }
        let reason =
            format!("it has {columns} columns but measures {values} values; give one value for each column");
        Err(RegistrationError::Declaration { what, name: name.into(), reason })
    }

    /// Every parameter that these sensors declare, granum's first.
    pub fn declared_parameters(&self) -> Vec<DeclaredParameter> {
        let of_granum = |known: &Arc<Known>| STANDARD.known.iter().any(|own| Arc::ptr_eq(own, known));
        declared_parameters(
            self.known
                .iter()
                .map(|known| (&known.description, known.recorded == Recorded::Always, of_granum(known))),
        )
    }

    /// The descriptions of all sensors.
    pub fn descriptions(&self) -> impl Iterator<Item = &SensorDescription> {
        self.known.iter().map(|known| &known.description)
    }

    /// The description of the sensor of the given name.
    ///
    /// # Errors
    /// [`SensorError::Unknown`] with the nearest name.
    pub fn named(&self, name: &str) -> Result<&SensorDescription, SensorError> {
        Ok(&self.find(name)?.description)
    }

    /// When a sensor is recorded, as a phrase for display.
    pub fn recorded(&self, name: &str) -> Result<&'static str, SensorError> {
        Ok(match self.find(name)?.recorded {
            Recorded::Always => "in every test",
            Recorded::SinceStages => {
                "in every test but that of [shear], and there where recording.sensors names it"
            }
            Recorded::OfClumps => {
                "in every test of grains of several pieces, and elsewhere where recording.sensors names it"
            }
            Recorded::OfBonds => "in every test with bonds, and elsewhere where recording.sensors names it",
            Recorded::OfAgglomerates | Recorded::NamedOrOfAgglomerates => {
                "in every test of agglomerates ([[bond]] with places = \"inside\"), and elsewhere where recording.sensors names it"
            }
            Recorded::WhereNamed => "where recording.sensors names it",
        })
    }

    /// The columns of all sensors.
    pub fn columns(&self) -> impl Iterator<Item = &SensorColumn> {
        self.known.iter().flat_map(|known| &known.description.columns)
    }

    /// The bins of all histograms, for a recording.
    pub fn bins(&self, recording: &Recording) -> Vec<Bins> {
        self.known.iter().flat_map(|known| known.sensor.histograms(recording)).collect()
    }

    pub(crate) fn find(&self, name: &str) -> Result<&Arc<Known>, SensorError> {
        self.known.iter().find(|known| known.description.name == name).ok_or_else(|| SensorError::Unknown {
            name: name.to_string(),
            suggestion: suggestion(name, self.known.iter().map(|known| known.description.name)),
        })
    }

    /// The names of the sensors that a test records, in the order of their columns: those of every test, those that came with
    /// stages, those of grains of several pieces where it [has such](Sensors::for_clumps), then those that the recording names.
    ///
    /// # Errors
    /// [`SensorError::Unknown`] for a name that no sensor has.
    pub fn of_test(
        &self,
        recording: &Recording,
        columns: RecordedColumns,
    ) -> Result<Vec<&'static str>, SensorError> {
        let usual = |known: &&Arc<Known>| match known.recorded {
            Recorded::Always => true,
            Recorded::SinceStages => columns == RecordedColumns::All,
            Recorded::OfClumps => self.clumps,
            Recorded::OfBonds => self.bonds,
            Recorded::OfAgglomerates | Recorded::NamedOrOfAgglomerates => self.agglomerates,
            Recorded::WhereNamed => false,
        };
        let mut names: Vec<&'static str> =
            self.known.iter().filter(usual).map(|known| known.description.name).collect();
        for name in &recording.sensors {
            let known = self.find(name)?;
            let name = known.description.name;
            if let Some(what) = known.lacks(recording) {
                return Err(SensorError::Lacks { sensor: name, what });
            }
            if !names.contains(&name) {
                names.push(name);
            }
        }
        Ok(names)
    }
}

impl std::fmt::Debug for Sensors {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_list().entries(self.descriptions().map(|description| description.name)).finish()
    }
}

fn always() -> impl Iterator<Item = &'static Arc<Known>> {
    STANDARD.known.iter().filter(|known| known.recorded == Recorded::Always)
}

/// The columns of granum's sensors that every test records, in the order of [`measure_row`].
pub fn columns() -> impl Iterator<Item = &'static SensorColumn> {
    always().flat_map(|known| &known.description.columns)
}

/// Index of the column with a given name in [`measure_row`].
pub fn column_index(name: &str) -> Option<usize> {
    columns().position(|column| column.name == name)
}

/// Measures an assembly of which everything is known: one value for each column of [`columns`].
pub fn measure_row(assembly: &Assembly) -> Vec<f64> {
    let observation = Observation::new(assembly);
    let mut row = Vec::with_capacity(columns().count());
    for known in always() {
        known.sensor.measure(&observation, &mut Memory::new(), &mut Values::new(&mut row, &mut []));
    }
    row
}

#[cfg(test)]
mod tests;
