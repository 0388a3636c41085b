//! What is answered to commands and to requests for a formation.
//!
//! Must never do: say of something that it is done when it is only taken up.

use serde::{Deserialize, Serialize};
use skein_domain::{CommandId, PositionNed, Refusal, VehicleId};

/// What became of a command at one vehicle: taken up (how it goes on comes as events), or refused.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
pub struct CommandReceipt {
    /// The vehicle.
    pub vehicle: VehicleId,
    /// The command's id; events about its progress carry it.
    pub id: CommandId,
    /// Why it was refused; absent if it was taken up.
    pub refusal: Option<Refusal>,
}

/// What a change of formation will look like.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
pub struct FormationReceipt {
    /// Who leads; nobody if it is anchored to something else than a vehicle.
    pub leader: Option<VehicleId>,
    /// Who takes part, leader first.
    pub members: Vec<VehicleId>,
    /// How long the change takes in seconds.
    pub duration_s: f64,
    /// Smallest distance between any two vehicles on the way, in metres; null for one alone.
    pub planned_min_distance_m: Option<f64>,
    /// How fast it can go as a whole, in metres per second.
    pub max_speed_m_s: f64,
    /// Members that carry a camera and whose places leave it no free view, neither ahead nor outwards.
    pub view_blocked: Vec<VehicleId>,
}

/// How a change of formation would go if it were begun now.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
pub struct FormationForecast {
    /// What would be answered.
    pub receipt: FormationReceipt,
    /// Where the formation would look while its anchor stands where it is, in radians clockwise from north.
    pub heading_rad: f64,
    /// Who would take which place, leader first.
    pub ways: Vec<ForeseenWay>,
}

/// From where a vehicle would go into which place of a formation, in metres about the swarm's origin. With a turning formation or a
/// detour around another vehicle the way itself is no straight line.
#[derive(Debug, Clone, Copy, PartialEq)]
#[derive(Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
pub struct ForeseenWay {
    /// The vehicle.
    pub vehicle: VehicleId,
    /// Where it is.
    pub from: PositionNed,
    /// Where its place is while the anchor stands where it is.
    pub to: PositionNed,
}
