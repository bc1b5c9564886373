//! What grains are coloured by.

use granum_core::Assembly;
use granum_sensors::fragments::fragments;

/// What the colour of a grain stands for.
#[derive(Clone, Debug, PartialEq)]
pub enum Colour {
    /// A quantity of the grain.
    Grain(GrainColour),
    /// A finite number for each grain, in the order of the assembly.
    Values(Vec<f64>),
}

/// Quantities of a grain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GrainColour {
    /// Radius of the sphere of its volume, m.
    Radius,
    /// Fluctuating velocity, m/s.
    Speed,
    /// Spin, rad/s.
    Spin,
    /// Number of its contacts.
    Coordination,
    /// Number of grains of its force chain; 0 outside of chains.
    ChainLength,
    /// Number of its bonds that hold.
    Bonds,
    /// Mass of its fragment, the grains that bonds hold together, over that of the largest one.
    Fragment,
}

impl GrainColour {
    /// All of them.
    pub const ALL: [GrainColour; 7] = [
        GrainColour::Radius,
        GrainColour::Speed,
        GrainColour::Spin,
        GrainColour::Coordination,
        GrainColour::ChainLength,
        GrainColour::Bonds,
        GrainColour::Fragment,
    ];

    /// Its name in commands.
    pub fn name(self) -> &'static str {
        match self {
            GrainColour::Radius => "radius",
            GrainColour::Speed => "speed",
            GrainColour::Spin => "spin",
            GrainColour::Coordination => "coordination",
            GrainColour::ChainLength => "chain_length",
            GrainColour::Bonds => "bonds",
            GrainColour::Fragment => "fragment",
        }
    }

    /// The quantity of a name.
    ///
    /// ```
    /// use granum_report::viewer::GrainColour;
    ///
    /// assert_eq!(GrainColour::named("spin"), Some(GrainColour::Spin));
    /// ```
    pub fn named(name: &str) -> Option<GrainColour> {
        GrainColour::ALL.into_iter().find(|colour| colour.name() == name)
    }

    /// What the scale of colours says.
    fn label(self) -> &'static str {
        match self {
            GrainColour::Radius => "radius (m)",
            GrainColour::Speed => "speed (m/s)",
            GrainColour::Spin => "spin (rad/s)",
            GrainColour::Coordination => "contacts",
            GrainColour::ChainLength => "grains of the chain",
            GrainColour::Bonds => "bonds",
            GrainColour::Fragment => "mass of the fragment over that of the largest",
        }
    }
}

/// The length of a vector.
fn length([x, y, z]: [f64; 3]) -> f64 {
    (x * x + y * y + z * z).sqrt()
}

/// How many pairs of indices of grains have each grain.
fn counts(grains: usize, pairs: impl Iterator<Item = [usize; 2]>) -> Vec<f64> {
    let mut counts = vec![0.0; grains];
    for grain in pairs.flatten() {
        if let Some(count) = counts.get_mut(grain) {
            *count += 1.0;
        }
    }
    counts
}

impl Colour {
    /// What the scale says, and the value of each grain. The chains are those of the assembly.
    pub(super) fn values(&self, assembly: &Assembly, chains: &[Vec<usize>]) -> (&'static str, Vec<f64>) {
        let bodies = &assembly.bodies;
        let kind = match self {
            Colour::Grain(kind) => *kind,
            Colour::Values(values) => {
                let mut values = values.clone();
                values.resize(bodies.len(), 0.0);
                return ("", values);
            }
        };
        let values = match kind {
            GrainColour::Radius => bodies.iter().map(|body| body.equivalent_radius).collect(),
            GrainColour::Speed => bodies.iter().map(|body| length(body.velocity)).collect(),
            GrainColour::Spin => bodies.iter().map(|body| length(body.spin)).collect(),
            GrainColour::Coordination => counts(
                bodies.len(),
                assembly.contacts.iter().filter_map(|contact| assembly.bodies_of(contact)),
            ),
            GrainColour::ChainLength => {
                let mut lengths = vec![0.0; bodies.len()];
                for chain in chains {
                    chain.iter().for_each(|grain| lengths[*grain] = chain.len() as f64);
                }
                lengths
            }
            GrainColour::Bonds => {
                let ends = |piece| assembly.body_of(piece);
                let pairs = assembly.bonds.iter().filter_map(|bond| Some([ends(bond.i)?, ends(bond.j)?]));
                counts(bodies.len(), pairs)
            }
            GrainColour::Fragment => shares_of_fragments(assembly),
        };
        (kind.label(), values)
    }
}

/// For each grain the mass of its fragment over that of the largest.
fn shares_of_fragments(assembly: &Assembly) -> Vec<f64> {
    let found = fragments(assembly);
    let largest = found.iter().map(|fragment| fragment.mass).fold(f64::MIN_POSITIVE, f64::max);
    let mut shares = vec![0.0; assembly.bodies.len()];
    for fragment in &found {
        for body in &fragment.bodies {
            shares[*body] = fragment.mass / largest;
        }
    }
    shares
}
