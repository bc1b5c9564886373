//! Files that granum reads and writes, one source file for each format.
//!
//! Whatever a file contains, reading it ends with a value or with an [`Error`] that gives the file, the position and what
//! would be right. A file is written under a temporary name in the same folder and then renamed, so that no reader sees an
//! incomplete file.

mod aside;
pub mod atomic;
pub mod case;
mod contain;
mod error;
pub mod figure_list;
mod folder;
mod format;
pub mod formats;
pub mod laboratory_curves;
mod material_name;
mod named_file;
pub mod packing;
mod presence;
mod recordable;
pub mod run;
pub mod safe_text;
pub mod sealed;
pub mod sheet;
pub mod shell;
pub mod snapshot;
mod text;
mod windows_names;

pub use case::{Case, Reading};
pub use contain::is_contained;
pub use error::{Error, InputError, Result};
pub use folder::{OutputFolder, check_name, check_new_file, check_output_file, inner_folder, process};
pub use formats::{
    Formats, read_columns, read_packing, read_table, read_table_with_words, write_packing, write_table,
};
pub use granum_core::{Column, ColumnKind, Table};
pub use laboratory_curves::{Conventions, DeviatorMeasure, LaboratoryDoubt, LaboratoryTest, read_laboratory};
pub use named_file::named_file;
pub use packing::Packing;
pub use presence::is_there;
pub use recordable::{moved_with, path_from, path_in, recordable};
pub use run::{Machine, QualityFlag, Run, RunFolder, RunKind, RunRecord, RunSource, RunStatus};
