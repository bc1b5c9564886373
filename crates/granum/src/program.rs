//! The program `granum`: its command line, for this program and for programs that add to it.

use std::borrow::Cow;
use std::ffi::OsString;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches, Parser};
use granum_io::safe_text;

use crate::command::{self, Command};
use crate::context::Context;
use crate::failure::Failure;
use crate::registry::Registry;
use crate::{interrupt, messages, output};

/// Exit status for an invalid command line.
const USAGE: u8 = 2;

/// A discrete element laboratory for granular materials, with neural surrogates that report their own uncertainty.
#[derive(Parser)]
#[command(name = "granum", version, arg_required_else_help = true, max_term_width = 110)]
struct Arguments {
    /// Print results, warnings and errors as JSON, and show no progress.
    #[arg(long, global = true, help_heading = "Global options")]
    json: bool,
    /// Replace existing files and folders.
    #[arg(long, global = true, help_heading = "Global options")]
    force: bool,
    /// Print more information on what is done.
    #[arg(short, long, global = true, help_heading = "Global options")]
    verbose: bool,
    /// Also read files outside the folder of the input file that names them (histories, sieve curves, *ImportFile, parts of a .vtm).
    #[arg(long, global = true, help_heading = "Global options")]
    allow_outside: bool,
    #[command(subcommand)]
    command: Command,
}

/// Suppresses the messages of panics in third-party decoders, which are converted into errors that name the file.
fn quiet_contained_panics() {
    let before = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |info| {
        if !granum_io::is_contained() {
            before(info);
        }
    }));
}

/// Runs the program with the arguments of the command line. Cases, help texts and lists know what the registry holds, so that a
/// program with laws, paths, sensors, formats, engines or methods of its own has all commands of granum as well.
///
/// It prints, installs handlers of signals and changes the message of panics, as the main function of a program does; it is to be
/// called once, by such a function.
///
/// ```no_run
/// use granum::prelude::*;
///
/// fn main() -> std::process::ExitCode {
///     granum::program::run(Registry::standard())
/// }
/// ```
pub fn run(registry: Registry) -> ExitCode {
    let program = std::env::current_exe().ok();
    run_with(registry, std::env::args_os().collect(), program)
}

/// As [`run`], with a command line that another language's interpreter received, for instance. The first of `arguments` is the name of
/// the program. `program` is the file that starts it, which the coordinator of a campaign starts for every run; without one, such
/// commands are refused.
///
/// ```
/// use granum::prelude::*;
///
/// let line = ["granum", "schema"].map(std::ffi::OsString::from);
/// assert_eq!(granum::program::run_with(Registry::standard(), line.to_vec(), None), std::process::ExitCode::SUCCESS);
/// ```
pub fn run_with(registry: Registry, arguments: Vec<OsString>, program: Option<PathBuf>) -> ExitCode {
    quiet_contained_panics();
    let found = command::described(Arguments::command(), &registry).try_get_matches_from(&arguments);
    let arguments = match found.and_then(|found| Arguments::from_arg_matches(&found)) {
        Ok(parsed) => parsed,
        Err(error) => return refuse(&error, &arguments),
    };
    let (stop, warnings) = interrupt::install();
    let context = Context::new(registry, arguments.json, arguments.force, arguments.verbose, stop)
        .allowing_outside(arguments.allow_outside)
        .started_by(program);
    warnings.iter().for_each(|warning| context.warn(warning));
    match arguments.command.run(&context) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.print(context.json, &context.warnings()),
    }
}

/// Prints the help, or the error of an invalid command line.
fn refuse(error: &clap::Error, arguments: &[OsString]) -> ExitCode {
    let json = arguments.iter().skip(1).take_while(|word| *word != "--").any(|word| word == "--json");
    if !error.use_stderr() {
        return output::written(error.print())
            .map_or_else(|failure| failure.print(json, &[]), |()| ExitCode::SUCCESS);
    }
    if json {
        Failure::print_usage_as_json(error);
    } else {
        // Words of the command line may hold signs that a terminal obeys; then the error has no colours.
        let plain = error.render().to_string();
        match safe_text::terminal(&plain) {
            // Its loss changes nothing about the exit status.
            Cow::Borrowed(_) => drop(error.print()),
            Cow::Owned(safe) => messages::write(&safe),
        }
    }
    ExitCode::from(USAGE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use granum_core::observer::Observer;
    use granum_learn::surrogate::{Columns, Content};
    use granum_learn::{Dataset, FitSpec, LearnError, Result, Surrogate, SurrogateMethod};

    /// A method that only has a name.
    struct Named;

    impl SurrogateMethod for Named {
        fn name(&self) -> &str {
            "own-method"
        }

        fn help(&self) -> &str {
            "a method of a user"
        }

        fn fit(&self, _: &Dataset, _: &FitSpec, _: &mut dyn Observer) -> Result<Box<dyn Surrogate>> {
            Err(LearnError::Stopped { done: 0, total: 0 })
        }

        fn load(&self, _: Columns, _: &Content) -> Result<Box<dyn Surrogate>> {
            Err(LearnError::Stopped { done: 0, total: 0 })
        }
    }

    #[test]
    fn help_lists_what_the_registry_holds() {
        let help = |registry: &Registry, name: &str| {
            let mut line = command::described(Arguments::command(), registry);
            line.find_subcommand_mut(name).unwrap().render_long_help().to_string()
        };
        let standard = Registry::standard();
        assert!(help(&standard, "pair").contains("Normal law: hertz"));
        assert!(help(&standard, "impact").contains("contact.rolling_friction"));
        assert!(help(&standard, "train").contains("- ridge: "));
        assert!(!help(&standard, "train").contains("own-method"));
        let own = help(&standard.with_method(Named).unwrap(), "train");
        assert!(own.contains("- own-method: a method of a user") && own.contains("- ridge: "), "{own}");
    }

    #[test]
    fn the_arguments_are_consistent_and_every_subcommand_shows_an_example() {
        let mut command = command::described(Arguments::command(), &Registry::standard());
        command.clone().debug_assert();
        for sub in command.get_subcommands_mut() {
            let help = sub.render_long_help().to_string();
            assert!(help.contains("Example") && help.contains("granum "), "{help}");
        }
    }
}
