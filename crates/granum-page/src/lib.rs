//! The page of granum, and its server: what is in a folder, shown in a browser on the same computer.
//!
//! [`Server::bind`] opens a port of this computer, and [`Server::run`] answers until it is told to stop. What a folder holds is found by
//! [`listing`], what may be read by [`folder`], who may ask by [`guard`]. The program that serves gives what it knows by name and its reports
//! ([`Program`]). Nothing is ever written, and nothing that a file holds is executed: the page shows text as text and figures as pictures.

mod answer;
mod assets;
mod commands;
mod documents;
pub mod folder;
pub mod guard;
mod limits;
pub mod listing;
mod numbers;
mod program;
mod query;
mod refused;
mod routes;
mod serve_error;
mod server;
mod site;
mod token;

pub use limits::Limits;
pub use program::{Next, Program, Report, TestProperty};
pub use serve_error::ServeError;
pub use server::Server;
