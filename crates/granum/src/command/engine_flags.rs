//! Flags for the engine that carries out tests.

use clap::Args;
use granum_run::Laboratory;
use granum_run::engine::{LAMMPS, LammpsStart};

use crate::failure::Failure;

/// The engine.
#[derive(Args, Clone, Debug, Default)]
pub struct EngineFlags {
    /// Engine that carries out the tests: granum, or lammps, which must be installed; samples are always granum's.
    #[arg(long, value_name = "NAME")]
    engine: Option<String>,
    #[command(flatten)]
    lammps: LammpsFlags,
}

/// How LAMMPS is started.
#[derive(Args, Clone, Debug, Default)]
pub struct LammpsFlags {
    /// With LAMMPS as the engine: number of processes, as `mpirun -np N lmp`.
    #[arg(long, value_name = "N")]
    ranks: Option<usize>,
    /// With LAMMPS as the engine: the command that starts it, e.g. --command "mpirun -np 4 lmp"; words are separated by spaces.
    #[arg(long, value_name = "COMMAND", conflicts_with = "ranks")]
    command: Option<String>,
}

impl EngineFlags {
    /// The laboratory with this engine.
    pub fn set(&self, mut laboratory: Laboratory) -> Result<Laboratory, Failure> {
        if let Some(name) = &self.engine {
            laboratory.registry.engines.named(name)?;
            laboratory.engine.clone_from(name);
        }
        if let Some(flag) = self.lammps.start()?.given().filter(|_| laboratory.engine != LAMMPS) {
            return Err(Failure::new(format!("--{flag} says how LAMMPS is started: add --engine {LAMMPS}")));
        }
        self.lammps.set(laboratory)
    }
}

impl LammpsFlags {
    /// How LAMMPS is to be started.
    pub fn start(&self) -> Result<LammpsStart, Failure> {
        let start = LammpsStart { ranks: self.ranks, command: self.command.clone() };
        match start.fault() {
            Some(why) => Err(Failure::new(format!("--{why}"))),
            None => Ok(start),
        }
    }

    /// The laboratory with LAMMPS started in this way.
    pub fn set(&self, mut laboratory: Laboratory) -> Result<Laboratory, Failure> {
        if let Some(lammps) = self.start()?.engine() {
            laboratory.registry.engines = laboratory.registry.engines.replaced_by(lammps);
        }
        Ok(laboratory)
    }
}
