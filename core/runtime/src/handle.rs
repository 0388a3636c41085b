//! The typed handle to a running node: the only way in for the API, the demo and the tests. The actors' messages stay private.

use crate::snapshot::{EventRecord, FleetSnapshot};
use serde::{Deserialize, Serialize};
use skein_domain::exchange::FaultDrill;
use skein_domain::{CommandId, FormationRequest, Refusal, Route, VehicleCommand, VehicleId};

/// Whom a command is for.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Targets {
    /// Every adopted vehicle.
    All,
    /// These vehicles.
    Vehicles(Vec<VehicleId>),
}

/// What became of a command at one vehicle: taken up (how it goes on comes as events), or refused.
#[derive(Debug, Clone, PartialEq, Serialize, ts_rs::TS, schemars::JsonSchema)]
pub struct CommandReceipt {
    /// The vehicle.
    pub vehicle: VehicleId,
    /// The command's id; events about its progress carry it.
    pub id: CommandId,
    /// Why it was refused; absent if it was taken up.
    pub refusal: Option<Refusal>,
}

/// What a change of formation will look like.
#[derive(Debug, Clone, PartialEq, Serialize, ts_rs::TS, schemars::JsonSchema)]
pub struct FormationReceipt {
    /// Who leads.
    pub leader: VehicleId,
    /// Who takes part, leader first.
    pub members: Vec<VehicleId>,
    /// How long the change takes in seconds.
    pub duration_s: f64,
    /// Smallest distance between any two vehicles on the way, in metres.
    pub planned_min_distance_m: f64,
}

/// A fault to inject, where the configuration permits it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(tag = "fault", rename_all = "snake_case", deny_unknown_fields)]
pub enum Fault {
    /// The UAV-model plugin of a vehicle panics.
    PluginPanic {
        /// The vehicle.
        vehicle: VehicleId,
    },
    /// The UAV-model plugin of a vehicle does not return.
    PluginHang {
        /// The vehicle.
        vehicle: VehicleId,
    },
    /// The actor of a vehicle is killed.
    VehicleActor {
        /// The vehicle.
        vehicle: VehicleId,
    },
    /// The coordinator actor is killed.
    Coordinator,
}

impl Fault {
    /// The drill a plugin is given, if the fault is a plugin's.
    #[must_use]
    pub fn drill(self) -> Option<(VehicleId, FaultDrill)> {
        match self {
            Self::PluginPanic { vehicle } => Some((vehicle, FaultDrill::Panic)),
            Self::PluginHang { vehicle } => Some((vehicle, FaultDrill::Hang)),
            Self::VehicleActor { .. } | Self::Coordinator => None,
        }
    }
}
