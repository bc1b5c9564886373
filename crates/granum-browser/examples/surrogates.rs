//! The module with the surrogates, and with the reports of tests.

granum_browser::export!(granum_browser::SURROGATES, takes files: true);
