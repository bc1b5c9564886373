//! How a case file writes its test: as tables `[[stage]]`, or as the section `[shear]`, which is a short way of writing one stage.
//!
//! Everything that depends on which of the two it is stands in this file. The rest of granum asks for
//! [`Case::test_definition`](super::Case::test_definition).
//!
//! The section `[shear]` is older than stages, and results were published that were made with it. They stay the same, with their
//! digests: its stage is that of the paper ([`preset::antony2006`]), a sample of another mean stress is consolidated as it was
//! prepared, and the columns are those of the first version ([`RecordedColumns::FirstPublished`]).

use granum_dem::config::{RecordedColumns, Recording, Shear};
use granum_dem::loading::{density_scaling, preset};
use serde::{Deserialize, Serialize};

use super::case_stage::CaseStage;
use super::test_definition::TestDefinition;
use crate::error::{Error, Result};

/// The test of a case as its file writes it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum CaseTest {
    /// The section `[shear]`: one stage of axisymmetric compression at constant mean stress. The states that it records and its
    /// snapshots are those of the section `[recording]`.
    Shear(Shear),
    /// The tables `[[stage]]`, at least one.
    Stages(Vec<CaseStage>),
}

impl Default for CaseTest {
    /// The test of Antony, Zhou and Wang (2006).
    fn default() -> Self {
        CaseTest::Shear(Shear::default())
    }
}

impl CaseTest {
    /// Checks that there is something to do.
    pub(super) fn check(&self) -> Result<()> {
        match self {
            CaseTest::Stages(stages) if stages.is_empty() => Err(Error::Rule("the case has no stage".into())),
            _ => Ok(()),
        }
    }

    /// The section `[shear]`, if the test is written so.
    pub(super) fn shear(&self) -> Option<&Shear> {
        match self {
            CaseTest::Shear(shear) => Some(shear),
            CaseTest::Stages(_) => None,
        }
    }

    /// As [`CaseTest::shear`], to be changed.
    pub(super) fn shear_mut(&mut self) -> Option<&mut Shear> {
        match self {
            CaseTest::Shear(shear) => Some(shear),
            CaseTest::Stages(_) => None,
        }
    }

    /// The tables `[[stage]]`; none if the test is written as the section `[shear]`.
    pub(super) fn tables(&self) -> &[CaseStage] {
        match self {
            CaseTest::Shear(_) => &[],
            CaseTest::Stages(stages) => stages,
        }
    }

    /// As [`CaseTest::tables`], to be changed.
    pub(super) fn tables_mut(&mut self) -> &mut [CaseStage] {
        match self {
            CaseTest::Shear(_) => &mut [],
            CaseTest::Stages(stages) => stages,
        }
    }
}

/// True for a key that belongs to the section `[shear]`: without it, each stage says so itself.
pub(super) fn is_of_shear(key: &str) -> bool {
    key.starts_with("shear.")
        || ["recording.states", "recording.first_strain", "recording.strains", "recording.snapshots"]
            .contains(&key)
}

impl CaseTest {
    /// What the test comes to in a case with this recording, on a sample prepared at a mean stress `sample_stress`, Pa; stages
    /// go on up to the overlap `largest_overlap`.
    pub(super) fn definition(
        &self,
        recording: &Recording,
        sample_stress: f64,
        largest_overlap: f64,
    ) -> TestDefinition {
        let mut test = match self {
            CaseTest::Shear(shear) => TestDefinition {
                stages: vec![preset::antony2006(shear, recording, sample_stress)],
                initial_mean_stress: Some(shear.mean_stress.unwrap_or(sample_stress)),
                initial_density_scaling: density_scaling(&shear.rate),
                snapshots: recording.snapshots.clone(),
                columns: RecordedColumns::FirstPublished,
                speed_key: "shear.inertial_number",
            },
            CaseTest::Stages(stages) => TestDefinition {
                stages: stages.iter().flat_map(CaseStage::stages).collect(),
                initial_mean_stress: None,
                initial_density_scaling: 1.0,
                snapshots: Vec::new(),
                columns: RecordedColumns::All,
                speed_key: "the inertial_number of the stage",
            },
        };
        test.stages.iter_mut().for_each(|stage| stage.largest_overlap = largest_overlap);
        test
    }

    /// True if a key of the case file can have a part in the result: those of `[shear]` have none beside tables `[[stage]]`.
    pub(super) fn uses(&self, key: &str) -> bool {
        self.shear().is_some() || !is_of_shear(key)
    }
}

#[cfg(test)]
mod tests {
    use granum_dem::config::{Rate, Spacing};
    use granum_dem::loading::{Measure, Speed};

    use super::super::Case;
    use super::*;

    fn parse(text: &str) -> Case {
        Case::parse(text, "case.toml").unwrap_or_else(|error| panic!("{error}\n{text}"))
    }

    #[test]
    fn the_section_shear_is_one_stage_of_the_paper() {
        let case = parse(
            "[shear]\ndeviator_strain = 0.1\nstrain_rate = '2 /s'\ndensity_scaling = 4\nmean_stress = '50 kPa'\n\
             [recording]\nstates = 7\nsnapshots = [0.05]\n",
        );
        let test = case.test_definition();
        let [stage] = test.stages.as_slice() else { panic!("{} stages", test.stages.len()) };
        assert_eq!((stage.name.as_str(), stage.density_scaling), ("shear", 4.0));
        assert_eq!(stage.control.speed, Speed::StrainRate(2.0));
        assert_eq!((stage.record.measure, stage.record.states), (Measure::AxialDeviatorStrain, 7));
        assert_eq!((stage.record.end, test.deviator_strain_end()), (0.1, Some(0.1)));
        assert_eq!((test.initial_mean_stress, test.initial_density_scaling), (Some(50e3), 4.0));
        assert_eq!((test.snapshots, test.columns), (vec![0.05], RecordedColumns::FirstPublished));
    }

    #[test]
    fn stages_bring_the_sample_to_their_stresses_and_record_everything() {
        let test = parse("[[stage]]\npath = 'constant-p'\nmean_stress = '50 kPa'\n").test_definition();
        assert_eq!((test.stages.len(), test.initial_mean_stress), (2, None));
        assert_eq!((test.snapshots, test.columns), (vec![], RecordedColumns::All));
    }

    /// The digest of a case is that of the first version, which had no stages: published, and stored in run folders.
    #[test]
    fn digests_of_both_ways_of_writing_stay() {
        let shear = "[grains]\ncount = 60\n[preparation]\nseed = 3\ninertial_number = 3e-3\n[shear]\nmean_stress = '200 kPa'\n\
                     deviator_strain = 0.02\nstrain_rate = '20 /s'\ndensity_scaling = 4\n[recording]\nfirst_strain = 1e-4\n\
                     states = 10\nsensors = ['invariants']\n";
        let staged = "[grains]\ncount = 60\n[preparation]\nseed = 3\ninertial_number = 3e-3\n[[stage]]\n\
                      path = 'drained-triaxial'\naxial_strain = 0.01\ninertial_number = 3e-3\nstates = 8\n[[stage]]\n\
                      path = 'cyclic'\nstrain_amplitude = 0.002\ncycles = 1\ninertial_number = 3e-3\n";
        for (text, digest) in [(shear, SHEAR_DIGEST), (staged, STAGED_DIGEST)] {
            let case = parse(text);
            assert_eq!(case.digest(), digest);
            assert_eq!(parse(&case.resolved_toml()), case);
        }
    }

    const SHEAR_DIGEST: &str = "ac706a1fe8365df47aad0c0ae91f2146d3274367a3d4d5c4452aeaa45476f042";
    const STAGED_DIGEST: &str = "fbcd3d98cc08f65d8b9177bb55ee43b902bac26f6171c007dbc5074218d94774";

    /// Fields that a program left in a case make no difference once its test is written as stages.
    #[test]
    fn keys_of_shear_count_for_nothing_beside_stages() {
        let case = parse("[[stage]]\npath = 'drained-triaxial'\n");
        let mut other = case.clone();
        other.recording = Recording::default().with(|recording| {
            recording.states = 7;
            recording.snapshots = vec![2.0];
            recording.spacing = Spacing::Geometric(1.0);
        });
        assert!(
            case.test.uses("recording.sensors")
                && !case.test.uses("recording.states")
                && !case.test.uses("shear.mean_stress")
        );
        assert_eq!(case.digest(), other.digest());
        assert_eq!((case.resolved_toml(), case.values()), (other.resolved_toml(), other.values()));
        assert_eq!(case.parameters(), other.parameters());
        assert!(other.check().is_ok());
        let error = other.set("shear.deviator_strain", "0.1").unwrap_err().to_string();
        assert!(error.contains("has no effect in a case with stages; set stage.1.KEY instead"), "{error}");
    }

    #[test]
    fn a_test_without_stages_is_refused() {
        let case = Case::default().with_stages(Vec::new());
        for error in [case.check().unwrap_err(), case.readable_toml(None).unwrap_err()] {
            assert!(error.to_string().contains("the case has no stage"), "{error}");
        }
    }

    #[test]
    fn a_case_as_json_has_its_test_in_one_of_two_forms() {
        let paper = Case::default().with_shear(|shear| shear.rate = Rate::InertialNumber(1e-3));
        for (case, key) in [(paper, "shear"), (parse("[[stage]]\npath = 'isotropic'\n"), "stages")] {
            let json = serde_json::to_value(&case).unwrap();
            assert!(json[key].is_object() || json[key].is_array(), "{json}");
            assert_eq!(serde_json::from_value::<Case>(json).unwrap(), case);
        }
    }
}
