//! The granum program.

// Both can be lost, and these macros would panic: messages go through `messages`, the output of a command through `output`.
#![deny(clippy::print_stderr, clippy::print_stdout)]

mod command;
mod context;
mod failure;
mod interrupt;
mod messages;
mod numbers;
mod output;
mod progress;
mod surrogate_methods;
mod unwritten;

use std::process::ExitCode;

use clap::Parser;

use command::Command;
use context::Context;
use failure::Failure;

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

fn main() -> ExitCode {
    quiet_contained_panics();
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) => return refuse(&error),
    };
    let (stop, warnings) = interrupt::install();
    let context = Context::new(arguments.json, arguments.force, arguments.verbose, stop)
        .allowing_outside(arguments.allow_outside);
    warnings.iter().for_each(|warning| context.warn(warning));
    match arguments.command.run(&context) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.print(context.json, &context.warnings()),
    }
}

/// Prints the help, or the error of an invalid command line.
fn refuse(error: &clap::Error) -> ExitCode {
    let json = std::env::args_os().skip(1).take_while(|word| word != "--").any(|word| word == "--json");
    if !error.use_stderr() {
        return output::written(error.print())
            .map_or_else(|failure| failure.print(json, &[]), |()| ExitCode::SUCCESS);
    }
    if json {
        Failure::print_usage_as_json(error);
    } else {
        // Its loss changes nothing about the exit status.
        let _ = error.print();
    }
    ExitCode::from(USAGE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_arguments_are_consistent_and_every_subcommand_shows_an_example() {
        let mut command = Arguments::command();
        command.clone().debug_assert();
        for sub in command.get_subcommands_mut() {
            let help = sub.render_long_help().to_string();
            assert!(help.contains("Example") && help.contains("granum "), "{help}");
        }
    }
}
