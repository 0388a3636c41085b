//! The formation that is flown: who takes part, which slots, which way into them.
//!
//! Must never do: read a clock, or send anything.

use serde::{Deserialize, Deserializer, Serialize};
use skein_domain::{
    AnchorPlan, FormationControl, FormationHeading, FormationRequest, Keeping, NodeTime, SlotMove, VehicleId,
};
use skein_view::PeerSnapshot;
use std::collections::BTreeMap;

/// A formation being flown.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Formation {
    /// As it was asked for, with the leader filled in.
    pub request: FormationRequest,
    /// Who leads; nobody if the anchor is no vehicle.
    pub leader: Option<VehicleId>,
    /// The anchor, if it is no vehicle.
    pub anchor: Option<AnchorPlan>,
    /// Who takes part, leader first.
    pub members: Vec<VehicleId>,
    /// Each follower's way into its slot.
    pub slots: BTreeMap<VehicleId, SlotMove>,
    /// How its heading is chosen once it is formed.
    pub heading: FormationHeading,
    /// The same until then: with members far outside of their places it turns more slowly.
    pub heading_while_forming: FormationHeading,
    /// For control by neighbours: what each follower keeps once all are in their slots.
    pub keeping: BTreeMap<VehicleId, Keeping>,
    /// When the change was decided.
    pub decided: NodeTime,
    /// When all are to be in their slots.
    pub settled_at: NodeTime,
    /// Smallest distance foreseen on the way, in metres; infinite for one alone, which JSON tells as null.
    #[serde(deserialize_with = "null_is_infinite")]
    pub min_distance_m: f64,
    /// Members that carry a camera and whose places leave it no free view.
    pub view_blocked: Vec<VehicleId>,
    /// How fast it can go as a whole, in metres per second: its slowest member's limit, with turns taken into account.
    pub max_speed_m_s: f64,
}

fn null_is_infinite<'de, D: Deserializer<'de>>(value: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(value)?.unwrap_or(f64::INFINITY))
}

impl Formation {
    /// How far its outermost place is from its anchor on the ground, in metres.
    #[must_use]
    pub fn reach_m(&self) -> f64 {
        let reach = |slot: &SlotMove| slot.to.forward_m.hypot(slot.to.right_m);
        self.slots.values().map(reach).fold(0.0, f64::max)
    }

    /// Smallest distance foreseen on the way between any two, in metres; none for one alone.
    #[must_use]
    pub fn apart_m(&self) -> Option<f64> {
        Some(self.min_distance_m).filter(|apart_m| apart_m.is_finite())
    }

    /// Whether all are to be in their slots by this moment.
    #[must_use]
    pub fn is_settled(&self, now: NodeTime) -> bool {
        now >= self.settled_at
    }

    /// How its heading is chosen at this moment.
    #[must_use]
    pub fn heading_at(&self, now: NodeTime) -> FormationHeading {
        if self.is_settled(now) {
            self.heading
        } else {
            self.heading_while_forming
        }
    }

    /// What it is anchored to at this moment, if that is no vehicle.
    #[must_use]
    pub fn anchor_at(&self, now: NodeTime) -> Option<AnchorPlan> {
        match self.anchor.clone()? {
            AnchorPlan::Reference { name, .. } => Some(AnchorPlan::Reference {
                name,
                heading: self.heading_at(now),
                places: self.slots.values().map(|slot| slot.to).collect(),
            }),
            other => Some(other),
        }
    }

    /// Whether its followers keep their places by their neighbours at this moment, and not by slots.
    #[must_use]
    pub fn keeps_itself(&self, now: NodeTime) -> bool {
        self.request.control != FormationControl::Slots && !self.keeping.is_empty() && self.is_settled(now)
    }

    /// The same with its motion beginning at `start`: planning took time.
    #[must_use]
    pub fn beginning(mut self, start: NodeTime) -> Self {
        let late_s = start.seconds_since(self.decided);
        for slot in self.slots.values_mut() {
            slot.start = slot.start.plus_seconds(late_s);
        }
        for keeping in self.keeping.values_mut() {
            keeping.start = keeping.start.plus_seconds(late_s);
        }
        let settled_at = self.settled_at;
        // A virtual leader that sets off when they are formed; one that is under way already keeps its time.
        if let Some(AnchorPlan::Path { start, .. }) = &mut self.anchor
            && *start == settled_at
        {
            *start = start.plus_seconds(late_s);
        }
        self.settled_at = settled_at.plus_seconds(late_s);
        self.decided = start;
        self
    }
}

/// Vehicles in the air, heard, with a position and under the swarm's control.
#[must_use]
pub fn available(peers: &PeerSnapshot) -> Vec<VehicleId> {
    peers
        .entries
        .iter()
        .filter(|e| e.link.connected && e.kinematics.is_some() && e.airborne && !e.under_order)
        .filter(|e| e.flight_state.is_available_in_air())
        .map(|e| e.id)
        .collect()
}
