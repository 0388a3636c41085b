//! The routes about control, for the table.

use super::Endpoint;
use crate::control;
use crate::protocol::{ControlBody, ControlReceipts, ControlState};
use axum::http::StatusCode;

/// Who has control authority over which vehicles.
pub(super) fn control() -> Vec<Endpoint> {
    vec![
        Endpoint::get("/api/v1/control", "getControl", control::state)
            .about("control", "Which console has control authority over which vehicles, and who asks for them. Nobody has it over the others: anybody may command them.")
            .json::<ControlState>(StatusCode::OK, "Those that somebody has."),
        Endpoint::post("/api/v1/control", "changeControl", control::change)
            .about(
                "control",
                "Takes control authority over vehicles, asks for it, hands it over, or releases it. Others' commands are refused then, but for hold, land, return and the emergency stop. A console says who it is with the header `Skein-Console`; one that is not heard for ten seconds may be relieved by anybody.",
            )
            .takes::<ControlBody>()
            .json::<ControlReceipts>(StatusCode::OK, "What came of it, vehicle by vehicle.")
            .fails(&[409, 422]),
    ]
}
