//! The module with the laboratory: cases and their tests.

granum_browser::export!(granum_browser::ENGINE, takes files: false);
