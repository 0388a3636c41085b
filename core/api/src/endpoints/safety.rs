//! The routes about safety, for the table.

use super::{Endpoint, schema_of};
use crate::protocol::{
    CommandReceipts, EmergencyStopBody, FenceFileBody, FencePlanBody, ImportedFencePlan, OverrideBody,
};
use crate::{emergency, fences, preflight};
use axum::http::StatusCode;
use skein_domain::PreflightOverride;
use skein_runtime::{EmergencyKey, FenceAnswer, PreflightAnswer};

/// The emergency stop, the preflight report, the fences.
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
        Endpoint::get("/api/v1/preflight", "getPreflight", preflight::report)
            .about("safety", "What was found before arming, item by item, of the swarm and of each vehicle.")
            .json::<PreflightAnswer>(StatusCode::OK, "The reports."),
        Endpoint::post("/api/v1/preflight/overrides", "overridePreflight", preflight::give_override)
            .about(
                "safety",
                "Takes red items upon a configured operator, shown by a bearer token. Recorded, and again when a vehicle is armed by it.",
            )
            .takes::<OverrideBody>()
            .json::<PreflightOverride>(StatusCode::OK, "It holds.")
            .fails(&[401, 403, 404]),
        Endpoint::post("/api/v1/operator/alive", "operatorIsAlive", preflight::alive)
            .about("safety", "A sign of life of an operator, for the dead man's switch where the configuration has it on.")
            .answer(StatusCode::NO_CONTENT, "It was heard.", None),
        Endpoint::get("/api/v1/fences", "getFences", fences::in_force)
            .about("safety", "The fences in force, and who is outside of them.")
            .json::<FenceAnswer>(StatusCode::OK, "The fences."),
        Endpoint::put("/api/v1/fences", "setFences", fences::set)
            .about("safety", "Puts other fences in force. Wrong ones change nothing.")
            .takes::<FencePlanBody>()
            .json::<FenceAnswer>(StatusCode::OK, "They are in force."),
        Endpoint::post("/api/v1/fences/import", "importFences", fences::import)
            .about("safety", "Reads a GeoJSON or a plan of QGroundControl. Nothing is put in force by it.")
            .takes::<FenceFileBody>()
            .json::<ImportedFencePlan>(StatusCode::OK, "What it says."),
        Endpoint::get("/api/v1/fences/geojson", "exportFences", fences::export)
            .about("safety", "The fences in force as GeoJSON.")
            .answer(
                StatusCode::OK,
                "A feature collection.",
                Some(("application/geo+json", schema_of::<serde_json::Map<String, serde_json::Value>>)),
            ),
    ]
}
