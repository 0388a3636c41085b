//! Why a bench could not be run.

use std::path::PathBuf;
use thiserror::Error;

/// Why a bench could not be run.
#[derive(Debug, Error)]
pub enum BenchError {
    /// Settings that a part of the bench was given do not parse.
    #[error("the settings do not parse: {0}")]
    Settings(serde_json::Error),
    /// A number of vehicles, or another argument, that makes no sense.
    #[error("{0}")]
    Argument(String),
    /// A system call failed.
    #[error("{what}: {source}")]
    System {
        /// What was tried.
        what: &'static str,
        /// Why it failed.
        source: std::io::Error,
    },
    /// A child process could not be started.
    #[error("cannot start {program}: {source}")]
    Start {
        /// Which program.
        program: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A child process ended, or said something else than it should.
    #[error("the {part}: {detail}")]
    Child {
        /// Which part of the bench.
        part: &'static str,
        /// What it did.
        detail: String,
    },
    /// The program measured did not do what the bench needs.
    #[error("the program under test: {0}")]
    Program(String),
    /// Its API could not be reached.
    #[error("the API of the program under test: {0}")]
    Api(#[from] hyper::Error),
}

impl BenchError {
    /// For `map_err`: names the call that failed.
    pub(crate) fn system<E: Into<std::io::Error>>(what: &'static str) -> impl FnOnce(E) -> Self {
        move |source| Self::System {
            what,
            source: source.into(),
        }
    }
}
