//! All vehicles of the swarm at one control period, as the control loop and the coordinator see them: state in the swarm frame (NED).
//!
//! Must never do: change after it was made.

use serde::{Deserialize, Serialize};
use skein_domain::telemetry::VehicleKinematics;
use skein_domain::{
    AnchorReference, EnergyState, FlightLimits, FlightState, LandedState, LinkHealth, NodeTime, PositionNed,
    SwarmFrame, Telemetry, VehicleId,
};
use skein_safety::avoidance::Surroundings;

/// All vehicles at one control period.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct PeerSnapshot {
    /// When that control period began: what was known of them then is in here.
    pub made: NodeTime,
    /// By ascending id.
    pub entries: Vec<PeerEntry>,
    /// Everything in the air as the separation filter wants it, ours and not ours.
    pub surroundings: Surroundings,
    /// The formation's anchor, if it is no vehicle.
    pub anchor: Option<AnchorReference>,
}

/// One vehicle in a [`PeerSnapshot`].
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
pub struct PeerEntry {
    /// Its id.
    pub id: VehicleId,
    /// Position, velocity, yaw in the swarm frame, as measured.
    pub kinematics: Option<VehicleKinematics>,
    /// Motors armed and not known to be on the ground.
    pub airborne: bool,
    /// Telemetry as the link gives it.
    pub telemetry: Telemetry,
    /// Its link.
    pub link: LinkHealth,
    /// Flight state.
    pub flight_state: FlightState,
    /// Its anchor while it leads.
    pub anchor: Option<AnchorReference>,
    /// Launch place in the swarm frame.
    pub home: Option<PositionNed>,
    /// What it can do, if its model says.
    pub limits: Option<FlightLimits>,
    /// A reaction of its failsafe policy is in force: it takes no slot.
    pub under_order: bool,
    /// Its failsafe policy took it out of the formation, and what that was for is over.
    pub may_rejoin: bool,
    /// Its charge against its way home.
    pub energy: Option<EnergyState>,
}

impl PeerSnapshot {
    /// The entry of a vehicle.
    #[must_use]
    pub fn entry(&self, id: VehicleId) -> Option<&PeerEntry> {
        self.entries
            .binary_search_by_key(&id, |e| e.id)
            .ok()
            .and_then(|i| self.entries.get(i))
    }
}

/// Puts telemetry into the swarm frame.
#[must_use]
pub fn kinematics(frame: &SwarmFrame, telemetry: &Telemetry) -> Option<VehicleKinematics> {
    let position = match (telemetry.local_frame, telemetry.local, telemetry.global) {
        (Some(local_frame), Some(local), _) => local_frame.to_swarm(frame, &local),
        (_, _, Some(global)) => frame.position(&global),
        _ => return None,
    };
    Some(VehicleKinematics {
        position,
        velocity: telemetry.velocity.unwrap_or_default(),
        yaw_rad: f64::from(telemetry.yaw_rad),
        measured: telemetry.position_time,
    })
}

/// Whether a vehicle must be counted as flying: armed, and not known to stand on the ground.
#[must_use]
pub fn airborne(telemetry: &Telemetry) -> bool {
    telemetry.armed && telemetry.landed != LandedState::OnGround
}
