//! The subcommands, one file each.

mod bench;
mod calibrate;
mod campaign;
mod campaign_report;
mod case_flags;
mod checkpoints;
mod chosen_model;
mod comparability;
mod compare;
mod compare_strength;
mod digest;
mod engine_flags;
mod evaluate;
mod evaluate_study;
mod examine;
mod export;
mod export_data_set;
mod export_deck;
mod export_onnx;
mod family_answer;
mod family_card;
mod family_chart;
mod family_check;
mod family_flags;
mod family_rows;
mod family_several;
mod forces;
mod foreseen;
mod hardware;
mod impact;
mod init;
mod known_numbers;
mod laboratory_flags;
mod law;
mod limits;
mod measure;
mod pair;
mod predict;
mod predict_family;
mod predict_surrogate;
mod prediction_input;
mod prediction_words;
mod prepare;
mod records;
mod relation;
mod report;
mod reproduce;
mod resume;
mod run;
mod run_folders;
mod run_report;
mod schema;
mod scores;
mod serve;
mod several_runs;
mod shape;
mod shape_quantities;
mod shear;
mod show_queue;
mod show_steps;
mod show_training;
mod single_run;
mod sources;
mod spread;
mod status;
mod stiffness;
mod stream;
mod stream_line;
mod strength_text;
mod stresses;
mod study_folder;
mod study_scores;
mod summary_file;
mod table;
mod test_run;
mod text_table;
mod train;
mod train_family;
mod train_study;
mod trained_range;
mod view;
mod whole;
mod worth;
mod worth_text;

use clap::Subcommand;

use crate::context::Context;
use crate::failure::Failure;
use crate::registry::Registry;

/// Defines the enumeration of the subcommands and what runs the chosen one.
macro_rules! commands {
    ($($name:ident($arguments:ty)),* $(,)?) => {
        /// The subcommands with their arguments.
        #[derive(Subcommand)]
        pub enum Command {
            $($name($arguments)),*
        }

        impl Command {
            pub fn run(&self, context: &Context) -> Result<(), Failure> {
                match self {
                    $(Command::$name(command) => command.run(context)),*
                }
            }
        }
    };
}

// All subcommands, in the order of the help. A new one is a file and a line here.
commands! {
    Init(init::Init),
    Schema(schema::Schema),
    Prepare(prepare::Prepare),
    Shear(shear::Shear),
    Run(run::Run),
    Campaign(campaign::Campaign),
    Limits(limits::Limits),
    Shape(shape::DescribeShape),
    Table(table::Table),
    Compare(compare::Compare),
    Calibrate(calibrate::Calibrate),
    Resume(resume::Resume),
    Status(status::Status),
    Digest(digest::Digest),
    Report(report::Report),
    Train(train::Train),
    Predict(predict::Predict),
    Stream(stream::Stream),
    Evaluate(evaluate::Evaluate),
    Worth(worth::MeasureWorth),
    Examine(examine::Examine),
    Measure(measure::Measure),
    Stiffness(stiffness::MeasureStiffness),
    Export(export::Export),
    View(view::ViewGrains),
    Serve(serve::Serve),
    Forces(forces::Forces),
    Pair(pair::Pair),
    Impact(impact::Impact),
    Reproduce(reproduce::Reproduce),
    Bench(bench::Bench),
}

/// The same command line, with help texts that list what a registry holds.
pub fn described(mut line: clap::Command, registry: &Registry) -> clap::Command {
    let laws = registry.runs.vocabulary.laws();
    for name in ["forces", "pair", "impact"] {
        line = line.mut_subcommand(name, |command| law::described(command, laws));
    }
    line.mut_subcommand("train", |command| train_study::described(command, &registry.methods))
        .mut_subcommand("campaign", |command| campaign::described(command, &registry.schedulers))
}
