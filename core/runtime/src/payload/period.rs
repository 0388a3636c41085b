//! One period of a payload: gather what happened around it, ask its plugin, carry out what it wants.

use super::PayloadState;
use super::tap::Tap;
use skein_coordination::steering::{others, own_state};
use skein_domain::exchange::{Event, PayloadReport};
use skein_domain::link::MessageTap;
use skein_domain::payload::{FrameHeader, PayloadKind};
use skein_plugin_host::Frame;
use std::sync::{Arc, Weak};

impl PayloadState {
    /// The whole period; with a tick at its end if one is due.
    pub(super) async fn period(&mut self, tick: bool) {
        if !self.ensure().await {
            self.record.change_state().transport_fault = self.transport.as_ref().map(|t| t.fault()).unwrap_or_default();
            return;
        }
        let mut events = self.gather();
        let frames = self.gather_frames(&mut events);
        if tick {
            events.push(Event::Tick);
        }
        self.call(events, &frames).await;
        if tick {
            self.life.publish_statistics();
            self.record.change_state().transport_fault = self.transport.as_ref().map(|t| t.fault()).unwrap_or_default();
        }
    }

    /// Surroundings first, then what the device said, then commands and drills.
    fn gather(&mut self) -> Vec<Event> {
        let mut events = Vec::new();
        let peers = self.shared.peers();
        if let Some(entry) = peers.entry(self.vehicle.id) {
            events.push(Event::Own(own_state(entry, self.shared.frame())));
        }
        events.push(Event::Peers(others(&peers, self.vehicle.id)));
        self.gather_siblings(&mut events);
        let tracks = self.shared.observed.tracks();
        if !Arc::ptr_eq(&tracks, &self.tracks) {
            events.push(Event::Tracks(tracks.as_ref().clone()));
            self.tracks = tracks;
        }
        self.gather_device(&mut events);
        events.append(&mut self.waiting);
        events
    }

    fn gather_siblings(&mut self, events: &mut Vec<Event>) {
        for sibling in self.vehicle.payloads() {
            if sibling.name == self.record.name {
                continue;
            }
            let (revision, report) = {
                let published = sibling.state();
                (published.revision, published.report.clone())
            };
            if revision > 0 && self.seen.insert(sibling.name.clone(), revision) != Some(revision) {
                events.push(Event::Payload(PayloadReport {
                    name: sibling.name.clone(),
                    kind: sibling.kind,
                    state_json: report.map(|r| r.json.as_ref().to_owned()),
                }));
            }
        }
    }

    /// A detector sees the newest frame of each camera of its vehicle, once. The bytes stay where the camera wrote them.
    fn gather_frames(&mut self, events: &mut Vec<Event>) -> Vec<Arc<Frame>> {
        if self.record.kind != PayloadKind::Detector {
            return Vec::new();
        }
        let mut frames = Vec::new();
        for camera in self.vehicle.payloads() {
            let Some(frame) = camera.frame() else {
                continue;
            };
            if self.seen_frames.insert(camera.name.clone(), frame.header.id) != Some(frame.header.id) {
                events.push(Event::Frame(FrameHeader {
                    camera: camera.name.clone(),
                    ..frame.header.clone()
                }));
                frames.push(frame);
            }
        }
        frames
    }

    fn gather_device(&mut self, events: &mut Vec<Event>) {
        let link = self.vehicle.link();
        let plugin = self.record.life.plugin();
        let wanted = &plugin.manifest().mavlink_messages;
        let tapped = self
            .tap
            .as_ref()
            .is_some_and(|(tap, of)| tap.wanted() == wanted && Arc::ptr_eq(of, &link));
        if !tapped && !wanted.is_empty() {
            let tap = Arc::new(Tap::new(wanted.clone()));
            let listening: Weak<dyn MessageTap> = Arc::downgrade(&(tap.clone() as Arc<dyn MessageTap>));
            link.tap(listening);
            self.tap = Some((tap, link));
        }
        if let Some((tap, _)) = &self.tap {
            events.extend(tap.drain().into_iter().map(Event::Mavlink));
        }
        if let Some(transport) = &self.transport {
            events.extend(transport.drain().into_iter().map(|bytes| Event::Received { bytes }));
        }
    }
}
