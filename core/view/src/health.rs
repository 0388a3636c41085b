//! How the supervised actors and plugin instances of a node fare.
//!
//! Must never do: supervise.

use serde::{Deserialize, Serialize};
use skein_config::Isolation;
use skein_domain::{Incarnation, NodeTime};

/// A plugin instance under supervision.
#[derive(Debug, Clone, PartialEq, Default)]
#[derive(Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
pub struct PluginHealth {
    /// Name in the supervision tree, for example `model-3` or `payload-3-gimbal`.
    pub name: String,
    /// The plugin.
    pub plugin: String,
    /// Its version.
    pub version: String,
    /// Where it runs.
    pub isolation: Isolation,
    /// Its process, if it has one of its own.
    pub process_id: Option<u32>,
    /// Running, restarting after back-off, or given up.
    pub status: ActorStatus,
    /// How many times it was started.
    pub incarnation: Incarnation,
    /// How many of its starts followed a failure.
    pub restarts: u64,
    /// The last error that ended it; empty if none did.
    pub last_error: String,
    /// Since when it has this status.
    pub since: NodeTime,
    /// Calls of this incarnation.
    pub calls: u64,
    /// Half of them were no slower, in microseconds.
    pub call_p50_us: f64,
    /// All but one in a hundred were no slower, in microseconds.
    pub call_p99_us: f64,
}

impl PluginHealth {
    /// The part of it that every supervised thing has.
    #[must_use]
    pub fn as_actor(&self) -> ActorHealth {
        ActorHealth {
            name: self.name.clone(),
            status: self.status,
            incarnation: self.incarnation,
            last_error: self.last_error.clone(),
            since: self.since,
        }
    }
}

/// Whether a restarted instance has the state of the one before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Restored {
    /// There was none to restore.
    Fresh,
    /// Its first snapshot is byte for byte the one it was made from.
    Exactly,
    /// Its first snapshot is another.
    Differently,
}

/// One restart of a plugin instance after a failure.
#[derive(Debug, Clone, PartialEq, Serialize, ts_rs::TS, schemars::JsonSchema)]
pub struct RestartRecord {
    /// When it ran again.
    pub time: NodeTime,
    /// Its name in the supervision tree.
    pub name: String,
    /// Where it runs.
    pub isolation: Isolation,
    /// From the failure, or the end of the back-off, until it had its state again, in seconds.
    pub took_s: f64,
    /// The deliberate wait before, in seconds.
    pub backoff_s: f64,
    /// Whether it has the state of the one before it.
    pub restored: Restored,
}

/// A supervised actor or plugin instance.
#[derive(Debug, Clone, PartialEq, Default)]
#[derive(Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
pub struct ActorHealth {
    /// Name in the supervision tree, for example `vehicle-3`.
    pub name: String,
    /// Running, restarting after back-off, or given up.
    pub status: ActorStatus,
    /// How many times it was started.
    pub incarnation: Incarnation,
    /// The last error that ended it; empty if none did.
    pub last_error: String,
    /// Since when it has this status.
    pub since: NodeTime,
}

/// What a supervised actor is doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[derive(Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ActorStatus {
    /// Running.
    #[default]
    Running,
    /// Ended by a failure, starts again after its back-off.
    Restarting,
    /// Failed too often; an operator must look.
    GivenUp,
}
