//! What this node tells the others, and how often: its beacon, its vehicles, what screens show of them, its orders while it coordinates,
//! what operators told it, what happened.
//!
//! Must never do: tell of a vehicle that another node flies.

use super::SwarmState;
use super::messages::NodeMessage;
use crate::operator_state::{FencesTold, OperatorState};
use crate::orders::Orders;
use crate::parts::{MOST_PARTS, pack, split};
use skein_domain::{Intent, LinkHealth, NodeId, NodeTime, VehicleId};
use skein_failover::Term;
use skein_state::cluster::report::{Batch, Card, Kind, VehicleReport, key, origin_of};
use skein_state::picture;
use skein_state::{SharedState, VehicleRecord};
use skein_view::NodeRole;
use skein_view::{EventKind, EventRecord, VehicleSnapshot};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Time between two beacons, in seconds.
const BEACON_S: f64 = 0.1;
/// Time between two reports of vehicles in the air, in seconds, and of those that stand.
const FLYING_S: f64 = 0.05;
const STANDING_S: f64 = 0.25;
/// Time between two looks at what screens show, what operators told and what a successor needs, in seconds.
const SHEETS_S: f64 = 1.0;
const OPERATOR_STATE_S: f64 = 0.1;
/// Vehicles in one report: as many as fit into a datagram.
const PER_BATCH: usize = 10;
/// What a part of a value has beside its bytes, at most.
pub(super) const PART_BYTES: usize = 48;
/// Time between two letters with events, in seconds, and how many events one has.
const EVENTS_S: f64 = 0.25;
const EVENTS_MOST: usize = 16;

/// What was told, and when it is time again.
#[derive(Debug, Default)]
pub struct OutboundState {
    next_beacon: NodeTime,
    next_vehicles: NodeTime,
    next_sheets: NodeTime,
    next_operator_state: NodeTime,
    next_events: NodeTime,
    /// Grows with every value of several parts.
    revision: u64,
    card: Option<Card>,
    sheets: BTreeMap<VehicleId, Vec<u8>>,
    parts: BTreeMap<(Kind, u16), u8>,
    batches: u16,
    intent: Option<Arc<Intent>>,
    orders: Option<Orders>,
    operator_state: OperatorState,
    fence_revision: u64,
    /// The term obeyed when the last beacon was made.
    beaconed: Option<Term>,
    /// The last term whose orders were taken up.
    taken_up: Option<Term>,
    /// When the leadership may be offered again, and the picture is due.
    pub(super) next_offer: NodeTime,
    pub(super) next_picture: NodeTime,
    other_frames: BTreeSet<NodeId>,
}

impl OutboundState {
    /// A node has joined: what it needs first is told again.
    pub fn tell_anew(&mut self) {
        self.card = None;
        self.next_beacon = NodeTime::default();
    }

    /// A value of several parts is told no more: how many parts it had.
    pub fn forget_parts(&mut self, kind: Kind) -> u8 {
        self.parts.remove(&(kind, 0)).unwrap_or(0)
    }

    /// Orders of this term were taken up; whether they are the first ones.
    pub fn taken_up(&mut self, term: Term) -> bool {
        self.taken_up.replace(term) != Some(term)
    }

    /// Orders of a node with another frame: whether that is news.
    pub fn first_other_frame(&mut self, node: NodeId) -> bool {
        self.other_frames.insert(node)
    }
}

impl SwarmState {
    /// Tells what is due.
    pub(super) fn tell(&mut self, now: NodeTime) {
        if now >= self.told.next_beacon || self.told.beaconed != self.leadership.obeyed() {
            self.told.beaconed = self.leadership.obeyed();
            self.told.next_beacon = now.plus_seconds(BEACON_S);
            let beacon = self.monitor.beacon(now, self.leadership.node(), &self.leadership);
            self.value(now, Kind::Beacon, 0, minicbor::to_vec(beacon));
            self.tell_card(now);
        }
        if now >= self.told.next_vehicles {
            let flies = self.tell_vehicles(now);
            self.told.next_vehicles = now.plus_seconds(if flies { FLYING_S } else { STANDING_S });
        }
        if now >= self.told.next_sheets {
            self.told.next_sheets = now.plus_seconds(SHEETS_S);
            self.tell_sheets(now);
        }
        self.tell_orders(now);
        if now >= self.told.next_operator_state {
            self.told.next_operator_state = now.plus_seconds(OPERATOR_STATE_S);
            self.tell_operator_state(now);
        }
        self.tell_tracking(now);
        if now >= self.told.next_events {
            self.told.next_events = now.plus_seconds(EVENTS_S);
            self.tell_events(now);
        }
    }

    fn value<E>(&mut self, now: NodeTime, kind: Kind, item: u16, bytes: Result<Vec<u8>, E>) {
        if let Ok(bytes) = bytes {
            // Values that do not fit are made in parts; that they are too many is told where they are made.
            let _ = self.bus.tell(now, key(kind, item, 0), bytes);
        }
    }

    /// Tells a value in as many parts as it needs. Whether it fits.
    pub(super) fn tell_parts(&mut self, now: NodeTime, kind: Kind, item: u16, packed: &[u8]) -> bool {
        self.told.revision += 1;
        let bytes = self.bus.body_bytes().saturating_sub(PART_BYTES);
        let Ok(parts) = split(packed, self.told.revision, bytes) else {
            return false;
        };
        let count = parts.len() as u8;
        for part in parts {
            let index = part.index;
            if let Ok(bytes) = minicbor::to_vec(part) {
                let _ = self.bus.tell(now, key(kind, item, index), bytes);
            }
        }
        let before = self.told.parts.insert((kind, item), count).unwrap_or(0);
        for index in count..before {
            self.bus.tell_no_more(key(kind, item, index));
        }
        true
    }

    fn tell_card(&mut self, now: NodeTime) {
        let records = self.shared.vehicles.records();
        let card = Card {
            name: self.shared.config.node.name.clone(),
            roles: NodeRole::to_bits(&roles(&self.shared)),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            vehicles: records.iter().map(|record| record.id).take(256).collect(),
            origin: origin_of(self.shared.frame()),
        };
        if self.told.card.as_ref() != Some(&card) {
            self.value(now, Kind::Card, 0, minicbor::to_vec(&card));
            self.told.card = Some(card);
        }
    }

    /// Tells where its vehicles are; whether one flies.
    fn tell_vehicles(&mut self, now: NodeTime) -> bool {
        let peers = self.shared.peers();
        let withdrawn = self.shared.vehicles.withdrawn();
        let report = |record: &Arc<VehicleRecord>| {
            let entry = peers.entry(record.id)?;
            Some(VehicleReport::of(record, entry, withdrawn.contains(&record.id), now))
        };
        let reports: Vec<VehicleReport> = self.shared.vehicles.records().iter().filter_map(report).collect();
        let flies = reports.iter().any(|r| r.has(skein_state::cluster::report::ARMED));
        let mut count = 0;
        for chunk in reports.chunks(PER_BATCH) {
            let batch = Batch {
                told: now,
                reports: chunk.to_vec(),
            };
            self.value(now, Kind::Vehicles, count, minicbor::to_vec(batch));
            count += 1;
        }
        for index in count..self.told.batches {
            self.bus.tell_no_more(key(Kind::Vehicles, index, 0));
        }
        self.told.batches = count;
        flies
    }

    /// Tells what screens show of its vehicles, where that has changed.
    fn tell_sheets(&mut self, now: NodeTime) {
        let peers = self.shared.peers();
        for record in self.shared.vehicles.records() {
            let Some(sheet) = picture::vehicle(&self.shared, &record, &peers, None, now) else {
                continue;
            };
            let Ok(packed) = pack(&without_motion(sheet)) else {
                continue;
            };
            if self.told.sheets.get(&record.id) != Some(&packed)
                && self.tell_parts(now, Kind::Sheet, record.id.0, &packed)
            {
                self.told.sheets.insert(record.id, packed);
            }
        }
    }

    /// While it coordinates: its orders, at once when the intent has changed.
    fn tell_orders(&mut self, now: NodeTime) {
        let Some(term) = self.leadership.acting() else {
            if self.told.orders.take().is_some() {
                self.told.intent = None;
                let count = self.told.parts.remove(&(Kind::Orders, 0)).unwrap_or(MOST_PARTS as u8);
                for index in 0..count {
                    self.bus.tell_no_more(key(Kind::Orders, 0, index));
                }
            }
            return;
        };
        // The coordinator of this node takes its leadership up first: what is in the shared state is of a former term until then.
        let intent = self.shared.coordination.intent();
        if intent.version < skein_state::cluster::share::first_version(term) {
            return;
        }
        let same = self.told.intent.as_ref().is_some_and(|told| Arc::ptr_eq(told, &intent));
        if same && now < self.told.next_operator_state {
            return;
        }
        let recalled = self.recalled();
        let orders = Orders::of(&self.shared, term, &recalled);
        self.told.intent = Some(intent);
        if self.told.orders.as_ref() == Some(&orders) {
            return;
        }
        let packed = pack(&orders);
        let fits = packed.is_ok_and(|packed| self.tell_parts(now, Kind::Orders, 0, &packed));
        if !fits {
            self.record(
                skein_domain::exchange::Severity::Critical,
                "the orders are too large to be told to the swarm",
            );
        }
        self.told.orders = Some(orders);
    }

    /// Vehicles of other nodes that say they were taken out, and that the coordinator has called back meanwhile.
    fn recalled(&self) -> BTreeMap<VehicleId, u32> {
        let Some(swarm) = &self.shared.swarm else {
            return BTreeMap::new();
        };
        let withdrawn = self.shared.vehicles.withdrawn();
        let mut recalled = swarm.recalled();
        for (id, remote) in swarm.vehicles().iter() {
            if remote.report.has(skein_state::cluster::report::WITHDRAWN) && !withdrawn.contains(id) {
                recalled.insert(*id, remote.report.withdrawals);
            }
        }
        recalled.clone()
    }

    fn tell_operator_state(&mut self, now: NodeTime) {
        let operator_state = OperatorState::of(&self.shared);
        if operator_state != self.told.operator_state
            && let Ok(packed) = pack(&operator_state)
            && self.tell_parts(now, Kind::OperatorState, 0, &packed)
        {
            self.told.operator_state = operator_state;
        }
        let Some(swarm) = &self.shared.swarm else { return };
        let revision = *swarm.fence_revision();
        // Everybody tells the newest it knows: they outlive whoever set them.
        if revision > self.told.fence_revision {
            let plan = self.shared.fence_plan();
            if let Ok(packed) = pack(&FencesTold { revision, plan }) {
                self.tell_parts(now, Kind::Fences, 0, &packed);
            }
            self.told.fence_revision = revision;
        }
    }

    /// Tells gateways what has happened here.
    fn tell_events(&mut self, now: NodeTime) {
        let gateway = NodeRole::to_bits(&[NodeRole::Gateway]);
        let to: Vec<NodeId> = self
            .monitor
            .present(now)
            .filter(|node| {
                self.nodes
                    .get(node)
                    .is_some_and(|known| known.card.roles & gateway != 0)
            })
            .collect();
        let mut events: Vec<EventRecord> = Vec::new();
        while events.len() < EVENTS_MOST {
            match self.events.try_recv() {
                Ok(event) if event.node.is_none() && !matches!(event.kind, EventKind::Acknowledged { .. }) => {
                    events.push(event.as_ref().clone());
                }
                Ok(_) | Err(tokio::sync::broadcast::error::TryRecvError::Lagged(_)) => {}
                Err(_) => break,
            }
        }
        let most = self.bus.body_bytes().saturating_sub(PART_BYTES);
        while !events.is_empty() && !to.is_empty() {
            let Ok(packed) = pack(&events) else { return };
            if packed.len() > most && events.len() > 1 {
                let half = events.split_off(events.len() / 2);
                self.post_events(now, &to, &events, most);
                events = half;
            } else {
                return self.post_events(now, &to, &events, most);
            }
        }
    }

    fn post_events(&mut self, now: NodeTime, to: &[NodeId], events: &[EventRecord], most: usize) {
        let Some(packed) = pack(&events).ok().filter(|packed| packed.len() <= most) else {
            return;
        };
        for node in to {
            // A gateway that is too slow misses events; its own log says so by their time.
            let _ = self.post(now, *node, &NodeMessage::Events(packed.clone()));
        }
    }
}

/// What this node does in its swarm.
#[must_use]
pub fn roles(shared: &SharedState) -> Vec<NodeRole> {
    let config = &shared.config;
    let of = |is: bool, role| is.then_some(role);
    [
        of(!config.endpoints.is_empty(), NodeRole::VehicleHost),
        of(config.swarm.coordinator_priority.is_some(), NodeRole::Coordinator),
        of(config.web.enabled, NodeRole::Gateway),
        of(config.swarm.observer, NodeRole::Observer),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// What is worth telling of a link, in steps so that it seldom changes.
fn in_steps(link: &LinkHealth) -> LinkHealth {
    LinkHealth {
        round_trip_s: link.round_trip_s.map(|s| (s * 100.0).round() * 0.01),
        receive_rate_hz: link.receive_rate_hz.round(),
        ..LinkHealth::default()
    }
}

/// What changes all the time is told in reports, or not worth telling.
fn without_motion(sheet: VehicleSnapshot) -> VehicleSnapshot {
    let mut sheet = VehicleSnapshot {
        kinematics: None,
        slot: None,
        tracking_error_m: None,
        age_s: 0.0,
        link: in_steps(&sheet.link),
        roll_rad: 0.0,
        pitch_rad: 0.0,
        // Where it is at the moment follows from its report; this is for a swarm that has no frame yet.
        global: sheet.global.filter(|_| !sheet.armed),
        ..sheet
    };
    for way in &mut sheet.ways {
        way.link = LinkHealth {
            connected: way.link.connected,
            ..in_steps(&way.link)
        };
    }
    sheet.model.calls = 0;
    sheet.model.call_p50_us = 0.0;
    sheet.model.call_p99_us = 0.0;
    for payload in &mut sheet.payloads {
        payload.plugin.calls = 0;
        payload.plugin.call_p50_us = 0.0;
        payload.plugin.call_p99_us = 0.0;
        payload.frame = None;
    }
    sheet
}
