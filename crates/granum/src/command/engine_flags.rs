//! Flags for the engine that carries out tests.

use clap::Args;
use granum_run::Laboratory;
use granum_run::engine::Lammps;

use crate::failure::Failure;

/// Name of the engine to which the flags of [`LammpsFlags`] belong.
const LAMMPS: &str = "lammps";

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
        if let Some(flag) = self.lammps.given().filter(|_| laboratory.engine != LAMMPS) {
            return Err(Failure::new(format!("{flag} says how LAMMPS is started: add --engine {LAMMPS}")));
        }
        self.lammps.set(laboratory)
    }
}

impl LammpsFlags {
    /// The flag that is given, if one is.
    fn given(&self) -> Option<&'static str> {
        self.ranks.map(|_| "--ranks").or(self.command.as_ref().map(|_| "--command"))
    }

    /// The laboratory with LAMMPS started in this way.
    pub fn set(&self, mut laboratory: Laboratory) -> Result<Laboratory, Failure> {
        let lammps = match (self.ranks, &self.command) {
            (Some(0), _) => return Err(Failure::new("--ranks 0: at least one process is needed")),
            (Some(ranks), _) => Lammps::on_ranks(ranks),
            (_, Some(command)) if command.trim().is_empty() => {
                return Err(Failure::new(
                    "--command is empty: give the command that starts LAMMPS, e.g. --command \"mpirun -np 4 lmp\"",
                ));
            }
            (_, Some(command)) => Lammps::with_command(command.split_whitespace()),
            (None, None) => return Ok(laboratory),
        };
        laboratory.registry.engines = laboratory.registry.engines.replaced_by(lammps);
        Ok(laboratory)
    }
}
