//! The fitted surrogates of a study.

use serde::{Deserialize, Serialize};

use crate::surrogate::{FitSpec, Surrogate};

/// The reason why a study contains a surrogate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum MemberRole {
    /// Its method was asked for.
    Asked,
    /// It is a baseline whose only input is the coordinate.
    CoordinateOnly,
    /// It is another baseline.
    Baseline,
}

/// A fitted surrogate of a study.
pub struct Member {
    /// Its name, which is that of its file: `stress_ratio-ridge`, `stress_ratio-ridge-coordinate-only`.
    pub name: String,
    /// Name of its method.
    pub method: String,
    /// Its role.
    pub role: MemberRole,
    /// The surrogate.
    pub surrogate: Box<dyn Surrogate>,
}

/// One fit of a study with its surrogates.
pub struct StudyFit {
    /// Its name: that of its outputs.
    pub name: String,
    /// Inputs, outputs and coordinate.
    pub spec: FitSpec,
    /// What was asked for, then the baselines.
    pub members: Vec<Member>,
    /// Sentences on baselines that could not be fitted.
    pub remarks: Vec<String>,
}

impl StudyFit {
    /// The surrogate with which the help of the other inputs is measured: the same method with the coordinate only, or else
    /// the mean curve.
    pub fn coordinate_only(&self, member: &Member) -> Option<&dyn Surrogate> {
        let same =
            |other: &&Member| other.role == MemberRole::CoordinateOnly && other.method == member.method;
        let curve = |other: &&Member| other.method == crate::methods::mean_curve::NAME;
        let found = self.members.iter().find(same).or_else(|| self.members.iter().find(curve));
        found.map(|member| member.surrogate.as_ref())
    }
}
