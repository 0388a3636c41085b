//! Logs that the autopilots of this node's vehicles keep by themselves.
//!
//! Must never do: ask for one of a vehicle whose motors are armed: its line is for flying then.

use super::NodeHandle;
use skein_domain::{AutopilotLog, LogFetch, LogFetchEnd, Refusal, VehicleId};
use skein_link_mavlink::logs::Logs;
use std::collections::BTreeMap;

impl NodeHandle {
    /// A way to the logs of a vehicle that stands on the ground.
    ///
    /// # Errors
    /// When there is no such vehicle, or it is armed.
    pub fn logs_of(&self, vehicle: VehicleId) -> Result<Logs, Refusal> {
        let link = self.shared.vehicles.known(vehicle)?.link().clone();
        self.check_log_may_be_fetched(vehicle)?;
        Ok(Logs::of(link, self.shared.clock.clone()))
    }

    /// Whether a vehicle's line is free for its log.
    ///
    /// # Errors
    /// When it is armed.
    pub fn check_log_may_be_fetched(&self, vehicle: VehicleId) -> Result<(), Refusal> {
        let peers = self.shared.peers();
        let armed = peers.entry(vehicle).is_some_and(|entry| entry.telemetry.armed);
        if armed {
            return Err(Refusal::not_permitted(
                "it is armed: logs are listed and fetched on the ground alone",
            ));
        }
        Ok(())
    }

    /// What is fetched, and was last, by vehicle.
    #[must_use]
    pub fn log_fetches(&self) -> BTreeMap<VehicleId, LogFetch> {
        self.shared.log_fetches.lock().clone()
    }

    /// A vehicle's log begins to be fetched.
    ///
    /// # Errors
    /// When another one of it is.
    pub fn begin_log_fetch(&self, vehicle: VehicleId, log: AutopilotLog) -> Result<LogFetch, Refusal> {
        let mut fetches = self.shared.log_fetches.lock();
        if fetches.get(&vehicle).is_some_and(|fetch| fetch.end.is_none()) {
            return Err(Refusal::not_permitted("a log of it is being fetched"));
        }
        let fetch = LogFetch {
            log,
            received_bytes: 0,
            end: None,
        };
        fetches.insert(vehicle, fetch.clone());
        Ok(fetch)
    }

    /// How far it has come, and how it ended.
    pub fn note_log_fetch(&self, vehicle: VehicleId, more_bytes: usize, end: Option<LogFetchEnd>) {
        if let Some(fetch) = self.shared.log_fetches.lock().get_mut(&vehicle) {
            let more_bytes = u32::try_from(more_bytes).unwrap_or(u32::MAX);
            fetch.received_bytes = fetch.received_bytes.saturating_add(more_bytes);
            fetch.end = end.or(fetch.end.take());
        }
    }
}
