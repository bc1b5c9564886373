//! Force chains in cells of a finite-element computation: `draw_points STATES FIGURE.svg NAME...`
//!
//! `STATES` is the file that a host's script saved of the states of all points; a name is that of a point, here 1000 times the
//! element plus the place of the point in it. Without arguments the program makes a file of its own with three points, and draws them.

use std::path::{Path, PathBuf};

use granum::point::{Controls, Increment, MaterialPoint, Store};
use granum::prelude::*;
use granum::report::figure::chains::View;
use granum::report::figure::{Figure, ForceChains, Panel};

type Anything = Box<dyn std::error::Error>;

/// A file of three points: at rest, compressed and sheared.
fn own_states() -> Result<PathBuf, Anything> {
    let case = "grains.count = 100\npreparation.solid_fraction = 'none'\npreparation.unbalanced_force = 0.02\n\
                preparation.mean_stress = '100 kPa'";
    let point = MaterialPoint::from_case(&Case::parse(case, "case")?, Controls::default())?;
    let increments = [[0.0; 6], [0.0, 2e-3, 0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 0.0, 4e-3]];
    let store = Store::new();
    for (name, strain) in (1..).zip(increments) {
        store.put(name, point.advance(&point.start(), &Increment::from_components(strain))?.state);
    }
    let path = std::env::temp_dir().join(format!("granum-points-{}.granum", std::process::id()));
    store.save(&path)?;
    Ok(path)
}

/// Thickness of the slice that is drawn, in mean diameters.
const SLICE: f64 = 2.5;

// ANCHOR: chains
/// The force chains of points in a slice through the middle of each cell: x to the right and y up.
fn figure(states: &Path, names: &[u64]) -> Result<Figure, Anything> {
    let store = Store::load(states)?;
    let mut pictures = Vec::new();
    for name in names {
        // The state that the host accepted last.
        let (state, _) = store.accepted(*name)?;
        let [[x, shear, _], [_, y, _], _] = state.stress().map(|row| row.map(|stress| 1e-3 * stress));
        let title = format!("{name}: *σ*_{{x}} {x:.0}, *σ*_{{y}} {y:.0}, *τ*_{{xy}} {shear:.0} kPa");
        let assembly = state.observed().assembly();
        let view = View { up: 1, right: 0, ..View::slice(&assembly, SLICE) };
        pictures.push((ForceChains::new(&assembly, view), title));
    }
    // One scale for all pictures.
    let extent = pictures.iter().fold([0.0f64; 2], |largest, (picture, _)| {
        std::array::from_fn(|k| largest[k].max(picture.extent()[k]))
    });
    let width = 260.0 * pictures.len() as f64;
    let height = ForceChains::height_for(extent, 244.0) + 30.0;
    let panels: Vec<Panel> = pictures
        .into_iter()
        .map(|(picture, title)| Panel::chains(picture.with_extent(extent)).titled(&title))
        .collect();
    Ok(Figure::new("Force chains in cells of a finite-element computation", names.len(), panels)
        .sized(width, height))
}
// ANCHOR_END: chains

/// The whole program.
pub fn main() -> Result<(), Anything> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let [states, place, names @ ..] = &arguments[..]
        && place.ends_with(".svg")
    {
        let names = names.iter().map(|name| name.parse()).collect::<Result<Vec<u64>, _>>()?;
        std::fs::write(place, figure(Path::new(states), &names)?.to_svg())?;
        return Ok(());
    }
    let states = own_states()?;
    let svg = figure(&states, &[1, 2, 3])?.to_svg();
    std::fs::remove_file(states)?;
    assert!(svg.contains("Point 3") && svg.matches("<path").count() > 30);
    println!("{} bytes of SVG; give STATES FIGURE.svg NAME... to draw points of a computation", svg.len());
    Ok(())
}
