//! The laws, paths and sensors that the words of a case file stand for.

use std::sync::{Arc, LazyLock};

use granum_core::RegistrationError;
use granum_dem::bond::BondKind;
use granum_dem::contact::choice::registry::{Law, Laws};
use granum_dem::loading::preset::{Paths, Preset};
use granum_sensors::{Sensor, Sensors};

/// The laws, paths and sensors that the words of a case file stand for: those of granum, and those that a program adds. Cases are
/// read with it ([`Reading::with_vocabulary`](super::Reading::with_vocabulary)), and remember it.
///
/// ```
/// use granum_io::case::Vocabulary;
///
/// let vocabulary = Vocabulary::standard();
/// assert!(vocabulary.paths().named("oedometer").is_some() && vocabulary.laws().normal_named("hertz").is_some());
/// ```
#[derive(Clone)]
pub struct Vocabulary(Arc<Words>);

#[derive(Clone)]
struct Words {
    laws: Laws,
    paths: Paths,
    sensors: Sensors,
}

/// Made once; nothing is added to it.
static STANDARD: LazyLock<Vocabulary> =
    LazyLock::new(|| Vocabulary::new(Laws::standard(), Paths::standard(), Sensors::standard()));

impl Default for Vocabulary {
    fn default() -> Vocabulary {
        Vocabulary::standard()
    }
}

impl std::fmt::Debug for Vocabulary {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(if self.is_standard() { "the words of granum" } else { "the words of a program" })
    }
}

impl Vocabulary {
    /// Of these laws, paths and sensors.
    pub fn new(laws: Laws, paths: Paths, sensors: Sensors) -> Vocabulary {
        Vocabulary(Arc::new(Words { laws, paths, sensors }))
    }

    /// The laws, paths and sensors of granum.
    pub fn standard() -> Vocabulary {
        STANDARD.clone()
    }

    /// True if nothing was added to that of granum.
    pub fn is_standard(&self) -> bool {
        Arc::ptr_eq(&self.0, &STANDARD.0)
    }

    /// The contact laws.
    pub fn laws(&self) -> &Laws {
        &self.0.laws
    }

    /// The named paths.
    pub fn paths(&self) -> &Paths {
        &self.0.paths
    }

    /// The sensors, whose parameters are keys of `[recording]`.
    pub fn sensors(&self) -> &Sensors {
        &self.0.sensors
    }

    /// Adds a contact law, with a sensor for each of its energy channels.
    ///
    /// # Errors
    /// As [`Laws::with`]; also if a sensor has a column with the key of a channel.
    pub fn with_law(&self, law: impl Into<Law>) -> Result<Vocabulary, RegistrationError> {
        let law = law.into();
        let laws = self.laws().clone().with(law)?;
        let mut sensors = self.sensors().clone();
        for channel in law.channels() {
            let (what, name, key) = (law.what(), law.description().name, channel.key);
            let taken = |_| RegistrationError::key_taken(what, name, "energy channel", key);
            sensors = sensors.with_channels(&[*channel]).map_err(taken)?;
        }
        Ok(self.changed(|words| (words.laws, words.sensors) = (laws, sensors)))
    }

    /// Adds a law of bonds, which a table `[[bond]]` can then name.
    ///
    /// # Errors
    /// As [`Laws::with_bond`].
    pub fn with_bond_law(&self, law: BondKind) -> Result<Vocabulary, RegistrationError> {
        let laws = self.laws().clone().with_bond(law)?;
        Ok(self.changed(|words| words.laws = laws))
    }

    /// Adds a named path.
    ///
    /// # Errors
    /// As [`Paths::with`].
    pub fn with_path(&self, path: &'static Preset) -> Result<Vocabulary, RegistrationError> {
        let paths = self.paths().clone().with(path)?;
        Ok(self.changed(|words| words.paths = paths))
    }

    /// Adds a sensor.
    ///
    /// # Errors
    /// As [`Sensors::with`].
    pub fn with_sensor(&self, sensor: impl Sensor + 'static) -> Result<Vocabulary, RegistrationError> {
        let sensors = self.sensors().clone().with(sensor)?;
        Ok(self.changed(|words| words.sensors = sensors))
    }

    fn changed(&self, change: impl FnOnce(&mut Words)) -> Vocabulary {
        let mut words = Words::clone(&self.0);
        change(&mut words);
        Vocabulary(Arc::new(words))
    }
}

#[cfg(test)]
mod tests {
    use granum_dem::config::{NormalKind, RollingKind};
    use granum_dem::contact::normal::Hertz;
    use granum_dem::contact::normal::hertz::HertzConstants;
    use granum_dem::contact::{
        EnergyChannel, LawDescription, LawParameter, Normal, NormalLaw, PairProperties, Unit,
    };
    use granum_dem::loading::preset::{INERTIAL_NUMBER, number};
    use granum_dem::loading::{Control, Drive, Measure, Stage, Until};

    use super::super::{Case, Reading};
    use super::*;

    /// Hertz's law with another modulus.
    #[derive(Clone, Copy)]
    struct Stiffened;
    impl NormalLaw for Stiffened {
        const DESCRIPTION: LawDescription = LawDescription::new(
            "stiffened",
            "stiffened",
            "Hertz's law with another modulus",
            &[LawParameter::new("stiffening", Unit::NUMBER, 1.0, [0.5, 2.0], "Factor on the modulus.")],
        );
        type Constants<R: granum_simd::Real> = HertzConstants<R>;
        const CHANNELS: &'static [EnergyChannel] =
            &[EnergyChannel::dissipated("stiffening_loss", "stiffening", "energy lost by stiffening")];
        fn prepare(pair: &PairProperties, parameters: &[f64]) -> HertzConstants<f64> {
            let mut pair = *pair;
            pair.effective_modulus *= parameters[0];
            Hertz::prepare(&pair, &[])
        }
        fn evaluate<R: granum_simd::Real>(c: &HertzConstants<R>, overlap: R, touched: R::Mask) -> Normal<R> {
            Hertz::evaluate(c, overlap, touched)
        }
        fn loaded(pair: &PairProperties, _: &[f64], load: f64) -> Normal<f64> {
            Hertz::loaded(pair, &[], load)
        }
        fn energy<R: granum_simd::Real>(c: &HertzConstants<R>, overlap: R) -> R {
            Hertz::energy(c, overlap)
        }
    }

    const SHORTENING: Preset = Preset::new(
        "shortening",
        "Axis x is compressed.",
        &[number("shortening", "Strain along x at the end.", 0.1, [1e-6, 1.0]), INERTIAL_NUMBER],
        |values| {
            let control = Control::new(values.speed(), [Drive::Rate(1.0); 6].map(|_| Drive::Fixed));
            let end = Until::Reaches { measure: Measure::Strain(0), value: values.number("shortening") };
            vec![Stage::new("shortening", control, vec![end])]
        },
    );

    const TEXT: &str = "[contact]\nnormal = 'stiffened'\ntangential = 'no-slip'\nstiffening = 1.5\n\
                        [grains.material]\ninterface_energy = 0\n[[stage]]\npath = 'shortening'\nshortening = 0.2\n";

    #[test]
    fn a_case_names_the_laws_and_paths_with_which_it_was_read() {
        let vocabulary = Vocabulary::standard().with_law(NormalKind::new(&Stiffened)).unwrap();
        let vocabulary = vocabulary.with_path(&SHORTENING).unwrap();
        let reading = || Reading::default().with_vocabulary(&vocabulary);
        let case = Case::parse_as(TEXT, "case", reading()).unwrap();
        assert_eq!(case.contact.parameters.given("stiffening"), Some(1.5));
        assert_eq!(case.test_stages()[0].name, "shortening");
        // What is written is read back with the same vocabulary, as the same case.
        let back = Case::parse_as(&case.resolved_toml(), "case", reading()).unwrap();
        assert_eq!((&back, back.digest()), (&case, case.digest()));
        assert!(case.resolved_toml().contains("stiffening = 1.5"));
        assert_eq!(case.values()["contact.stiffening"], "1.5");
        let other = Case::parse_as(&TEXT.replace("1.5", "1.4"), "case", reading()).unwrap();
        assert_ne!(other.digest(), case.digest());
        let mut set = case.clone();
        set.set("contact.stiffening", "1.4").unwrap();
        set.set("stage.1.shortening", "0.2").unwrap();
        assert_eq!(set, other);
        assert!(case.readable_toml(None).is_ok() && case.check().is_ok());
        assert!(Case::template_with(&vocabulary).contains("stiffening = 1"));
        let schema = Case::schema_with(&vocabulary);
        assert!(schema["properties"]["contact"]["properties"]["stiffening"]["description"].is_string());
        // So is the case of a run folder, which is read as a record.
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("case.toml"), case.resolved_toml()).unwrap();
        std::fs::write(folder.path().join("run.json"), "{}").unwrap();
        assert_eq!(Case::read_as(folder.path().join("case.toml"), reading()).unwrap(), case);
        // A mistake is met with what the vocabulary has.
        let typo =
            Case::parse_as(&TEXT.replace("\nstiffening", "\nstiffenin"), "case", reading()).unwrap_err();
        assert!(typo.to_string().contains("did you mean stiffening?"), "{typo}");
    }

    /// One vocabulary does not know what was added to another, and nothing is added to that of granum.
    #[test]
    fn what_is_added_to_a_vocabulary_is_in_no_other() {
        let vocabulary = Vocabulary::standard().with_law(NormalKind::new(&Stiffened)).unwrap();
        let message = Case::parse(TEXT, "case").unwrap_err().to_string();
        assert!(
            message.contains("contact.normal = 'stiffened' is not known; it must be \"hertz\""),
            "{message}"
        );
        assert!(message.contains("unknown key contact.stiffening"), "{message}");
        let reading = Reading::default().with_vocabulary(&vocabulary);
        let message = Case::parse_as(TEXT, "case", reading).unwrap_err().to_string();
        assert!(message.contains("stage.1.path = 'shortening' is not a path"), "{message}");
        let standard = Vocabulary::standard();
        assert!(standard.laws().normal_named("stiffened").is_none());
        // An energy channel of a law is a column that every test records.
        let recorded = |vocabulary: &Vocabulary| {
            vocabulary.sensors().columns().filter(|column| column.name == "stiffening_loss").count()
        };
        assert_eq!([recorded(&vocabulary), recorded(&standard)], [1, 0]);
        assert!(standard.with_law(RollingKind::NONE).is_ok(), "once more is no harm");
    }
}
