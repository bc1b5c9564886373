//! How LAMMPS is started, as flags and plans say it.

use serde::{Deserialize, Serialize};

use super::lammps_engine::Lammps;

/// How LAMMPS is started: on a number of processes, or by a command; as `lmp` if neither is given.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct LammpsStart {
    /// Number of processes, started as `mpirun -np N lmp`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ranks: Option<usize>,
    /// The command that starts it; words are separated by spaces.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub command: Option<String>,
}

impl LammpsStart {
    /// The name of what is given, if anything is.
    pub fn given(&self) -> Option<&'static str> {
        self.ranks.map(|_| "ranks").or(self.command.as_ref().map(|_| "command"))
    }

    /// True if neither is given.
    pub fn is_usual(&self) -> bool {
        self.given().is_none()
    }

    /// What is wrong with it, and what would be right.
    pub fn fault(&self) -> Option<&'static str> {
        let is_empty = self.command.as_ref().is_some_and(|command| command.trim().is_empty());
        match self.ranks {
            Some(_) if self.command.is_some() => {
                Some("ranks and command both say how LAMMPS is started: give one of them")
            }
            Some(0) => Some("ranks 0: at least one process is needed"),
            _ if is_empty => {
                Some("command is empty: give the command that starts LAMMPS, e.g. \"mpirun -np 4 lmp\"")
            }
            _ => None,
        }
    }

    /// The engine that is started so; `None` if neither is given.
    pub fn engine(&self) -> Option<Lammps> {
        match (self.ranks, &self.command) {
            (Some(ranks), _) => Some(Lammps::on_ranks(ranks)),
            (None, Some(command)) => Some(Lammps::with_command(command.split_whitespace())),
            (None, None) => None,
        }
    }

    /// Number of processors that one run needs, as far as it is known.
    pub fn processors(&self) -> usize {
        self.ranks.unwrap_or(1).max(1)
    }
}
