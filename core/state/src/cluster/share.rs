//! What a node knows of the swarm that it is part of, for everybody in it to read: whom it obeys, and the vehicles that other nodes fly.
//!
//! Must never do: decide anything; tell an old place of a vehicle for a new one.

use super::report::{AIRBORNE, ARMED, CONNECTED, MAY_REJOIN, STREAMS, UNDER_ORDER, VehicleReport};
use crate::asks::ApiServer;
use crate::mailbox::SwarmMessage;
use arc_swap::{ArcSwap, ArcSwapOption};
use parking_lot::{Mutex, MutexGuard, RwLock};
use ractor::ActorRef;
use skein_domain::{AnchorReference, LinkHealth, NodeId, NodeTime, SwarmFrame, Telemetry, VehicleId};
use skein_failover::{LeaderState, Term};
use skein_view::PeerEntry;
use skein_view::SwarmSnapshot;
use skein_view::VehicleSnapshot;
use std::collections::BTreeMap;
use std::ops::{Deref, DerefMut};
use std::sync::{Arc, OnceLock};

/// Whom this node obeys at this moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Role {
    /// This node's number.
    pub node: NodeId,
    /// The term in which it coordinates, if it does.
    pub acting: Option<Term>,
    /// Since when it has coordinated without a break.
    pub acting_since: Option<NodeTime>,
    /// The holder that it succeeded because that one was missed; none if somebody asked, or nobody held the leadership.
    pub lost_leader: Option<NodeId>,
    /// Whom it obeys.
    pub leader_state: LeaderState,
    /// When the obeyed coordinator last gave a sign of life.
    pub coordinator_seen: Option<NodeTime>,
    /// It hears no other node, though it did.
    pub cut_off: bool,
    /// Watches, and commands nothing.
    pub observer: bool,
}

/// Two nodes may claim the leadership at the same moment, where nobody holds it. By then the one that loses it has heard of that, in seconds: ten
/// beacons.
const UNDISPUTED_AFTER_S: f64 = 1.0;

impl Role {
    /// Whether it has coordinated for so long that nobody else does for having claimed the leadership at the same moment. What can never be taken
    /// back, the swarm's frame, waits for that: two nodes with frames of their own would never obey each other.
    #[must_use]
    pub fn is_undisputed(&self, now: NodeTime) -> bool {
        self.acting_since
            .is_some_and(|since| now.seconds_since(since) >= UNDISPUTED_AFTER_S)
    }

    /// The node that coordinates, if one is obeyed.
    #[must_use]
    pub fn coordinator(&self) -> Option<NodeId> {
        match self.leader_state {
            LeaderState::Nobody => None,
            LeaderState::Led { term } | LeaderState::Awaiting { term, .. } | LeaderState::Unled { term, .. } => {
                Some(term.holder.node)
            }
        }
    }
}

/// A vehicle that another node flies.
#[derive(Debug, Clone)]
pub struct RemoteVehicle {
    /// Which node.
    pub node: NodeId,
    /// As last told, by this node's clock: when that was.
    pub told: NodeTime,
    /// What was told.
    pub report: VehicleReport,
    /// The anchor it told, by this node's clock.
    pub anchor: Option<AnchorReference>,
    /// Everything that screens show of it, as last told.
    pub sheet: Option<Arc<VehicleSnapshot>>,
}

/// What a node shares with its swarm.
pub struct SwarmShare {
    /// Whom it obeys.
    role: ArcSwap<Role>,
    /// Vehicles of other nodes.
    vehicles: RwLock<BTreeMap<VehicleId, RemoteVehicle>>,
    /// When each other node was last heard to have started.
    starts: RwLock<BTreeMap<NodeId, NodeTime>>,
    /// The swarm for screens.
    picture: ArcSwap<SwarmSnapshot>,
    /// The actor that speaks for this node.
    actor: ArcSwapOption<ActorRef<SwarmMessage>>,
    /// Answers requests of other nodes' gateways.
    api: OnceLock<ApiServer>,
    /// Withdrawals of other nodes' vehicles that the coordinator has called back: which one of each.
    recalled: Mutex<BTreeMap<VehicleId, u32>>,
    /// The revision of the fences in force; 0 for those of the configuration.
    fence_revision: Mutex<u64>,
}

impl SwarmShare {
    /// Of a node that has just started.
    #[must_use]
    pub fn new(node: NodeId, observer: bool) -> Self {
        let role = Role {
            node,
            acting: None,
            acting_since: None,
            lost_leader: None,
            leader_state: LeaderState::Nobody,
            coordinator_seen: None,
            cut_off: false,
            observer,
        };
        Self {
            role: ArcSwap::from_pointee(role),
            vehicles: RwLock::default(),
            starts: RwLock::default(),
            picture: ArcSwap::default(),
            actor: ArcSwapOption::default(),
            api: OnceLock::new(),
            recalled: Mutex::default(),
            fence_revision: Mutex::default(),
        }
    }

    /// Whom it obeys.
    #[must_use]
    pub fn role(&self) -> Role {
        **self.role.load()
    }

    /// It obeys so from now on.
    pub fn obey(&self, role: Role) {
        self.role.store(Arc::new(role));
    }

    /// Vehicles of other nodes, to be read.
    pub fn vehicles(&self) -> impl Deref<Target = BTreeMap<VehicleId, RemoteVehicle>> {
        self.vehicles.read()
    }

    /// The same, for the actor that hears them, and for the coordinator, which forgets the anchors of former leaders.
    pub fn change_vehicles(&self) -> impl DerefMut<Target = BTreeMap<VehicleId, RemoteVehicle>> {
        self.vehicles.write()
    }

    /// When each other node was last heard to have started.
    pub fn starts(&self) -> impl Deref<Target = BTreeMap<NodeId, NodeTime>> {
        self.starts.read()
    }

    /// Another node was heard to have started.
    pub fn note_start(&self, node: NodeId, now: NodeTime) {
        self.starts.write().insert(node, now);
    }

    /// The swarm for screens.
    #[must_use]
    pub fn picture(&self) -> Arc<SwarmSnapshot> {
        self.picture.load_full()
    }

    /// Screens show this from now on.
    pub fn show(&self, picture: SwarmSnapshot) {
        self.picture.store(Arc::new(picture));
    }

    /// The actor that speaks for this node, if it runs.
    #[must_use]
    pub fn actor(&self) -> Option<Arc<ActorRef<SwarmMessage>>> {
        self.actor.load_full()
    }

    /// This actor speaks for the node from now on; none any more.
    pub fn speak_through(&self, actor: Option<ActorRef<SwarmMessage>>) {
        self.actor.store(actor.map(Arc::new));
    }

    /// What answers requests of other nodes' gateways.
    #[must_use]
    pub fn api(&self) -> Option<&ApiServer> {
        self.api.get()
    }

    /// This answers them from now on. The first one stays.
    pub fn serve(&self, api: ApiServer) {
        let _ = self.api.set(api);
    }

    /// Withdrawals of other nodes' vehicles that the coordinator has called back: which one of each.
    pub fn recalled(&self) -> MutexGuard<'_, BTreeMap<VehicleId, u32>> {
        self.recalled.lock()
    }

    /// The revision of the fences in force, held while they are set.
    pub fn fence_revision(&self) -> MutexGuard<'_, u64> {
        self.fence_revision.lock()
    }

    /// The actor that speaks for this node has ended: it coordinates no more until the next one knows better.
    pub fn silence(&self) {
        let role = **self.role.load();
        self.role.store(Arc::new(Role {
            acting: None,
            acting_since: None,
            ..role
        }));
    }

    /// Which node flies a vehicle, if another one does.
    #[must_use]
    pub fn host(&self, vehicle: VehicleId) -> Option<NodeId> {
        self.vehicles.read().get(&vehicle).map(|remote| remote.node)
    }

    /// The vehicles of other nodes as peers, by ascending id.
    #[must_use]
    pub fn peers(&self, lost_after_s: f64, frame: Option<SwarmFrame>, now: NodeTime) -> Vec<PeerEntry> {
        let vehicles = self.vehicles.read();
        vehicles
            .values()
            .map(|remote| remote.peer(lost_after_s, frame, now))
            .collect()
    }
}

impl RemoteVehicle {
    /// When its autopilot was last heard, as far as it is known here.
    #[must_use]
    pub fn last_heard(&self) -> NodeTime {
        NodeTime(self.told.0.saturating_sub(u64::from(self.report.heard_age_us)))
    }

    /// As a peer of this node's own vehicles.
    fn peer(&self, lost_after_s: f64, frame: Option<SwarmFrame>, now: NodeTime) -> PeerEntry {
        let (report, sheet) = (&self.report, self.sheet.as_deref());
        let last_heard = self.last_heard();
        let connected = report.has(CONNECTED) && now.seconds_since(last_heard) <= lost_after_s;
        let kinematics = report.motion.map(|motion| motion.kinematics(self.told));
        let home = sheet.and_then(|sheet| sheet.home);
        PeerEntry {
            id: report.id,
            kinematics,
            airborne: report.has(AIRBORNE),
            telemetry: Telemetry {
                mode: report.mode,
                armed: report.has(ARMED),
                landed: report.landed,
                ready_to_arm: sheet.and_then(|sheet| sheet.ready_to_arm),
                global: sheet.and_then(|sheet| sheet.global),
                velocity: kinematics.map(|k| k.velocity),
                position_time: kinematics.map_or(NodeTime::default(), |k| k.measured),
                yaw_rad: kinematics.map_or(0.0, |k| k.yaw_rad as f32),
                home,
                battery: sheet.map(|sheet| sheet.battery).unwrap_or_default(),
                gnss: sheet.map(|sheet| sheet.gnss).unwrap_or_default(),
                ..Telemetry::default()
            },
            link: LinkHealth {
                connected,
                last_heard,
                loss: f32::from(report.loss_percent) * 0.01,
                setpoint_rate_hz: if report.has(STREAMS) { 1.0 } else { 0.0 },
                ..sheet.map(|sheet| sheet.link).unwrap_or_default()
            },
            flight_state: report.flight_state,
            anchor: self.anchor,
            home: frame.zip(home).map(|(frame, home)| frame.position(&home)),
            limits: sheet.and_then(|sheet| sheet.limits),
            under_order: report.has(UNDER_ORDER),
            may_rejoin: report.has(MAY_REJOIN),
            energy: sheet.and_then(|sheet| sheet.energy),
        }
    }

    /// For screens: what was told of it in full, with what was told since.
    #[must_use]
    pub fn snapshot(&self, peer: &PeerEntry, leader: Option<VehicleId>, now: NodeTime) -> Option<VehicleSnapshot> {
        let report = &self.report;
        Some(VehicleSnapshot {
            flight_state: report.flight_state,
            mode: report.mode,
            armed: report.has(ARMED),
            landed: report.landed,
            kinematics: peer.kinematics,
            link: peer.link,
            age_s: now.seconds_since(peer.link.last_heard).max(0.0),
            tracking_error_m: report.tracking_error_cm.map(|cm| f64::from(cm) * 0.01),
            is_leader: leader == Some(report.id),
            node: Some(self.node),
            ..self.sheet.as_deref()?.clone()
        })
    }
}

/// Versions of intents of a term are greater than all of earlier terms, whatever was published in those and not heard by everybody.
#[must_use]
pub fn first_version(term: Term) -> u64 {
    (term.number & 0xFFFF_FFFF) << 32
}

#[cfg(test)]
mod tests {
    //! What can never be taken back waits until nobody disputes the leadership.

    use super::*;

    #[test]
    fn who_has_just_taken_the_leadership_is_not_undisputed() {
        let at = NodeTime::from_seconds;
        let share = SwarmShare::new(NodeId(1), false);
        let role = **share.role.load();
        assert!(!role.is_undisputed(at(100.0)), "it does not coordinate");
        let acting = Role {
            acting_since: Some(at(100.0)),
            ..role
        };
        assert!(!acting.is_undisputed(at(100.9)));
        assert!(acting.is_undisputed(at(101.0)));
        share.role.store(Arc::new(acting));
        share.silence();
        assert!(!share.role.load().is_undisputed(at(102.0)));
    }
}
