//! `granum examine`: questions to a data set that teach how to learn from it.

mod components;
mod designs;
mod map;
mod noise;
mod order;
mod paths;
mod question;

use clap::{Args, Subcommand};

use crate::context::Context;
use crate::failure::Failure;

/// Examine data: in which order runs teach most, which design, what noise in the inputs costs, how few numbers hold a distribution or a curve,
/// a map of the states that there are, and how well surrogates follow any path.
#[derive(Args)]
#[command(
    after_help = "Example:\n  granum examine map data/families/sand/drained -o map.svg\n  granum examine order study --unseen judges --runs 24,48,96"
)]
pub struct Examine {
    #[command(subcommand)]
    question: Question,
}

/// Defines the questions and what answers the chosen one.
macro_rules! questions {
    ($($name:ident($arguments:ty)),* $(,)?) => {
        /// The questions with their arguments.
        #[derive(Subcommand)]
        enum Question {
            $($name($arguments)),*
        }

        impl Examine {
            pub fn run(&self, context: &Context) -> Result<(), Failure> {
                match &self.question {
                    $(Question::$name(question) => question.run(context)),*
                }
            }
        }
    };
}

// All questions, in the order of the help. A new one is a file and a line here.
questions! {
    Order(order::OrderFlags),
    Designs(designs::DesignFlags),
    Noise(noise::NoiseFlags),
    Components(components::ComponentFlags),
    Map(map::MapFlags),
    Paths(paths::PathFlags),
}
