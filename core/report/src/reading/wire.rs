//! The parts of large messages that the report needs: the rest is passed over, which takes half of the time.
//!
//! Must never do: ask for a field that a recording of format 1 may lack.

use serde::Deserialize;
use skein_domain::{EnergyState, FailsafeSettings, Geodetic, NodeTime, Refusal, SwarmFrame, VehicleId};
use skein_view::Avoidance;

/// Of a `FleetSnapshot`.
#[derive(Debug, Deserialize)]
pub struct WholeFleet {
    pub frame: Option<SwarmFrame>,
    pub vehicles: Vec<WholeVehicle>,
    pub formation: Option<WholeFormation>,
}

/// Of a `FormationSnapshot`.
#[derive(Debug, Deserialize)]
pub struct WholeFormation {
    pub members: Vec<VehicleId>,
    pub settled_at: NodeTime,
}

/// Of a `VehicleSnapshot`.
#[derive(Debug, Deserialize)]
pub struct WholeVehicle {
    pub id: VehicleId,
    pub name: String,
    #[serde(default)]
    pub simulated: bool,
    pub plugin: String,
    pub home: Option<Geodetic>,
    pub energy: Option<EnergyState>,
}

/// Of a `SetpointRecord`.
#[derive(Debug, Deserialize)]
pub struct JudgedSetpoint {
    pub time: NodeTime,
    pub vehicle: VehicleId,
    pub refusal: Option<Refusal>,
    pub change: Option<Avoidance>,
}

/// Of a `FailsafeDecision`.
#[derive(Debug, Deserialize)]
pub struct FailsafeRules {
    pub settings: FailsafeSettings,
}
