//! Exit codes: one meaning each, documented in `skein --help` and the README.

use skein_config::ConfigError;
use skein_node::BuildError;
use skein_runtime::NodeError;
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
