//! Refuses interpreters without Python's lock before anything is compiled for them: granum has not been tested with one.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    if pyo3_build_config::get().is_free_threaded() {
        println!(
            "cargo::error=granum does not support free-threaded builds of CPython: it has not been tested with one; build it for the usual \
             CPython of the same version (python3.14, not python3.14t)"
        );
    }
}
