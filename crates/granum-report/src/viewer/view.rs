//! What is shown, and how.

use super::colour::{Colour, GrainColour};

/// What is shown of an assembly, and how.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct View {
    /// The title of the page; by default the number of grains.
    pub title: Option<String>,
    /// What the grains are coloured by.
    pub colour: Colour,
    /// Opacity of the grains, 0 to 1; by default 0.25, so that forces are seen between them.
    pub opacity: f64,
    /// Whether contact forces are shown at first; a switch of the page shows and hides them.
    pub forces: bool,
    /// Whether only the forces of force chains are shown at first.
    pub chains: bool,
    /// Whether cracks are shown at first, where bonds ruptured.
    pub cracks: bool,
    /// Of more contacts than these, those with the largest forces are shown, so that the page stays small.
    pub strongest: usize,
}

impl Default for View {
    fn default() -> View {
        View {
            title: None,
            colour: Colour::Grain(GrainColour::Radius),
            opacity: 0.25,
            forces: true,
            chains: false,
            cracks: true,
            strongest: 6000,
        }
    }
}

impl View {
    /// The same with changes, e.g. `View::default().with(|view| view.chains = true)`.
    pub fn with(mut self, change: impl FnOnce(&mut View)) -> View {
        change(&mut self);
        self
    }
}
