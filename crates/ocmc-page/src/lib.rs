//! `ocmc page`: a page to ask with, served on the loopback.
//!
//! The browser gets the `assets` and sends the questions of [`ocmc_api::ask`]; `http` is the
//! little of HTTP that this needs, `guard` says whom it is answered, and `session` holds the
//! files that a person drops, in a folder that goes with the server.

mod assets;
mod guard;
mod http;
mod server;
mod session;

pub use server::{Page, PageError};
