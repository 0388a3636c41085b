//! What changes seldom, told to a client of the stream when it has changed: the fleet's slow state, safety, control authority, tracks.
//!
//! Must never do: tell the same again.

use super::{Client, End, FLEET_EVERY};
use crate::protocol::{ServerMessage, VehicleSafety};
use crate::view;
use axum::extract::ws::{Message, Utf8Bytes};
use skein_domain::VehicleId;
use skein_domain::control::VehicleControl;
use std::collections::BTreeMap;
use tokio::time::Instant;

/// So many tracks are told each time that the slow state is looked at; where there are more, all of them the more seldom.
const TRACKS_AT_FULL_PACE: usize = 50;

/// The slow state as a client was told it last.
#[derive(Default)]
pub(super) struct Told {
    /// Who has control authority over which vehicles.
    control: Vec<VehicleControl>,
    fleet: Option<Utf8Bytes>,
    /// Of each vehicle.
    safety: BTreeMap<VehicleId, VehicleSafety>,
    /// What is tracked; nothing after an empty list.
    tracks: Option<Utf8Bytes>,
    /// Tracks are not told again before.
    tracks_due: Option<Instant>,
}

impl Client {
    pub(super) async fn send_fleet(&mut self) -> Result<(), End> {
        let newest = self.app.view.fleet(&self.app.node);
        if self.told.fleet.as_ref() == Some(&newest) {
            return Ok(());
        }
        self.told.fleet = Some(newest.clone());
        self.send(Message::Text(newest)).await
    }

    /// Who has control authority over which vehicles, when that has changed.
    pub(super) async fn send_control(&mut self) -> Result<(), End> {
        let newest = self.app.node.control();
        if newest == self.told.control {
            return Ok(());
        }
        self.told.control.clone_from(&newest);
        self.say(&ServerMessage::Control { vehicles: newest }).await
    }

    /// What is tracked, when that has changed. Where answers are late it waits as frames do: the list is whole each time, and its size
    /// is up to whoever tells of tracks.
    pub(super) async fn send_tracks(&mut self) -> Result<(), End> {
        if !self.may_send() || self.told.tracks_due.is_some_and(|due| Instant::now() < due) {
            return Ok(());
        }
        let newest = self.app.view.tracks(&self.app.node);
        let (newest, count) = newest.map_or((None, 0), |(text, count)| (Some(text), count));
        if newest == self.told.tracks {
            return Ok(());
        }
        self.told.tracks.clone_from(&newest);
        let times = count.div_ceil(TRACKS_AT_FULL_PACE).max(1);
        // A tick that comes a little early is not to be missed.
        self.told.tracks_due = Some(Instant::now() + FLEET_EVERY.mul_f64(times as f64 - 0.5));
        let text = newest.unwrap_or_else(|| view::tracks_text(&[], &self.app.node));
        self.send(Message::Text(text)).await
    }

    /// What has changed of the safety of the vehicles.
    pub(super) async fn send_safety(&mut self) -> Result<(), End> {
        let newest = self.app.view.safety(&self.app.node);
        let changed = |safety: &&VehicleSafety| self.told.safety.get(&safety.id) != Some(*safety);
        let vehicles: Vec<VehicleSafety> = newest.iter().filter(changed).cloned().collect();
        if vehicles.is_empty() {
            return Ok(());
        }
        self.told
            .safety
            .extend(vehicles.iter().map(|safety| (safety.id, safety.clone())));
        self.say(&ServerMessage::Safety { vehicles }).await
    }
}
