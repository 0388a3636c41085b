//! The route about going on after a restart in flight, for the table.

use super::Endpoint;
use crate::protocol::ResumeBody;
use crate::resume;
use axum::http::StatusCode;

/// Going on.
pub(super) fn resume() -> Vec<Endpoint> {
    vec![
        Endpoint::post("/api/v1/resume", "resume", resume::resume)
            .about(
                "commands",
                "Answers what an operator is asked (`resume` of the fleet) after the node ended in flight and has started again: whether the vehicles that it took back, and that hold, fly on.",
            )
            .takes::<ResumeBody>()
            .answer(StatusCode::NO_CONTENT, "They fly on, or what was flown is forgotten.", None)
            .fails(&[403, 409]),
    ]
}
