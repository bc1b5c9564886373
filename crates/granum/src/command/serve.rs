//! `granum serve`: what is in a folder, in a browser on the same computer.

use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use granum::contents::Contents;
use granum::families;
use granum_io::Run;
use granum_io::case::Vocabulary;
use granum_io::shell::{ShowPath, quoted_path};
use granum_learn::SurrogateMethods;
use granum_learn::family::{FamilyDefinition, FamilyModel};
use granum_page::{Next, Program, Report, Server, TestProperty};
use granum_run::runs_table::RunEntry;
use serde_json::json;

use super::family_flags::FamilyFlags;
use super::report;
use super::run_folders::run_entries;
use crate::context::Context;
use crate::failure::Failure;
use crate::output;

/// The port that is taken unless another one is chosen.
const PORT: u16 = 8347;

/// Show what is in a folder in a browser: runs, campaigns, studies, families and calibrations, the progress of what is running, runs over each
/// other, the map of a campaign, predictions of surrogates, and the command line of whatever is shown.
///
/// The command prints an address with a token and answers until Ctrl-C. It reads and never writes, and only this computer can ask it. Whoever
/// has the address can read the folder.
#[derive(Args)]
#[command(after_help = "Example:\n  granum serve\n  granum serve runs\n  granum serve study --port 0")]
pub struct Serve {
    /// The folder that is shown; the present one by default.
    #[arg(default_value = ".")]
    folder: PathBuf,
    /// Port of this computer; 0 for a free one.
    #[arg(short, long, value_name = "N", default_value_t = PORT)]
    port: u16,
    /// Listen at this address instead of that of this computer alone. Others who reach it and know the token can read the folder, and the
    /// connection is not encrypted: a tunnel (`ssh -L`) is better.
    #[arg(long, value_name = "ADDRESS", default_value_t = IpAddr::V4(Ipv4Addr::LOCALHOST))]
    address: IpAddr,
}

impl Serve {
    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        if !self.folder.is_dir() {
            let wrong = match self.folder.exists() {
                true => "this is a file; granum serve shows the folder in which it is",
                false => "there is no such folder",
            };
            return Err(Failure::new(format!("{}: {wrong}", self.folder.shown())));
        }
        let address = SocketAddr::new(self.address, self.port);
        let server = Server::bind(address, &self.folder, Arc::new(ThisProgram::new(context)))?;
        if !self.address.is_loopback() {
            context.warn(&format!(
                "--address {}: other computers can reach the server; whoever knows the token can read {}, and the connection is not encrypted",
                self.address,
                self.folder.shown()
            ));
        }
        let (url, folder) = (server.url(), self.folder.shown());
        let started =
            json!({ "url": url, "folder": output::path(&self.folder), "port": server.address().port() });
        output::say(context, &started, || {
            format!(
                "{folder} is shown at\n  {url}\nuntil Ctrl-C; whoever has this address can read the folder"
            )
        })?;
        server.run(|| context.stopped())?;
        context.say(|| "every request is answered or dropped".into());
        if !context.json {
            crate::messages::line(format_args!("{folder} is no longer shown; nothing was written"));
        }
        Ok(())
    }
}

/// This program with what it knows by name.
struct ThisProgram(Context);

impl ThisProgram {
    /// Its messages belong to the page, and not to the terminal.
    fn new(context: &Context) -> ThisProgram {
        ThisProgram(context.keeping_messages())
    }
}

fn words(failure: impl Into<Failure>) -> String {
    failure.into().message()
}

impl Program for ThisProgram {
    fn version(&self) -> String {
        format!("granum {}", env!("CARGO_PKG_VERSION"))
    }

    fn vocabulary(&self) -> &Vocabulary {
        self.0.vocabulary()
    }

    fn methods(&self) -> &SurrogateMethods {
        self.0.methods()
    }

    fn run_at(&self, folder: &Path) -> Result<Run, String> {
        self.0.run_at(folder).map_err(words)
    }

    fn report(&self, folders: &[PathBuf]) -> Result<Report, String> {
        let context = self.0.keeping_messages();
        let document = report::document_of(&context, folders).map_err(words)?;
        Ok(Report { document, remarks: context.warnings() })
    }

    fn entries(&self, folder: &Path) -> Result<Vec<RunEntry>, String> {
        run_entries(&self.0, &[folder.to_path_buf()], false).map_err(words)
    }

    fn next(&self, folder: &Path, named: &Path) -> Result<Next, String> {
        let contents = Contents::read(folder, self.0.vocabulary()).map_err(words)?;
        let next = contents.next(folder);
        let [own, shown] = [folder, named].map(quoted_path);
        let by_name = |text: String| text.replace(&own, &shown).replace(&folder.shown(), &named.shown());
        Ok(Next { name: contents.name(), text: by_name(next.text), command: next.command.map(by_name) })
    }

    fn family(&self, family: &FamilyDefinition) -> Result<Option<FamilyModel>, String> {
        families::fitted(family).map_err(words)
    }

    fn properties(&self) -> Vec<TestProperty> {
        FamilyFlags::properties()
            .into_iter()
            .map(|(flag, key, dimension)| TestProperty { flag, key, dimension })
            .collect()
    }
}
