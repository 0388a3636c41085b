//! The routes about a recorded flight that is shown again, for the table.

use super::Endpoint;
use crate::protocol::ReplayAnswer;
use crate::replay;
use axum::http::StatusCode;
use skein_replay::{ReplayChange, ReplayState, Timeline};

const REPLAY: &str = "replay";
const PATH: &str = "/api/v1/replay";

pub(super) fn replay() -> Vec<Endpoint> {
    vec![
        Endpoint::get(PATH, "getReplay", replay::state)
            .about(
                REPLAY,
                "Whether what is shown is a recorded flight, and where in it that is. Below `/replay/{file}/` a node has all routes of a recorded \
                 flight; those that would change something are refused there, but this one.",
            )
            .json::<ReplayAnswer>(StatusCode::OK, "The replay; null for a node that flies."),
        Endpoint::put(PATH, "changeReplay", replay::change)
            .about(
                REPLAY,
                "Goes to another moment of a recorded flight, on from there at another pace, or stands still.",
            )
            .takes::<ReplayChange>()
            .json::<ReplayState>(StatusCode::OK, "Where it is now.")
            .fails(&[409]),
        Endpoint::get("/api/v1/replay/timeline", "getReplayTimeline", replay::timeline)
            .about(
                REPLAY,
                "What happened in a recorded flight and when: events, and what people and programs did.",
            )
            .json::<Timeline>(StatusCode::OK, "The timeline; `complete` once the recording has been gone through.")
            .fails(&[409]),
    ]
}
