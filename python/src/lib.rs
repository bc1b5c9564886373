//! The extension module `granum._granum`: the library of granum for Python. It holds no rules of its own; `python/granum/` makes the package
//! of it, whose documentation is in its stubs.

mod arrays;
mod arrow;
mod assembly;
mod campaign;
mod case;
mod case_text;
mod comparison;
mod dataset;
mod detached;
mod errors;
mod families;
mod files;
mod material_point;
mod measuring;
mod mistake;
mod observed;
mod pair;
mod pair_law;
mod place;
mod program;
mod quantity;
mod recorder;
mod report;
mod results;
mod run;
mod running;
mod sensor;
mod simulation;
mod surrogate;
mod table;
mod values;
mod view;
mod watch;

use pyo3::prelude::*;

/// The module.
#[pymodule(name = "_granum")]
mod module {
    use super::*;

    #[pymodule_export]
    use crate::arrays::Values;
    #[pymodule_export]
    use crate::assembly::Assembly;
    #[pymodule_export]
    use crate::campaign::CampaignFolder;
    #[pymodule_export]
    use crate::case::{Case, paths, schema, template};
    #[pymodule_export]
    use crate::comparison::{Comparison, laboratory};
    #[pymodule_export]
    use crate::dataset::Dataset;
    #[pymodule_export]
    use crate::detached::{entered, forked};
    #[pymodule_export]
    use crate::families::{Family, families};
    #[pymodule_export]
    use crate::files::{read, write, write_grainlearning};
    #[pymodule_export]
    use crate::material_point::{MaterialPoint, PointState};
    #[pymodule_export]
    use crate::measuring::measure;
    #[pymodule_export]
    use crate::mistake::mistake;
    #[pymodule_export]
    use crate::pair::pair;
    #[pymodule_export]
    use crate::program::program;
    #[pymodule_export]
    use crate::recorder::Recorder;
    #[pymodule_export]
    use crate::run::Run;
    #[pymodule_export]
    use crate::running::{open_run, prepare, resume, run_case};
    #[pymodule_export]
    use crate::simulation::Simulation;
    #[pymodule_export]
    use crate::surrogate::{Surrogate, fit, methods};
    #[pymodule_export]
    use crate::table::Table;
    #[pymodule_export]
    use crate::view::{view_colours, view_page};

    /// The messages of panics that granum turns into errors are not printed; the hook is that of this module alone.
    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        std::panic::set_hook(Box::new(detached::note_panic));
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
