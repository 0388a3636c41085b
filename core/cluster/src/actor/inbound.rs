//! What other nodes tell, taken in: by this node's clock, in this node's frame, and only what is obeyed.
//!
//! Must never do: believe a moment that cannot be; take an older value for a newer one.

use super::SwarmState;
use super::messages::NodeMessage;
use crate::asks::{Large, Piece, Whole};
use crate::operator_state::{FencesTold, OperatorState};
use crate::orders::Orders;
use crate::parts::{Assembly, Part, unpack};
use ractor::ActorRef;
use skein_bus::Event;
use skein_bus::courier::Outcome;
use skein_bus::latest::Key;
use skein_domain::exchange::Severity;
use skein_domain::{Geodetic, NodeId, NodeTime, PositionNed, SwarmFrame, VehicleId};
use skein_failover::{Beacon, Term};
use skein_state::SwarmMessage;
use skein_state::cluster::report::{AIRBORNE, Batch, Card, Kind, VehicleReport, WITHDRAWN, named};
use skein_state::cluster::share::RemoteVehicle;
use skein_view::{EventRecord, VehicleSnapshot};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Something told later than this after it was true, or before, was told by a clock that is wrong, in seconds.
const LATEST_S: f64 = 5.0;
/// A vehicle that its node does not name any more is forgotten after so long, in seconds.
const GIVEN_UP_S: f64 = 10.0;
/// So much sooner than told nothing comes, in seconds: what the measured offset of the clocks may be wrong by, at most.
const SOONEST_S: f64 = 0.25;

/// What is known of another node.
#[derive(Debug, Default)]
pub struct Known {
    /// What it says of itself.
    pub card: Card,
    /// When it was last heard.
    pub heard: NodeTime,
    /// The term it obeys.
    pub obeys: Option<Term>,
    /// What it told does not fit to when it came.
    pub clock_fault: bool,
    /// It was told that this node is gone.
    pub told_gone: bool,
    coming: BTreeMap<(Kind, u16), Assembly>,
}

impl Known {
    /// Its frame, if it has one.
    #[must_use]
    pub fn frame(&self) -> Option<SwarmFrame> {
        let [latitude_deg, longitude_deg, altitude_amsl_m] = self.card.origin?;
        let origin = Geodetic {
            latitude_deg,
            longitude_deg,
            altitude_amsl_m,
        };
        origin.is_valid().then(|| SwarmFrame::new(origin))
    }
}

impl SwarmState {
    /// Everything that has arrived.
    pub(super) fn take(&mut self, myself: &ActorRef<SwarmMessage>, now: NodeTime) {
        let mut events = Vec::new();
        while let Some(datagram) = self.transport.receive(now) {
            events.extend(self.bus.take(now, &datagram.bytes));
        }
        events.extend(self.bus.expire(now));
        for event in events {
            match event {
                Event::Joined { node, .. } => self.joined(node, now),
                Event::State { from, key, value } => self.state(from, key, &value, now),
                Event::Command { from, body } => self.message(myself, from, &body, now),
                Event::CommandEnded { to, number, outcome } => {
                    self.asks.command_ended(now, to, number, outcome == Outcome::Delivered);
                }
                Event::Bulk { from, body } => {
                    if let Ok(large) = minicbor::decode::<Large>(&body)
                        && let Ok(whole) = self.asks.whole(from, large.id, large.is_answer, &large.packed)
                    {
                        self.serve(myself, whole);
                    }
                }
                Event::BulkEnded { to, id, whole } => self.asks.whole_ended(to, id, whole),
                Event::Video { from, picture } => self.show_video(now, from, &picture),
                Event::VideoKeyWanted { by, stream } => self.shared.videos.want_key(by, stream),
                Event::Asked { .. } | Event::Answered { .. } | Event::Unanswered { .. } => {}
            }
        }
        self.asks.expire(now);
        if let Some((from, orders)) = self.pending.take() {
            self.obey(from, orders, now);
        }
    }

    fn joined(&mut self, node: NodeId, now: NodeTime) {
        let known = self.nodes.entry(node).or_default();
        // A new run counts its revisions anew.
        known.coming.clear();
        known.heard = now;
        let back = std::mem::take(&mut known.told_gone);
        if let Some(swarm) = &self.shared.swarm {
            swarm.note_start(node, now);
        }
        let what = if back { "is back" } else { "has joined" };
        self.record(Severity::Info, format!("node {node} {what}"));
        self.told.tell_anew();
    }

    /// How far this node's clock is ahead of another's in microseconds, if that was measured.
    pub(super) fn ahead_us(&self, of: NodeId) -> Option<i64> {
        let (_, link) = self.bus.links().find(|(node, _)| *node == of)?;
        Some((-link.offset_s * 1e6).round() as i64)
    }

    fn state(&mut self, from: NodeId, key: Key, value: &[u8], now: NodeTime) {
        let known = self.nodes.entry(from).or_default();
        known.heard = now;
        let Some((kind, item)) = named(key) else { return };
        // What is not understood is of a later version of this program.
        match kind {
            Kind::Beacon => {
                if let Ok(beacon) = minicbor::decode::<Beacon>(value) {
                    known.obeys = beacon.obeys;
                    self.leadership.hear(&beacon);
                    self.monitor.hear(now, &self.leadership, &beacon);
                }
            }
            Kind::Card => {
                if let Ok(card) = minicbor::decode::<Card>(value) {
                    known.card = card.clone();
                    self.forget_given_up(from, &card, now);
                }
            }
            Kind::Vehicles => {
                if let Ok(batch) = minicbor::decode(value) {
                    self.vehicles(from, batch, now);
                }
            }
            Kind::Sheet | Kind::Orders | Kind::OperatorState | Kind::Fences | Kind::Sightings | Kind::Tracks => {
                let Ok(part) = minicbor::decode::<Part>(value) else {
                    return;
                };
                let whole = known.coming.entry((kind, item)).or_default().take(part);
                if let Some(whole) = whole {
                    self.whole(from, kind, &whole, now);
                }
            }
        }
    }

    fn whole(&mut self, from: NodeId, kind: Kind, bytes: &[u8], now: NodeTime) {
        match kind {
            Kind::Sheet => {
                if let Ok(sheet) = unpack::<VehicleSnapshot>(bytes) {
                    self.sheet(from, sheet);
                }
            }
            Kind::Orders => {
                if let Ok(orders) = unpack::<Orders>(bytes) {
                    self.obey(from, orders, now);
                }
            }
            Kind::OperatorState => {
                if let Ok(operator_state) = unpack::<OperatorState>(bytes) {
                    operator_state.take_up(&self.shared, self.ahead_us(from));
                }
            }
            Kind::Fences => {
                if let Ok(fences) = unpack::<FencesTold>(bytes) {
                    fences.take_up(&self.shared);
                }
            }
            Kind::Sightings => self.hear_sightings(from, bytes, now),
            Kind::Tracks => self.hear_fused(from, bytes, now),
            Kind::Beacon | Kind::Card | Kind::Vehicles => {}
        }
    }

    /// Vehicles that a node had and does not tell of any more. One that was last seen in the air is still there somewhere.
    fn forget_given_up(&self, from: NodeId, card: &Card, now: NodeTime) {
        let Some(swarm) = &self.shared.swarm else { return };
        swarm.change_vehicles().retain(|id, remote| {
            let kept = remote.node != from || card.vehicles.contains(id);
            kept || remote.report.has(AIRBORNE) || now.seconds_since(remote.told) < GIVEN_UP_S
        });
    }

    /// What a node tells of its vehicles.
    fn vehicles(&mut self, from: NodeId, batch: Batch, now: NodeTime) {
        let (Some(ahead_us), Some(known)) = (self.ahead_us(from), self.nodes.get_mut(&from)) else {
            return;
        };
        let told = batch.told.on_clock_ahead_by(ahead_us);
        let age_s = now.seconds_since(told);
        let wrong = !(-SOONEST_S..=LATEST_S).contains(&age_s);
        if wrong != known.clock_fault {
            known.clock_fault = wrong;
            let (severity, text) = if wrong {
                (
                    Severity::Warning,
                    format!("the clock of node {from} has jumped: it tells of what is {age_s:.1} s away"),
                )
            } else {
                (Severity::Info, format!("the clock of node {from} is known again"))
            };
            return self.record(severity, text);
        }
        if wrong {
            return;
        }
        // Nothing is known before it was told.
        let told = told.min(now);
        let frames = known
            .frame()
            .zip(self.shared.frame())
            .filter(|(theirs, ours)| theirs != ours);
        let Some(swarm) = &self.shared.swarm else { return };
        let acts = self.leadership.acting().is_some();
        let mut vehicles = swarm.change_vehicles();
        for mut report in batch.reports {
            if let Some((theirs, ours)) = frames {
                into_frame(&mut report, &theirs, &ours);
            }
            let before = vehicles.get(&report.id);
            if acts {
                self.mirror_withdrawal(before.map(|b| &b.report), &report);
            }
            let anchor = report.anchor.map(|mut anchor| {
                anchor.put_on_clock_ahead_by(ahead_us);
                anchor
            });
            let sheet = before.filter(|b| b.node == from).and_then(|b| b.sheet.clone());
            let remote = RemoteVehicle {
                node: from,
                told,
                anchor,
                sheet,
                report,
            };
            vehicles.insert(remote.report.id, remote);
        }
    }

    /// Who coordinates keeps a list of those that operators took out; their nodes know of it first.
    fn mirror_withdrawal(&self, before: Option<&VehicleReport>, report: &VehicleReport) {
        let count = |report: &VehicleReport| report.has(WITHDRAWN).then_some(report.withdrawals);
        let (was, is) = (before.and_then(count), count(report));
        if was == is {
            return;
        }
        self.shared.vehicles.mirror_withdrawals([(report.id, is.is_some())]);
    }

    fn sheet(&mut self, from: NodeId, sheet: VehicleSnapshot) {
        let Some(swarm) = &self.shared.swarm else { return };
        let mut vehicles = swarm.change_vehicles();
        if let Some(remote) = vehicles.get_mut(&sheet.id).filter(|remote| remote.node == from) {
            remote.sheet = Some(Arc::new(sheet));
        }
    }

    /// Orders of a coordinator: taken up if it is obeyed, and if their moments can be reckoned by this node's clock.
    fn obey(&mut self, from: NodeId, mut orders: Orders, now: NodeTime) {
        let before = self.leadership.obeyed();
        if orders.term.holder.node != from || self.leadership.order(orders.term).is_err() {
            return;
        }
        if let (Some(theirs), Some(ours)) = (orders.frame, self.shared.frame())
            && theirs != ours
        {
            return self.other_frame(from);
        }
        let Some(ahead_us) = self.ahead_us(from) else {
            self.pending = Some((from, orders));
            return;
        };
        if let Some(frame) = orders.frame {
            self.shared.fix_frame(frame.origin);
        }
        orders.put_on_clock_ahead_by(ahead_us);
        let term = orders.term;
        orders.take_up(&self.shared);
        if self.told.taken_up(term) || before.is_none_or(|before| before.number < term.number) {
            tracing::info!(
                term = term.number,
                holder = term.holder.node.0,
                at_s = now.as_seconds(),
                "intent taken up"
            );
        }
    }

    fn other_frame(&mut self, from: NodeId) {
        if self.told.first_other_frame(from) {
            let text = format!(
                "orders of node {from} are not taken up: its swarm frame is another one; give all nodes the same swarm.origin, or none"
            );
            self.record(Severity::Critical, text);
        }
    }

    /// A command of the bus.
    fn message(&mut self, myself: &ActorRef<SwarmMessage>, from: NodeId, body: &[u8], now: NodeTime) {
        match minicbor::decode::<NodeMessage>(body) {
            Ok(NodeMessage::Piece(piece)) => self.piece(myself, from, piece, now),
            Ok(NodeMessage::Events(packed)) => {
                let Ok(events) = unpack::<Vec<EventRecord>>(&packed) else {
                    return;
                };
                let ahead_us = self.ahead_us(from).unwrap_or_default();
                for event in events {
                    let time = event.time.on_clock_ahead_by(ahead_us).min(now);
                    let text = match (event.vehicle, self.nodes.get(&from).map(|known| &known.card.name)) {
                        (None, Some(name)) => format!("{name}: {}", event.text),
                        _ => event.text,
                    };
                    self.shared.events.relay(from, EventRecord { time, text, ..event });
                }
            }
            Ok(NodeMessage::Handover(offer)) => {
                if self.leadership.take_over(&offer).is_some() {
                    self.lost_leader = None;
                    self.record(
                        Severity::Info,
                        format!("node {from} has handed the leadership over to this node"),
                    );
                }
            }
            Err(_) => {}
        }
    }

    fn piece(&mut self, myself: &ActorRef<SwarmMessage>, from: NodeId, piece: Piece, now: NodeTime) {
        if let Ok(Some(whole)) = self.asks.take(now, from, piece) {
            self.serve(myself, whole);
        }
    }

    fn serve(&self, myself: &ActorRef<SwarmMessage>, whole: Whole) {
        let Whole::Asked { from, id, ask } = whole else { return };
        let (carry_out, myself, ahead_us) = (self.carry_out.clone(), myself.clone(), self.ahead_us(from));
        tokio::spawn(async move {
            let answer = Box::new(carry_out(*ask, ahead_us).await);
            // A node that ends answers nobody.
            let _ = myself.cast(SwarmMessage::Served { to: from, id, answer });
        });
    }
}

/// A report of a node whose frame is another one.
fn into_frame(report: &mut VehicleReport, theirs: &SwarmFrame, ours: &SwarmFrame) {
    let moved = |place: PositionNed| ours.position(&theirs.geodetic(&place));
    if let Some(motion) = &mut report.motion {
        motion.place_at(moved(motion.place()));
    }
    if let Some(anchor) = &mut report.anchor {
        anchor.position = moved(anchor.position);
    }
    report.held_mm = None;
}

/// Vehicles of these nodes.
#[must_use]
pub fn of_nodes(vehicles: &BTreeMap<VehicleId, RemoteVehicle>, node: NodeId) -> Vec<VehicleId> {
    vehicles
        .values()
        .filter(|v| v.node == node)
        .map(|v| v.report.id)
        .collect()
}
