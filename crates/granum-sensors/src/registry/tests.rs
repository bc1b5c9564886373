use granum_core::{Part, Parts};

use super::*;
use crate::histogram::Histogram;
use crate::{Recorder, SensorParameter, clumps, lattice};

#[test]
fn every_sensor_gives_as_many_finite_values_as_columns_and_names_are_unique() {
    let assemblies = [
        Assembly::default(),
        lattice::face_centred_cubic(3, 1e-4, 1e-4, 1e-4),
        lattice::random_contacts(60, 5),
        clumps::few(),
    ];
    let mut so_far = Sensors { known: Vec::new(), clumps: false, bonds: false, agglomerates: false };
    for known in &STANDARD.known {
        let Known { sensor, description, .. } = &**known;
        assert_eq!(so_far.check(sensor.as_ref()), Ok(()));
        so_far.known.push(known.clone());
        assert!(!description.help.is_empty());
        let mut memory = Memory::new();
        for assembly in &assemblies {
            let mut row = Vec::new();
            let bins = sensor.histograms(&Recording::default());
            let mut counts: Vec<Histogram> = bins.iter().map(Bins::empty).collect();
            sensor.measure(&Observation::new(assembly), &mut memory, &mut Values::new(&mut row, &mut counts));
            assert_eq!(row.len(), description.columns.len(), "{}", description.name);
            assert!(row.iter().chain(&memory).all(|x| x.is_finite()), "{}: {row:?}", description.name);
            assert!(
                description.remembers || memory.is_empty(),
                "{} must say that it remembers",
                description.name
            );
        }
        for column in &description.columns {
            assert!(!column.description.is_empty() && !column.unit.is_empty());
        }
    }
}

#[test]
fn grains_without_contacts_and_one_single_contact_are_measured() {
    let mut assembly = lattice::simple_cubic(3, 1e-4, 1e-4, 1e-4);
    let one = assembly.contacts[0];
    assembly.contacts.clear();
    assert!(measure_row(&assembly).iter().all(|value| value.is_finite()));
    assembly.contacts.push(one);
    assert!(measure_row(&assembly).iter().all(|value| value.is_finite()));
    assembly.contacts[0].normal_force = -1e-6;
    assert!(measure_row(&assembly).iter().all(|value| value.is_finite()));
}

/// What a sensor declares is what it needs: with only those parts known, its values are those of the whole assembly.
#[test]
fn a_sensor_needs_what_it_says_and_nothing_else() {
    let sensors = STANDARD.for_clumps(true);
    for whole in [lattice::random_contacts(80, 3), clumps::few()] {
        needs_what_it_says(&sensors, whole);
    }
}

fn needs_what_it_says(sensors: &Sensors, mut whole: Assembly) {
    whole.strain = [[0.1, 0.02, 0.0], [0.01, -0.03, 0.0], [0.0, 0.0, -0.05]];
    whole.arc_length = 0.2;
    whole.time = 3.0;
    whole.velocity_gradient = [[-1.0, 0.0, 0.0], [0.0, 0.5, 0.0], [0.0, 0.0, 0.5]];
    whole.target_mean_stress = Some(1.0);
    whole.energy.boundary_work = 1.0;
    for (k, grain) in whole.bodies.iter_mut().enumerate() {
        grain.force = [1.0, 0.0, k as f64];
        grain.spin = [0.0, 0.3, 0.0];
    }
    for contact in &mut whole.contacts {
        contact.approach = 1e-3;
        contact.normal_energy = 2.0;
        contact.tangential_energy = 1.0;
        contact.rolling_energy = 0.5;
    }
    let all = sensors.measure(&whole, Parts::all());
    for known in &sensors.known {
        let mut wanted: Vec<Part> = known.description.needs.clone();
        wanted.extend(known.description.columns.iter().flat_map(|column| column.needs));
        let parts = Parts::new(&wanted);
        let part = sensors.measure(&with_only(&whole, parts), parts);
        for column in &known.description.columns {
            assert_eq!(part.value(column.name), all.value(column.name), "{}", column.name);
        }
    }
}

/// The assembly with only some of its parts.
fn with_only(whole: &Assembly, parts: Parts) -> Assembly {
    let mut a = whole.clone();
    let unless = |part: Part, clear: &mut dyn FnMut()| {
        if !parts.has(part) {
            clear();
        }
    };
    if !parts.has(Part::Contacts) {
        a.contacts.clear();
    }
    unless(Part::Cell, &mut || a.cell = [[0.0; 3]; 3]);
    unless(Part::Strain, &mut || (a.strain, a.arc_length) = ([[0.0; 3]; 3], 0.0));
    unless(Part::StrainRate, &mut || a.velocity_gradient = [[0.0; 3]; 3]);
    unless(Part::Time, &mut || a.time = 0.0);
    unless(Part::TargetMeanStress, &mut || a.target_mean_stress = None);
    unless(Part::EnergyBalance, &mut || a.energy = Default::default());
    for g in &mut a.bodies {
        unless(Part::Positions, &mut || g.position = [0.0; 3]);
        unless(Part::Radii, &mut || g.equivalent_radius = 0.0);
        // Of a grain of several pieces mass and moments of inertia are known together, or neither.
        if g.rigid.is_none() {
            unless(Part::Masses, &mut || g.mass = 0.0);
        }
        unless(Part::Velocities, &mut || g.velocity = [0.0; 3]);
        unless(Part::Spins, &mut || g.spin = [0.0; 3]);
        unless(Part::ResultantForces, &mut || (g.force, g.torque) = ([0.0; 3], [0.0; 3]));
    }
    for piece in &mut a.pieces {
        unless(Part::Positions, &mut || piece.position = [0.0; 3]);
        unless(Part::Radii, &mut || piece.radius = 0.0);
    }
    for c in &mut a.contacts {
        unless(Part::Overlaps, &mut || c.approach = 0.0);
        unless(Part::NormalForces, &mut || c.normal_force = 0.0);
        unless(Part::TangentialForces, &mut || c.tangential_force = [0.0; 3]);
        unless(Part::Sliding, &mut || c.sliding = false);
        unless(Part::ContactEnergies, &mut || {
            (c.normal_energy, c.tangential_energy, c.rolling_energy) = (0.0, 0.0, 0.0)
        });
    }
    a
}

#[test]
fn what_the_data_lack_is_named() {
    let packing = Parts::new(&[Part::Cell, Part::Positions, Part::Radii, Part::Contacts, Part::Overlaps]);
    let measured = STANDARD.measure(&lattice::simple_cubic(3, 1e-4, 1e-4, 0.0), packing);
    assert_eq!(measured.value("coordination_number"), Some(6.0));
    assert_eq!(measured.value("mean_stress"), None);
    let told: Vec<String> = measured.left_out.iter().map(LeftOut::to_string).collect();
    let has = |text: &str| assert!(told.iter().any(|line| line == text), "{text} is not in {told:#?}");
    has("stress: the data have no normal forces, no tangential forces");
    has("coordination (compressive_coordination_number): the data have no normal forces");
    has("nonaffine_displacement: it compares two observations of a test, and there is only one");
}

struct Bad(&'static str, &'static str, usize);
impl Sensor for Bad {
    fn description(&self) -> SensorDescription {
        SensorDescription::new(self.0, "bad").columns([SensorColumn::new(self.1, "1", "bad")])
    }
    fn measure(&self, _: &Observation, _: &mut Memory, values: &mut Values) {
        values.extend(std::iter::repeat_n(0.0, self.2));
    }
}

#[test]
fn sensors_that_would_break_a_series_are_refused() {
    let message =
        |bad: Bad| Sensors::standard().with(bad).err().map(|error| error.to_string()).unwrap_or_default();
    assert!(
        message(Bad("stress", "own", 1))
            .contains("sensor \"stress\" cannot be registered: there is already another")
    );
    assert!(message(Bad("own", "time", 1)).contains("its column \"time\""));
    assert!(message(Bad("own", "observations", 1)).contains("its column \"observations\""));
    assert!(message(Bad("a/b", "own", 1)).contains("not a word"));
    assert!(message(Bad("own", "own", 2)).contains("has 1 columns but measures 2 values"));
    assert_eq!(message(Bad("own", "own", 1)), "");
    let error = STANDARD.named("fabrik").unwrap_err().to_string();
    assert_eq!(error, "there is no sensor \"fabrik\"; did you mean fabric?");
}

#[test]
fn a_test_records_the_usual_sensors_and_those_that_are_named() {
    let named = |names: &[&str]| {
        Recording::default()
            .with(|recording| recording.sensors = names.iter().map(|name| name.to_string()).collect())
    };
    let usual = STANDARD.of_test(&named(&[]), RecordedColumns::FirstPublished).unwrap();
    assert_eq!((usual[0], usual.last()), ("strain", Some(&"rose")));
    let further = STANDARD
        .of_test(&named(&["second_order_work", "invariants", "stress"]), RecordedColumns::FirstPublished)
        .unwrap();
    assert_eq!(further[..usual.len()], usual[..]);
    assert_eq!(further[usual.len()..], ["second_order_work", "invariants"]);
    let staged = STANDARD.of_test(&named(&["invariants"]), RecordedColumns::All).unwrap();
    assert_eq!(staged.len(), usual.len() + 1, "in stages the invariants are recorded anyway");
    assert!(STANDARD.of_test(&named(&["nothing"]), RecordedColumns::FirstPublished).is_err());
}

/// A sensor with a parameter.
struct Counting(&'static str, SensorParameter);
impl Sensor for Counting {
    fn description(&self) -> SensorDescription {
        SensorDescription::new(self.0, "counts").parameters([self.1])
    }
    fn measure(&self, _: &Observation, _: &mut Memory, _: &mut Values) {}
}

#[test]
fn a_sensor_declares_its_parameters() {
    use granum_core::quantity::Dimension;
    let parameter = |key: &'static str, default: f64| {
        SensorParameter::new(key, Dimension::LENGTH, default, [0.0, 1.0], "Distance up to which it counts")
    };
    let keys_of = |sensors: &Sensors, sensor: &str| -> Vec<&'static str> {
        let all = sensors.declared_parameters().into_iter().filter(|known| known.sensors.contains(&sensor));
        all.map(|known| known.parameter.key).collect()
    };
    let keys = |sensor: &str| keys_of(&Sensors::standard(), sensor);
    assert_eq!(keys("state_parameter"), ["critical_void_ratio", "critical_slope", "critical_exponent"]);
    // Two sensors share these.
    assert_eq!(
        (keys("force_distribution"), keys("overlap_distribution").len()),
        (vec!["bin_width", "largest_force"], 2)
    );
    let error = |sensor: Counting| Sensors::standard().with(sensor).map(drop).unwrap_err().to_string();
    assert!(error(Counting("counting", parameter("states", 0.1))).contains("its parameter \"states\""));
    assert!(error(Counting("counting", parameter("bin_width", 0.1))).contains("its parameter \"bin_width\""));
    assert!(error(Counting("counting", parameter("a b", 0.1))).contains("not a word"));
    let sensors = Sensors::standard().with(Counting("counting", parameter("counting_reach", 0.1))).unwrap();
    assert_eq!((keys_of(&sensors, "counting"), keys("counting")), (vec!["counting_reach"], vec![]));
    let declared = sensors.declared_parameters();
    assert!(declared.iter().all(|known| known.of_granum != (known.parameter.key == "counting_reach")));
    let other = sensors.with(Counting("other", parameter("counting_reach", 0.2))).map(drop).unwrap_err();
    assert!(other.to_string().contains("in use"));
}

/// The columns of a record of grains of several pieces, and those of spheres, whatever the program was told.
#[test]
fn sensors_of_clumps_are_recorded_and_measured_where_there_are_clumps() {
    let recording = Recording::default().with(|recording| recording.states = 2);
    let record = |sensors: &Sensors, assembly: &Assembly| {
        let mut recorder = Recorder::new(sensors, &recording, 0.1).unwrap();
        recorder.observe(assembly);
        (recorder.record(), serde_json::to_string(&recorder).unwrap())
    };
    let (spheres, few) = (lattice::simple_cubic(3, 1e-4, 1e-4, 1e-4), clumps::few());
    let (before, after) = (&STANDARD.for_clumps(false), &STANDARD.for_clumps(true));
    assert_eq!(record(&STANDARD, &spheres), record(before, &spheres), "it is the default");
    let ((plain, saved), (more, _)) = (record(before, &few), record(after, &few));
    assert!(!saved.contains("pair"));
    let new: Vec<&str> = more.series.names().filter(|name| plain.series.values(name).is_none()).collect();
    let ends = ["pair_forces_below", "pair_forces_above"];
    let own = after.known.iter().filter(|known| known.recorded == Recorded::OfClumps);
    let own: Vec<&str> = own.flat_map(|known| &known.description.columns).map(|column| column.name).collect();
    assert_eq!(new, [own.clone(), ends.to_vec()].concat());
    for column in plain.series.columns() {
        assert_eq!(more.series.values(&column.name), Some(&column.values[..]), "{}", column.name);
    }
    assert_eq!(more.series.values("pairs"), Some(&[3.0][..]));
    assert_eq!((more.histograms("pair_forces")[0].total(), plain.histograms.len()), (3, 1));
    // What is measured follows from the grains themselves.
    let of = |assembly: &Assembly| STANDARD.measure(assembly, Parts::all());
    assert!(own.iter().all(|name| of(&few).value(name).is_some() && of(&spheres).value(name).is_none()));
    assert!(of(&spheres).left_out.iter().all(|left_out| left_out.sensor != "spin"));
    let series = |one: &Assembly| STANDARD.measure_series(&[(one, Parts::all())]).values("spin").is_some();
    assert!(series(&few) && !series(&spheres));
    // A case can name them for spheres, too.
    let named = recording.with(|recording| recording.sensors = vec!["spin".into(), "stress".into()]);
    let names = |sensors: &Sensors| sensors.of_test(&named, RecordedColumns::All).unwrap();
    assert_eq!(names(before).last(), Some(&"spin"));
    assert_eq!(names(after).iter().filter(|name| **name == "spin").count(), 1);
    assert!(STANDARD.recorded("spin").unwrap().starts_with("in every test of grains of several pieces"));
}

/// Both void ratios are recorded of agglomerates, and neither of grains without bonds or with a bond from each to the next.
#[test]
fn voids_inside_of_agglomerates_are_recorded_where_there_are_agglomerates() {
    let names = |sensors: &Sensors| sensors.of_test(&Recording::default(), RecordedColumns::All).unwrap();
    let both = ["void_ratio", "agglomerate_voids"];
    let bonded = STANDARD.for_bonds(true);
    assert!(both.iter().all(|name| names(&bonded.for_agglomerates(true)).contains(name)));
    assert!(both.iter().all(|name| !names(&bonded).contains(name) && !names(&STANDARD).contains(name)));
    assert!(names(&bonded).contains(&"rupture_rate"));
    // What is measured follows from the grains themselves.
    let mut grains = lattice::simple_cubic(2, 1e-4, 1e-4, 1e-4);
    let inside = |grains: &Assembly| {
        STANDARD.measure(grains, Parts::all()).value("intergranular_void_ratio").is_some()
    };
    assert!(!inside(&grains));
    let bond = granum_core::assembly::Bond { j: 1, branch: [2e-4, 0.0, 0.0], ..Default::default() };
    grains.bonds = vec![bond];
    assert!(inside(&grains));
    let bond = |i: usize| granum_core::assembly::Bond { i, j: i + 1, ..bond };
    grains.bonds = (0..7).map(bond).collect();
    assert!(!inside(&grains));
}
