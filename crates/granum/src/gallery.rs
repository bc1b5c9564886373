//! Ready cases, one file each in `crates/granum/gallery/`, and ready plans in its folder `plans`. A new case needs a file and a line in
//! [`CASES`], a new plan in [`PLANS`].

/// A ready case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct ReadyCase {
    /// Its name, for `granum init --case NAME`.
    pub name: &'static str,
    /// The text of the case file, whose first comment line says what it is.
    pub text: &'static str,
}

macro_rules! cases {
    ($($name:literal,)*) => {
        /// All ready cases.
        ///
        /// ```
        /// use granum::gallery::CASES;
        /// use granum_io::Case;
        ///
        /// let ready = CASES.iter().find(|ready| ready.name == "drained-dense").unwrap();
        /// assert!(ready.title().contains("dense"));
        /// let case = Case::parse(ready.text, "drained-dense.toml")?;
        /// assert_eq!(case.test_stages().len(), 2);
        /// # Ok::<(), granum_io::Error>(())
        /// ```
        pub const CASES: &[ReadyCase] = &[$(
            ReadyCase { name: $name, text: include_str!(concat!("../gallery/", $name, ".toml")) },
        )*];
    };
}

cases! {
    "paper",
    "drained-dense",
    "drained-loose",
    "undrained-loose",
    "undrained-dense",
    "cyclic-undrained",
    "cyclic-drained",
    "simple-shear",
    "true-triaxial",
    "powder-oedometer",
    "powder-flow",
    "wet-grains",
    "rolling-resistance",
    "long-grains",
    "bedded-grains",
    "cemented-sand",
    "cemented-sand-undrained",
    "rock-like",
    "crushable-grains",
    "karlsruhe-dense",
    "karlsruhe-loose",
    "strain-history",
}

impl ReadyCase {
    /// What it is, from the first line of its file.
    pub fn title(&self) -> &'static str {
        self.text.lines().next().unwrap_or_default().trim_start_matches('#').trim()
    }

    /// The ready case of a name.
    pub fn named(name: &str) -> Option<&'static ReadyCase> {
        CASES.iter().find(|ready| ready.name == name)
    }
}

/// A ready plan, for `granum campaign`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct ReadyPlan {
    /// Its name, for `granum init --plan NAME`.
    pub name: &'static str,
    /// The name of the ready case that is its base case.
    pub case: &'static str,
    /// The text of the plan, whose first comment line says what it is.
    pub text: &'static str,
}

/// All ready plans.
pub const PLANS: &[ReadyPlan] = &[
    ReadyPlan {
        name: "friction-pressure-density",
        case: "drained-dense",
        text: include_str!("../gallery/plans/friction-pressure-density.toml"),
    },
    ReadyPlan {
        name: "cement-strength",
        case: "cemented-sand",
        text: include_str!("../gallery/plans/cement-strength.toml"),
    },
    ReadyPlan {
        name: "powder-cohesion",
        case: "powder-oedometer",
        text: include_str!("../gallery/plans/powder-cohesion.toml"),
    },
    ReadyPlan {
        name: "flow-function",
        case: "powder-flow",
        text: include_str!("../gallery/plans/flow-function.toml"),
    },
    ReadyPlan {
        name: "flow-function-limestone",
        case: "powder-flow",
        text: include_str!("../gallery/plans/flow-function-limestone.toml"),
    },
    ReadyPlan {
        name: "sand-drained",
        case: "drained-dense",
        text: include_str!("../gallery/plans/sand-drained.toml"),
    },
    ReadyPlan {
        name: "sand-drained-unseen",
        case: "drained-dense",
        text: include_str!("../gallery/plans/sand-drained-unseen.toml"),
    },
    ReadyPlan {
        name: "sand-drained-score",
        case: "drained-dense",
        text: include_str!("../gallery/plans/sand-drained-score.toml"),
    },
    ReadyPlan {
        name: "sand-drained-quarters",
        case: "drained-dense",
        text: include_str!("../gallery/plans/sand-drained-quarters.toml"),
    },
    ReadyPlan {
        name: "sand-paths",
        case: "undrained-dense",
        text: include_str!("../gallery/plans/sand-paths.toml"),
    },
    ReadyPlan {
        name: "sand-paths-unseen",
        case: "undrained-dense",
        text: include_str!("../gallery/plans/sand-paths-unseen.toml"),
    },
    ReadyPlan {
        name: "sand-paths-quarters",
        case: "undrained-dense",
        text: include_str!("../gallery/plans/sand-paths-quarters.toml"),
    },
    ReadyPlan {
        name: "sand-undrained",
        case: "undrained-dense",
        text: include_str!("../gallery/plans/sand-undrained.toml"),
    },
    ReadyPlan {
        name: "sand-undrained-score",
        case: "undrained-dense",
        text: include_str!("../gallery/plans/sand-undrained-score.toml"),
    },
    ReadyPlan {
        name: "shaped-sand",
        case: "long-grains",
        text: include_str!("../gallery/plans/shaped-sand.toml"),
    },
    ReadyPlan {
        name: "shaped-sand-unseen",
        case: "long-grains",
        text: include_str!("../gallery/plans/shaped-sand-unseen.toml"),
    },
    ReadyPlan {
        name: "shaped-sand-score",
        case: "long-grains",
        text: include_str!("../gallery/plans/shaped-sand-score.toml"),
    },
    ReadyPlan {
        name: "powder-paths",
        case: "powder-oedometer",
        text: include_str!("../gallery/plans/powder-paths.toml"),
    },
    ReadyPlan {
        name: "powder-paths-unseen",
        case: "powder-oedometer",
        text: include_str!("../gallery/plans/powder-paths-unseen.toml"),
    },
    ReadyPlan {
        name: "powder-paths-score",
        case: "powder-oedometer",
        text: include_str!("../gallery/plans/powder-paths-score.toml"),
    },
    ReadyPlan {
        name: "powder-paths-quarters",
        case: "powder-oedometer",
        text: include_str!("../gallery/plans/powder-paths-quarters.toml"),
    },
    ReadyPlan {
        name: "random-paths",
        case: "rolling-resistance",
        text: include_str!("../gallery/plans/random-paths.toml"),
    },
    ReadyPlan {
        name: "random-paths-unseen",
        case: "rolling-resistance",
        text: include_str!("../gallery/plans/random-paths-unseen.toml"),
    },
    ReadyPlan {
        name: "random-paths-score",
        case: "rolling-resistance",
        text: include_str!("../gallery/plans/random-paths-score.toml"),
    },
    ReadyPlan {
        name: "random-paths-further",
        case: "rolling-resistance",
        text: include_str!("../gallery/plans/random-paths-further.toml"),
    },
    ReadyPlan {
        name: "random-paths-cycles",
        case: "rolling-resistance",
        text: include_str!("../gallery/plans/random-paths-cycles.toml"),
    },
    ReadyPlan {
        name: "sand-step",
        case: "rolling-resistance",
        text: include_str!("../gallery/plans/sand-step.toml"),
    },
    ReadyPlan {
        name: "sand-step-unseen",
        case: "rolling-resistance",
        text: include_str!("../gallery/plans/sand-step-unseen.toml"),
    },
];

impl ReadyPlan {
    /// What it is, from the first line of its file.
    pub fn title(&self) -> &'static str {
        self.text.lines().next().unwrap_or_default().trim_start_matches('#').trim()
    }

    /// The ready plan of a name.
    pub fn named(name: &str) -> Option<&'static ReadyPlan> {
        PLANS.iter().find(|ready| ready.name == name)
    }
}

/// A ready file of a calibration, for `granum calibrate`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct ReadyCalibration {
    /// Its name, for `granum init --calibration NAME`.
    pub name: &'static str,
    /// The name of the ready case that is its base case.
    pub case: &'static str,
    /// The text of the file, whose first comment line says what it is.
    pub text: &'static str,
}

/// All ready files of calibrations.
pub const CALIBRATIONS: &[ReadyCalibration] = &[ReadyCalibration {
    name: "karlsruhe-sand",
    case: "karlsruhe-loose",
    text: include_str!("../gallery/calibrations/karlsruhe-sand.toml"),
}];

impl ReadyCalibration {
    /// What it is, from the first line of its file.
    pub fn title(&self) -> &'static str {
        self.text.lines().next().unwrap_or_default().trim_start_matches('#').trim()
    }

    /// The ready file of a name.
    pub fn named(name: &str) -> Option<&'static ReadyCalibration> {
        CALIBRATIONS.iter().find(|ready| ready.name == name)
    }
}
