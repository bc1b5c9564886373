//! A view of grains in three dimensions: one page with grains as what they are, with all of their spheres, contact forces, force chains (Peters
//! et al. 2005), bonds and cracks. It needs neither a server nor the network: `viewer.js` beside this file draws it by WebGL 2.
//!
//! `granum view` writes it, and so does the Python package.

mod colour;
mod content;
mod view;

use granum_core::{Assembly, Parts};
use maud::{Markup, html};

use super::page::COMPONENTS;

pub use colour::{Colour, GrainColour};
pub use view::View;

const PAGE: &str = include_str!("page.html");
/// The module that draws, for a page that has the elements of `granum view` and gets [`data`] of its own accord.
pub const VIEWER: &str = include_str!("viewer.js");

/// The page that shows an assembly, of which these parts are known.
///
/// ```
/// use granum_core::{Assembly, Parts};
/// use granum_report::viewer::{View, page};
///
/// let page = page(&Assembly::default(), Parts::all(), &View::default());
/// assert!(page.contains("<title>0 grains</title>"));
/// ```
pub fn page(assembly: &Assembly, parts: Parts, view: &View) -> String {
    let title = view.title.clone().unwrap_or_else(|| format!("{} grains", assembly.bodies.len()));
    // In a script an end tag would end it.
    let data = content::content(assembly, parts, view).to_string().replace('<', "\\u003c");
    let title = html! { (title) }.into_string();
    let mut page = String::with_capacity(PAGE.len() + VIEWER.len() + data.len());
    // In one pass, so that no title and no data stand for another place.
    let mut rest = PAGE;
    while let Some(at) = rest.find("__") {
        let (before, after) = rest.split_at(at);
        page.push_str(before);
        let places = [
            ("__TITLE__", title.as_str()),
            ("__DATA__", &data),
            ("__VIEWER__", VIEWER),
            ("__COMPONENTS__", COMPONENTS),
        ];
        let found = places.into_iter().find(|(place, _)| after.starts_with(place));
        let (place, text) = found.unwrap_or(("__", "__"));
        page.push_str(text);
        rest = &after[place.len()..];
    }
    page + rest
}

/// What the module [`VIEWER`] draws of an assembly, of which these parts are known, as JSON.
pub fn data(assembly: &Assembly, parts: Parts, view: &View) -> serde_json::Value {
    content::content(assembly, parts, view)
}

/// The most spheres that a report shows in its viewer (13 bytes each in the page), and the contacts beside them (21 bytes each).
const MOST_SPHERES: usize = 10_000;
const CONTACTS: usize = 3000;

/// The viewer in a report, folded away until a reader wants it. Nothing for larger samples, for which `granum view` makes a page of their own.
pub(crate) fn folded(assembly: &Assembly) -> Option<Markup> {
    if assembly.pieces.is_empty() || assembly.pieces.len() > MOST_SPHERES {
        return None;
    }
    let text = page(assembly, Parts::all(), &View::default().with(|view| view.strongest = CONTACTS));
    Some(html! {
        details {
            summary { "Grains and forces at the end in three dimensions" }
            iframe title="Grains and forces at the end" srcdoc=(text) style="width: 100%; height: 34rem; border: 0" loading="lazy" {}
        }
    })
}

#[cfg(test)]
mod tests;
