//! `granum view`: grains, forces, bonds and cracks in three dimensions, as a page for any browser.

use std::io::Write;
use std::path::PathBuf;

use clap::Args;
use granum_core::names::suggestion;
use granum_io::atomic::write_atomically;
use granum_io::check_output_file;
use granum_io::formats::ObservedAssembly;
use granum_io::shell::ShowPath;
use granum_report::viewer::{Colour, GrainColour, View, page};
use serde_json::json;

use super::sources::SourceFlags;
use super::whole::open_run;
use crate::context::Context;
use crate::failure::Failure;
use crate::output;

/// Show grains as what they are, contact forces, force chains, bonds and cracks in three dimensions: one page for any browser, which needs
/// neither a server nor the network.
///
/// Drag turns the sample, the wheel brings it nearer, and there are switches for grains, forces, chains, bonds and cracks, and a cut.
#[derive(Args)]
#[command(
    after_help = "Example:\n  granum view run-1 -o grains.html\n  granum view run-1 --snapshot start --colour coordination -o \
                  start.html\n  granum view grains.dump -o grains.html"
)]
pub struct ViewGrains {
    /// A run folder, a packing file, or files of results of another program.
    #[arg(required = true, value_name = "DATA")]
    data: Vec<PathBuf>,
    /// The page to write.
    #[arg(short, long, visible_alias = "out", value_name = "FILE")]
    output: PathBuf,
    /// Snapshot of the run folder, the one at its end by default. Of other results the number of the instant, from 1; the last by default.
    #[arg(long, value_name = "NAME")]
    snapshot: Option<String>,
    /// What the grains are coloured by: radius, speed, spin, coordination, chain_length, bonds or fragment.
    #[arg(long, value_name = "QUANTITY", default_value = "radius")]
    colour: String,
    /// Opacity of the grains, 0 to 1.
    #[arg(long, value_name = "SHARE", default_value_t = 0.25)]
    opacity: f64,
    /// Show the forces of force chains alone at first.
    #[arg(long)]
    chains: bool,
    /// Show of more contacts than these those with the largest forces.
    #[arg(long, value_name = "N", default_value_t = 6000)]
    strongest: usize,
    #[command(flatten)]
    sources: SourceFlags,
}

impl ViewGrains {
    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        let _alone = context.nothing_written(Some("drawing"));
        let view = self.view()?;
        check_output_file(&self.output, context.force)?;
        let shown = self.observed(context)?;
        let text = page(&shown.assembly, shown.parts, &view);
        write_atomically(&self.output, |file| file.write_all(text.as_bytes()))?;
        let (grains, contacts) = (shown.assembly.bodies.len(), shown.assembly.contacts.len());
        let (bonds, cracks) = (shown.assembly.bonds.len(), shown.assembly.broken_bonds.len());
        let result = json!({
            "output": output::path(&self.output), "grains": grains, "contacts": contacts, "bonds": bonds, "cracks": cracks,
        });
        output::say(context, &result, || {
            let bonded =
                if bonds + cracks > 0 { format!(", {bonds} bonds, {cracks} cracks") } else { String::new() };
            format!("{grains} grains, {contacts} contacts{bonded}: open {} in a browser", self.output.shown())
        })
    }

    /// How it is shown.
    fn view(&self) -> Result<View, Failure> {
        let names = GrainColour::ALL.map(GrainColour::name);
        let Some(colour) = GrainColour::named(&self.colour) else {
            let meant = suggestion(&self.colour, names.into_iter());
            return Err(Failure::new(format!(
                "--colour {}: there is no such quantity; {meant}",
                self.colour
            )));
        };
        if !(0.0..=1.0).contains(&self.opacity) {
            return Err(Failure::new(format!("--opacity {}: it must be between 0 and 1", self.opacity)));
        }
        Ok(View::default().with(|view| {
            view.colour = Colour::Grain(colour);
            (view.opacity, view.chains, view.strongest) = (self.opacity, self.chains, self.strongest);
            view.title = self.data.first().map(|data| {
                let name = self.snapshot.as_ref().map(|name| format!(", {name}")).unwrap_or_default();
                format!("{}{name}", data.file_name().unwrap_or(data.as_os_str()).to_string_lossy())
            });
        }))
    }

    /// What is shown.
    fn observed(&self, context: &Context) -> Result<ObservedAssembly, Failure> {
        if let [folder] = &self.data[..]
            && folder.is_dir()
        {
            let run = open_run(context, folder)?;
            let names = run.snapshots()?;
            let usual = || names.iter().find(|name| *name == "end").or(names.first()).cloned();
            let Some(name) = self.snapshot.clone().or_else(usual) else {
                return Err(Failure::new(format!("{}: it has no snapshot yet", folder.shown())));
            };
            if !names.contains(&name) {
                let meant = suggestion(&name, names.iter().map(String::as_str));
                return Err(Failure::new(format!("{}: it has no snapshot {name}; {meant}", folder.shown())));
            }
            return Ok(ObservedAssembly::complete(run.snapshot(&name)?));
        }
        let mut instants = self.sources.read(context, &self.data)?;
        let count = instants.len();
        let at = match &self.snapshot {
            None => count,
            Some(name) => name.parse().ok().filter(|at| (1..=count).contains(at)).ok_or_else(|| {
                Failure::new(format!("--snapshot {name}: it must be the number of an instant, 1 to {count}"))
            })?,
        };
        if at == 0 {
            return Err(Failure::new(format!("{}: there is nothing in it", self.data[0].shown())));
        }
        Ok(instants.swap_remove(at - 1).with_contacts_by_geometry())
    }
}
