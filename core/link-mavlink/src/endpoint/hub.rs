//! What every kind of endpoint does with bytes: frames to links, new vehicles to the table, ticks to links, counters.
//!
//! Must never do: wait, or hold a lock while it calls the event sink.

use super::EndpointArguments;
use crate::decode::heartbeat;
use crate::event::EndpointEvent;
use crate::frame::{Frame, StreamBuffer, each_in_datagram};
use crate::link::{Px4Link, Received};
use crate::metrics::EndpointCounters;
use crate::outbox::Outbox;
use crate::settings::EndpointSettings;
use crate::sighting::{self, ReferenceSink};
use crate::table::{LinkTable, Slot};
use crate::vehicle::{AUTOPILOT_COMPONENT, cameras, command_long, own_heartbeat};
use mavlink::dialects::common::MavCmd;
use skein_domain::{Clock, NodeTime};
use skein_px4::LinkSettings;
use skein_px4::plan::Command;
use std::net::SocketAddr;
use std::sync::Arc;

/// Ticks are at least this far apart, in seconds.
const TICK_MIN_S: f64 = 0.01;
/// Ticks are at most this far apart, in seconds: a stream that starts between two ticks is guarded from the next on.
const TICK_MAX_S: f64 = 0.1;
/// While nobody is known, a heartbeat is sent this often over a line that leads to one place, in seconds.
const HELLO_S: f64 = 1.0;

/// RADIO_STATUS, and who sends it: the system and component id of every SiK radio, "3D" in its firmware.
const RADIO_STATUS: u32 = 109;
const RADIO: (u8, u8) = (51, 68);

/// The part of an endpoint that all kinds share.
pub struct Hub {
    pub settings: EndpointSettings,
    pub slot: Slot,
    pub counters: EndpointCounters,
    link_settings: Arc<LinkSettings>,
    clock: Arc<dyn Clock>,
    table: Arc<LinkTable>,
    events: super::EventSink,
    references: Option<Arc<dyn ReferenceSink>>,
    /// Links by system id, looked up once.
    known: Vec<Option<Arc<Px4Link>>>,
    /// Links that are ticked here.
    heard: Vec<(u8, Arc<Px4Link>)>,
    next_tick: NodeTime,
    next_hello: NodeTime,
    hello: Outbox,
    /// Whose heartbeat has been asked for, by system id: once each, so that no flood of strangers is answered by one.
    asked: Vec<bool>,
}

impl Hub {
    pub fn new(arguments: EndpointArguments, slot: Slot) -> Self {
        let EndpointArguments {
            settings,
            clock,
            links,
            events,
            references,
        } = arguments;
        let link_settings = Arc::new(settings.link.clone());
        let hello = Outbox::new(link_settings.own_system_id, link_settings.own_component_id);
        let mut hub = Self {
            settings,
            counters: EndpointCounters {
                starts: 1,
                ..EndpointCounters::default()
            },
            link_settings,
            clock,
            table: links,
            events,
            references,
            known: vec![None; 256],
            heard: Vec::new(),
            next_tick: NodeTime::default(),
            next_hello: NodeTime::default(),
            hello,
            asked: vec![false; 256],
            slot,
        };
        for link in hub.table.links_at(hub.slot.number) {
            hub.remember(&link);
        }
        hub.publish();
        hub
    }

    pub fn now(&self) -> NodeTime {
        self.clock.now()
    }

    pub fn report(&self, event: EndpointEvent) {
        (self.events)(event);
    }

    /// One datagram.
    pub fn on_datagram(&mut self, now: NodeTime, bytes: &[u8], from: Option<SocketAddr>) {
        let mut counters = std::mem::take(&mut self.counters);
        counters.datagrams_in += 1;
        counters.bytes_in += bytes.len() as u64;
        each_in_datagram(bytes, &mut counters, |counters, frame| {
            self.on_frame(now, counters, frame, from)
        });
        self.counters = counters;
    }

    /// Bytes of a stream, read into the buffer's space.
    pub fn on_bytes(&mut self, now: NodeTime, buffer: &mut StreamBuffer, count: usize) {
        let mut counters = std::mem::take(&mut self.counters);
        counters.datagrams_in += 1;
        counters.bytes_in += count as u64;
        buffer.advance(count, &mut counters, |counters, frame| {
            self.on_frame(now, counters, frame, None)
        });
        self.counters = counters;
    }

    fn on_frame(
        &mut self,
        now: NodeTime,
        counters: &mut EndpointCounters,
        frame: &Frame<'_>,
        from: Option<SocketAddr>,
    ) {
        if is_radio_status(frame) && self.on_radio_status(frame, from) {
            return;
        }
        let system_id = frame.header.system_id;
        if sighting::is_of_others(frame.header.message_id) {
            self.sight(now, frame);
        }
        let asked = self.ask_cameras(now, frame);
        let Some(Some(link)) = self.known.get(usize::from(system_id)) else {
            if !asked {
                self.on_stranger(now, counters, frame, from);
            }
            return;
        };
        match link.receive(now, self.slot.number, from, frame) {
            Received::Read => {}
            Received::Ignored => counters.ignored += 1,
            Received::Undecodable => counters.undecodable += 1,
            Received::Foreign => {
                counters.foreign += 1;
                // A camera or a second computer of the same vehicle may well sit elsewhere.
                if frame.header.component_id == AUTOPILOT_COMPONENT && frame.known {
                    let clear_s = self.link_settings.duplicate_clear_s;
                    if let Some(event) = self.table.on_foreign(now, system_id, &self.slot, from, clear_s) {
                        let link = Arc::clone(link);
                        self.remember(&link);
                        self.report(event);
                    }
                }
            }
        }
    }

    /// A command may be for a camera that this node speaks for: autopilots pass on what ground stations ask of one. True if it is.
    fn ask_cameras(&self, now: NodeTime, frame: &Frame<'_>) -> bool {
        let target = cameras::asked_system(frame).and_then(|system_id| self.known.get(usize::from(system_id)));
        matches!(target, Some(Some(link)) if link.ask_cameras(now, frame))
    }

    /// A telemetry radio speaks for itself, not as a part of a vehicle: what it says is about every vehicle that is heard
    /// through it. True if somebody wanted it.
    fn on_radio_status(&self, frame: &Frame<'_>, from: Option<SocketAddr>) -> bool {
        self.heard.iter().fold(false, |wanted, (_, link)| {
            link.receive_radio(self.slot.number, from, frame) || wanted
        })
    }

    /// A frame of a system that is not known here: a vehicle, if its autopilot's heartbeat says so.
    fn on_stranger(
        &mut self,
        now: NodeTime,
        counters: &mut EndpointCounters,
        frame: &Frame<'_>,
        from: Option<SocketAddr>,
    ) {
        let header = &frame.header;
        let heartbeat = heartbeat(frame).filter(|heartbeat| {
            header.component_id == AUTOPILOT_COMPONENT
                && header.system_id != 0
                && header.system_id != self.link_settings.own_system_id
                && heartbeat.is_vehicle()
        });
        let Some(heartbeat) = heartbeat else {
            // What a receiver heard of others has been told already.
            let told = sighting::is_of_others(header.message_id);
            if told || header.system_id == self.link_settings.own_system_id || !self.sight(now, frame) {
                counters.unadopted += 1;
            }
            self.ask_heartbeat(frame, from);
            return;
        };
        let (link, event) =
            self.table
                .discover(now, header.system_id, &heartbeat, &self.slot, from, &self.link_settings);
        if let Some(known) = self.known.get_mut(usize::from(header.system_id)) {
            *known = Some(Arc::clone(&link));
        }
        if let Some(event) = event {
            self.remember(&link);
            self.next_tick = now;
            self.report(event);
        }
        // The heartbeat itself, and whether it comes from where this vehicle is heard already.
        self.on_frame(now, counters, frame, from);
    }

    /// An autopilot that speaks before its heartbeat is asked for that: a node that starts again while vehicles fly has no second to lose.
    fn ask_heartbeat(&mut self, frame: &Frame<'_>, from: Option<SocketAddr>) {
        let header = &frame.header;
        let is_other = header.system_id != 0 && header.system_id != self.link_settings.own_system_id;
        if header.component_id != AUTOPILOT_COMPONENT || !frame.known || !is_other {
            return;
        }
        let Some(asked) = self.asked.get_mut(usize::from(header.system_id)) else {
            return;
        };
        if std::mem::replace(asked, true) {
            return;
        }
        // All zero: the number of HEARTBEAT.
        let command = Command::long(MavCmd::MAV_CMD_REQUEST_MESSAGE, [0.0; 7]);
        self.hello
            .push(&command_long(&command, 0, (header.system_id, AUTOPILOT_COMPONENT)));
        self.hello.drain(|frame| {
            self.slot.outlet.send(from, frame);
        });
    }

    /// Tells of somebody's place, if the frame says one. True if it does, and somebody wants to know.
    fn sight(&self, now: NodeTime, frame: &Frame<'_>) -> bool {
        let Some(references) = &self.references else {
            return false;
        };
        let sighting = sighting::read(now, frame);
        let seen = sighting.is_some();
        if let Some(sighting) = sighting {
            references.sighted(sighting);
        }
        seen
    }

    fn remember(&mut self, link: &Arc<Px4Link>) {
        use skein_domain::link::VehicleLink;
        let id = link.system_id().0;
        if let Some(known) = self.known.get_mut(usize::from(id)) {
            *known = Some(Arc::clone(link));
        }
        if !self.heard.iter().any(|(other, _)| *other == id) {
            self.heard.push((id, Arc::clone(link)));
        }
    }

    /// Adds what was counted to the endpoint's metrics; once per wake-up.
    pub fn publish(&mut self) {
        self.slot.metrics.add(&std::mem::take(&mut self.counters));
    }

    /// Ticks the links if it is time; gives when it is time again.
    pub fn tick(&mut self, now: NodeTime) -> NodeTime {
        if now < self.next_tick {
            return self.next_tick;
        }
        let mut due = now.plus_seconds(TICK_MAX_S);
        let mut events = Vec::new();
        let (table, number, clear_s) = (&self.table, self.slot.number, self.link_settings.duplicate_clear_s);
        self.heard.retain(|(system_id, link)| {
            // One that has moved to another endpoint is ticked there.
            let Some(ticked) = link.tick(now, number) else {
                return false;
            };
            due = due.min(ticked.due);
            events.extend(table.on_ticked(now, link, *system_id, &ticked, clear_s));
            true
        });
        for event in events {
            self.report(event);
        }
        self.next_tick = due.max(now.plus_seconds(TICK_MIN_S));
        self.next_tick
    }

    /// A heartbeat over a line that leads to one place only: whoever is there may wait for one before it speaks.
    pub fn hello(&mut self, now: NodeTime) {
        if self.heard.is_empty() && now >= self.next_hello {
            self.next_hello = now.plus_seconds(HELLO_S);
            self.hello.push(&own_heartbeat());
            self.hello.drain(|frame| {
                self.slot.outlet.send(None, frame);
            });
        }
    }
}

fn is_radio_status(frame: &Frame<'_>) -> bool {
    let header = &frame.header;
    header.message_id == RADIO_STATUS && (header.system_id, header.component_id) == RADIO
}

impl Drop for Hub {
    fn drop(&mut self) {
        self.slot.metrics.add(&self.counters);
    }
}
