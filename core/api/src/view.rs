//! What all streams share: the newest frame and the newest slow state, each made once for all clients.
//!
//! Must never do: hold its lock across an await, or keep more than the newest.

use crate::protocol::{FleetInfo, PayloadInfo, ServerMessage, TrackList, VehicleInfo, VehicleSafety};
use crate::{safety_view, wire};
use axum::body::Bytes;
use axum::extract::ws::Utf8Bytes;
use parking_lot::Mutex;
use skein_domain::NodeTime;
use skein_domain::payload::TrackEstimate;
use skein_runtime::NodeHandle;
use skein_view::FleetSnapshot;
use skein_view::PayloadSnapshot;
use std::sync::Arc;

/// A frame is made anew from the same snapshot after so long, so that its ages are right.
const FRAME_GOOD_FOR_S: f64 = 0.02;

/// The newest frame and slow state.
#[derive(Debug, Default)]
pub struct View {
    frame: Mutex<Option<Frame>>,
    fleet: Mutex<Option<Fleet>>,
    safety: Mutex<Option<(u64, Arc<Vec<VehicleSafety>>)>>,
    tracks: Mutex<Tracks>,
}

#[derive(Debug)]
struct Frame {
    sequence: u64,
    made: NodeTime,
    bytes: Bytes,
}

#[derive(Debug)]
struct Fleet {
    sequence: u64,
    text: Utf8Bytes,
}

/// What is tracked. As long as nothing of it has changed `text` is the same.
#[derive(Debug, Default)]
struct Tracks {
    sequence: u64,
    tracks: Vec<TrackEstimate>,
    text: Utf8Bytes,
}

impl View {
    /// The newest binary frame.
    pub fn frame(&self, node: &NodeHandle) -> Bytes {
        let (snapshot, now) = (node.snapshot(), node.now());
        let mut kept = self.frame.lock();
        if let Some(frame) = kept.as_ref()
            && frame.sequence == snapshot.sequence
            && now.seconds_since(frame.made) < FRAME_GOOD_FOR_S
        {
            return frame.bytes.clone();
        }
        let bytes = Bytes::from(wire::encode(&snapshot, now));
        *kept = Some(Frame {
            sequence: snapshot.sequence,
            made: now,
            bytes: bytes.clone(),
        });
        bytes
    }

    /// The newest slow state as the stream's message. As long as nothing has changed it is the same text.
    pub fn fleet(&self, node: &NodeHandle) -> Utf8Bytes {
        let snapshot = node.snapshot();
        let mut kept = self.fleet.lock();
        if let Some(fleet) = kept.as_ref()
            && fleet.sequence == snapshot.sequence
        {
            return fleet.text.clone();
        }
        let text = text(&ServerMessage::Fleet(Box::new(fleet_info(&snapshot, node))));
        *kept = Some(Fleet {
            sequence: snapshot.sequence,
            text: text.clone(),
        });
        text
    }
}

impl View {
    /// The newest safety of all vehicles.
    pub fn safety(&self, node: &NodeHandle) -> Arc<Vec<VehicleSafety>> {
        let snapshot = node.snapshot();
        let mut kept = self.safety.lock();
        if let Some((sequence, safety)) = kept.as_ref()
            && *sequence == snapshot.sequence
        {
            return safety.clone();
        }
        let safety = Arc::new(safety_view::of(&snapshot));
        *kept = Some((snapshot.sequence, safety.clone()));
        safety
    }
}

impl View {
    /// What is tracked, as the stream's message, and how many tracks that are; nothing while there are none.
    pub fn tracks(&self, node: &NodeHandle) -> Option<(Utf8Bytes, usize)> {
        let snapshot = node.snapshot();
        let mut kept = self.tracks.lock();
        if kept.sequence != snapshot.sequence {
            kept.sequence = snapshot.sequence;
            if kept.tracks != snapshot.tracks {
                kept.tracks.clone_from(&snapshot.tracks);
                kept.text = tracks_text(&snapshot.tracks, node);
            }
        }
        (!kept.tracks.is_empty()).then(|| (kept.text.clone(), kept.tracks.len()))
    }
}

/// The stream's message of these tracks.
pub fn tracks_text(tracks: &[TrackEstimate], node: &NodeHandle) -> Utf8Bytes {
    text(&ServerMessage::Tracks(TrackList {
        time: node.now(),
        tracks: tracks.to_vec(),
    }))
}

/// A message as it goes over the wire.
#[must_use]
pub fn text(message: &ServerMessage) -> Utf8Bytes {
    // Our own types have no maps with other keys than strings, so that this cannot fail.
    serde_json::to_string(message).unwrap_or_default().into()
}

fn payload_info(payload: &PayloadSnapshot) -> PayloadInfo {
    PayloadInfo {
        name: payload.name.clone(),
        kind: payload.kind,
        plugin: payload.plugin.plugin.clone(),
        version: payload.plugin.version.clone(),
        isolation: payload.plugin.isolation,
        health: payload.plugin.as_actor(),
        restarts: payload.plugin.restarts,
        has_frame: payload.frame.is_some(),
    }
}

/// What is not in the binary frame.
fn fleet_info(snapshot: &FleetSnapshot, node: &NodeHandle) -> FleetInfo {
    let vehicle = |vehicle: &skein_view::VehicleSnapshot| VehicleInfo {
        id: vehicle.id,
        node: vehicle.node,
        name: vehicle.name.clone(),
        simulated: vehicle.simulated,
        system_id: vehicle.system_id,
        plugin: vehicle.plugin.clone(),
        plugin_version: vehicle.plugin_version.clone(),
        state_detail: vehicle.state_detail.clone(),
        home: vehicle.home,
        actor: vehicle.actor.clone(),
        model: vehicle.model.as_actor(),
        payloads: vehicle.payloads.iter().map(payload_info).collect(),
        degraded: vehicle.degraded.clone(),
    };
    FleetInfo {
        frame: snapshot.frame,
        vehicles: snapshot.vehicles.iter().map(vehicle).collect(),
        unadopted: snapshot.unadopted.clone(),
        formation: snapshot.formation.clone(),
        actors: snapshot.actors.clone(),
        faults_enabled: node.config().faults.enabled,
        dead_man: safety_view::dead_man(node),
        resume: snapshot.resume.clone(),
        recorder: node.recorder().as_ref().clone(),
    }
}
