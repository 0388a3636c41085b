//! The routes about safety, for the table.

use super::Endpoint;
use crate::emergency;
use crate::protocol::{CommandReceipts, EmergencyStopBody};
use axum::http::StatusCode;
use skein_runtime::EmergencyKey;

/// The emergency stop.
pub(super) fn safety() -> Vec<Endpoint> {
    vec![
        Endpoint::post(
            "/api/v1/emergency-stop/unlock",
            "unlockEmergencyStop",
            emergency::unlock,
        )
        .about(
            "safety",
            "The first step of the emergency stop: gives the key that the second needs within seconds.",
        )
        .json::<EmergencyKey>(StatusCode::OK, "The key."),
        Endpoint::post("/api/v1/emergency-stop", "emergencyStop", emergency::stop)
            .about(
                "safety",
                "Stops the motors of one, several or all vehicles at once. In flight they fall.",
            )
            .takes::<EmergencyStopBody>()
            .json::<CommandReceipts>(
                StatusCode::OK,
                "It was sent; whether the motors stand still comes as events.",
            )
            .fails(&[403]),
    ]
}
