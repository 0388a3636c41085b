//! The routes about logs that autopilots keep by themselves, for the table.

use super::Endpoint;
use crate::logs;
use crate::protocol::{AutopilotLogList, LogFetchAnswer};
use axum::http::StatusCode;
use skein_domain::{LogFetch, VehicleId};

const LOGS: &str = "logs";

pub(super) fn logs() -> Vec<Endpoint> {
    vec![
        Endpoint::get("/api/v1/vehicles/{id}/logs", "getAutopilotLogs", logs::list)
            .about(
                LOGS,
                "Logs on the card of a vehicle's autopilot (PX4: ULog). It is asked for them, on the ground alone.",
            )
            .with::<VehicleId>("id")
            .json::<AutopilotLogList>(StatusCode::OK, "The logs, by their numbers.")
            .fails(&[403, 404, 409]),
        Endpoint::post(
            "/api/v1/vehicles/{id}/logs/{number}/fetch",
            "fetchAutopilotLog",
            logs::fetch,
        )
        .about(
            LOGS,
            "Begins to fetch a log, to lie beside the recordings of flights. It is broken off when the vehicle is armed.",
        )
        .with::<VehicleId>("id")
        .with::<u16>("number")
        .json::<LogFetch>(StatusCode::ACCEPTED, "It is being fetched.")
        .fails(&[403, 404, 409]),
        Endpoint::get("/api/v1/vehicles/{id}/logs/fetch", "getLogFetch", logs::fetched)
            .about(LOGS, "The log of a vehicle that is being fetched, or was last.")
            .with::<VehicleId>("id")
            .json::<LogFetchAnswer>(StatusCode::OK, "How far it has come; null if none was."),
    ]
}
