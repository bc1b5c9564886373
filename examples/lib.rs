//! Complete programs that use granum as a library, one file each: `cargo run --release -p granum-examples --example NAME`.
//! The tests of this crate run all of them.
