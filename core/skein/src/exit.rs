//! Exit codes: one meaning each, documented in `skein --help` and the README.

use skein_config::ConfigError;
use skein_node::BuildError;
use skein_runtime::NodeError;
use std::any::Any;
use std::process::ExitCode;

/// Failed, or the demo did not meet its criteria.
pub const FAILED: u8 = 1;
/// The configuration is wrong or a plugin is missing.
pub const CONFIGURATION: u8 = 64;
/// A port or device is not available.
pub const UNAVAILABLE: u8 = 69;
/// Another version is to be started: the service manager starts the program again.
pub const ANOTHER_VERSION: u8 = 75;
/// A fault of the program itself.
pub const INTERNAL: u8 = 70;

/// The exit code for an error, from the typed cause within it.
#[must_use]
pub fn code(error: &anyhow::Error) -> ExitCode {
    for cause in error.chain() {
        if cause.downcast_ref::<ConfigError>().is_some() {
            return ExitCode::from(CONFIGURATION);
        }
        if let Some(build) = cause.downcast_ref::<BuildError>() {
            return ExitCode::from(match build {
                BuildError::Swarm(_) | BuildError::Node(NodeError::Wiring(_)) => CONFIGURATION,
                BuildError::Node(NodeError::Part { .. }) | BuildError::Listen { .. } => UNAVAILABLE,
            });
        }
    }
    ExitCode::from(FAILED)
}

/// Whether what `println!` panicked with is that nobody reads any more, as in `skein log info FILE | head`. The standard library has no other way to tell.
#[must_use]
pub fn is_without_reader(fault: &(dyn Any + Send)) -> bool {
    let told = fault.downcast_ref::<String>();
    told.is_some_and(|told| told.starts_with("failed printing to stdout: Broken pipe"))
}

/// Has a command whose reader is gone end without a word: it has done what was wanted of it. What flies prints by [`skein_node::tell`] and goes on.
pub fn quietly_without_reader() {
    let usual = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |fault| {
        if !is_without_reader(fault.payload()) {
            usual(fault);
        }
    }));
}
