//! The routes about trajectories, for the table.

use super::Endpoint;
use crate::protocol::{TrajectoriesEnded, TrajectoryList};
use crate::trajectories;
use axum::http::StatusCode;
use skein_domain::{TrajectoryPlan, TrajectoryRequest};

/// Trajectories of single vehicles, in step with each other.
pub(super) fn trajectories() -> Vec<Endpoint> {
    vec![
        Endpoint::get("/api/v1/trajectories", "getTrajectories", trajectories::list)
            .about("trajectories", "How each vehicle is getting on with its trajectory.")
            .json::<TrajectoryList>(StatusCode::OK, "The trajectories, by vehicle."),
        Endpoint::post("/api/v1/trajectories", "flyTrajectories", trajectories::fly)
            .about(
                "trajectories",
                "Plans smooth ways through waypoints, in step with each other and from a common start, and flies them. Vehicles that \
                 are under way go on from their motion. If anything is against it, everything that is so is told and nothing changes.",
            )
            .takes::<TrajectoryRequest>()
            .json::<TrajectoryPlan>(StatusCode::ACCEPTED, "They will begin; how they will be flown.")
            .fails(&[404, 409]),
        Endpoint::post("/api/v1/trajectories/preview", "previewTrajectories", trajectories::preview)
            .about("trajectories", "The same plan without flying it.")
            .takes::<TrajectoryRequest>()
            .json::<TrajectoryPlan>(StatusCode::OK, "How they would be flown now.")
            .fails(&[404, 409]),
        Endpoint::delete("/api/v1/trajectories", "endTrajectories", trajectories::end)
            .about("trajectories", "Ends all trajectories; who flies one holds. For one vehicle: give it a command.")
            .json::<TrajectoriesEnded>(StatusCode::OK, "Whose have ended.")
            .fails(&[409]),
    ]
}
