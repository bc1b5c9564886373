//! The grains of a run at one of its snapshots, for the viewer.

use granum_core::Parts;
use granum_report::viewer::{Colour, GrainColour, View, data};
use serde_json::json;

use crate::answer::{Answer, Answered};
use crate::query::Query;
use crate::refused::Refused;
use crate::site::Site;

/// Most spheres that are shown: 13 bytes each.
const MOST_SPHERES: usize = 400_000;

/// Grains, forces, bonds and cracks: `path`, `snapshot`, `colour`.
pub fn grains(site: &Site, query: &Query) -> Answered {
    let run = site.run(query.needed("path")?)?;
    let name = query.needed("snapshot")?;
    let colour = query.get("colour").unwrap_or("radius");
    let colour =
        GrainColour::named(colour).ok_or_else(|| Refused::bad(format!("there is no colour {colour:?}")))?;
    let wrong = |error: granum_io::Error| Refused::unreadable(site.without_root(error));
    if !run.snapshots().map_err(wrong)?.iter().any(|known| known == name) {
        return Err(Refused::not_found(format!("the run has no snapshot {name:?}")));
    }
    let assembly = run.snapshot(name).map_err(wrong)?;
    if assembly.pieces.len() > MOST_SPHERES {
        return Err(Refused::unreadable(format!(
            "the snapshot has {} spheres, more than a page shows ({MOST_SPHERES})",
            assembly.pieces.len()
        )));
    }
    let view = View::default().with(|view| view.colour = Colour::Grain(colour));
    Ok(Answer::Json(json!({
        "grains": assembly.bodies.len(),
        "colours": GrainColour::ALL.map(GrainColour::name),
        "data": data(&assembly, Parts::all(), &view),
    })))
}
