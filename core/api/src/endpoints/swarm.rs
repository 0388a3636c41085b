//! The routes about the swarm of several nodes, for the table.

use super::Endpoint;
use crate::protocol::CoordinatorBody;
use crate::swarm;
use axum::http::StatusCode;
use skein_view::SwarmSnapshot;

/// The nodes, and who coordinates.
pub(super) fn swarm() -> Vec<Endpoint> {
    vec![
        Endpoint::get("/api/v1/swarm", "getSwarm", swarm::swarm)
            .about(
                "swarm",
                "The swarm that this node is part of: its nodes, whom each obeys, how the links between them are.",
            )
            .json::<SwarmSnapshot>(StatusCode::OK, "The swarm, as this node knows it.")
            .fails(&[409]),
        Endpoint::post("/api/v1/swarm/coordinator", "makeCoordinator", swarm::make_coordinator)
            .about(
                "swarm",
                "Has a node take the leadership, although another one may hold it.",
            )
            .takes::<CoordinatorBody>()
            .answer(StatusCode::NO_CONTENT, "It coordinates.", None)
            .fails(&[403, 409]),
    ]
}
