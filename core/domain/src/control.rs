//! The words of control: which operator's console commands which vehicles, and who asks for them. The rules are `skein-safety`'s.
//!
//! Must never do: decide who may command.

use crate::{NodeTime, VehicleId};
use serde::{Deserialize, Serialize};

/// Longest id and longest name of a console, in bytes.
pub const LONGEST_CONSOLE_TEXT: usize = 64;

/// One place from which vehicles are commanded: a page in a browser, a program.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
#[derive(Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Console {
    /// Tells it from all others; drawn by the console itself.
    pub id: String,
    /// What people call who sits there.
    pub name: String,
}

impl Console {
    /// Whether it can be told from others, and shown.
    #[must_use]
    pub fn is_sound(&self) -> bool {
        let sound = |text: &str| {
            !text.trim().is_empty() && text.len() <= LONGEST_CONSOLE_TEXT && !text.chars().any(char::is_control)
        };
        sound(&self.id) && sound(&self.name)
    }
}

/// A console that asks for a vehicle which another one has.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
pub struct ControlRequest {
    /// Who asks.
    pub console: Console,
    /// Since when.
    pub since: NodeTime,
}

/// Who has control authority over a vehicle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
pub struct VehicleControl {
    /// The vehicle.
    pub vehicle: VehicleId,
    /// Who has it.
    pub console: Console,
    /// Since when.
    pub since: NodeTime,
    /// That console is heard. If not, anybody may relieve it.
    pub is_heard: bool,
    /// Who asks for it, the first first.
    pub requests: Vec<ControlRequest>,
}
