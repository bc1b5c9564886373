//! The specification of a preparation.

use crate::config::{Grains, LARGEST_OVERLAP, Numerics, Preparation};
use crate::contact::choice::contact_model::ContactModel;
use crate::loading;
use crate::simulation::{Hardware, Properties};

/// The specification of a preparation.
#[derive(Clone, Debug)]
pub struct SampleSpecification {
    /// Grains with their final properties.
    pub grains: Grains,
    /// Contact law.
    pub contact: ContactModel,
    /// Preparation parameters.
    pub preparation: Preparation,
    /// Loading paths between compaction and relaxation, in every trial: for example oedometric compression and unloading, or
    /// cycles. What they record is not used, and they cannot start from saved states.
    pub stages: Vec<loading::Stage>,
    /// Time step factor.
    pub time_step_factor: f64,
    /// Largest overlap of grains over the sum of their radii with which the preparation goes on.
    pub largest_overlap: f64,
    /// Threads and instruction set.
    pub hardware: Hardware,
}

impl SampleSpecification {
    /// With the default time step factor, on one thread with the widest instruction set.
    pub fn new(grains: &Grains, contact: &ContactModel, preparation: &Preparation) -> SampleSpecification {
        let Numerics { time_step_factor, .. } = Numerics::default();
        SampleSpecification {
            grains: grains.clone(),
            contact: *contact,
            preparation: preparation.clone(),
            stages: Vec::new(),
            time_step_factor,
            largest_overlap: LARGEST_OVERLAP,
            hardware: Hardware::default(),
        }
    }

    /// The same with loading paths between compaction and relaxation.
    ///
    /// ```
    /// use granum_dem::config::{ContactModel, Grains, Preparation};
    /// use granum_dem::loading::preset::{self, Given, PathValue};
    /// use granum_dem::preparation::SampleSpecification;
    ///
    /// let (grains, contact, preparation) = (Grains::default(), ContactModel::default(), Preparation::default());
    /// // The sample is consolidated in an oedometer, and the relaxation unloads it to the mean stress of the preparation.
    /// let stress = Given::from([("axial_stress".to_string(), PathValue::Number(200e3))]);
    /// let stages = preset::named("oedometer").map_or_else(Vec::new, |path| path.expand(&stress));
    /// let specification = SampleSpecification::new(&grains, &contact, &preparation).with_stages(stages);
    /// assert_eq!(specification.stages.len(), 1);
    /// ```
    pub fn with_stages(self, stages: Vec<loading::Stage>) -> SampleSpecification {
        SampleSpecification { stages, ..self }
    }

    /// Materials and law of the finished sample.
    pub fn properties(&self) -> Properties {
        Properties::for_grains(&self.grains, &self.contact, self.preparation.seed)
    }
}
