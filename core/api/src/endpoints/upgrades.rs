//! The routes about other versions of the program, for the table.

use super::Endpoint;
use crate::upgrades::{self, RolloutBody};
use axum::http::StatusCode;
use skein_upgrade::MOST_ARCHIVE_BYTES;
use skein_view::{ArchiveInfo, UpgradeReport};

/// Archives, and roll-outs over the swarm.
pub(super) fn upgrades() -> Vec<Endpoint> {
    vec![
        Endpoint::get("/api/v1/upgrades", "getUpgrades", upgrades::report)
            .about("upgrades", "The version that this node runs, the archives that it keeps, how far the roll-out is that was begun at it.")
            .json::<UpgradeReport>(StatusCode::OK, "Everything about upgrades here.")
            .fails(&[403]),
        Endpoint::post("/api/v1/upgrades/archives", "sendArchive", upgrades::take_archive)
            .about(
                "upgrades",
                "Takes an archive, as `skein upgrade pack` makes it. One is kept for each kind of processor. Needs an operator with `may_upgrade`.",
            )
            .takes_bytes(MOST_ARCHIVE_BYTES as usize)
            .json::<ArchiveInfo>(StatusCode::OK, "It is whole, and kept.")
            .fails(&[401, 403, 409]),
        Endpoint::post("/api/v1/upgrades", "beginUpgrade", upgrades::begin)
            .about(
                "upgrades",
                "Begins a roll-out: one node after the other gets the archive for its processor and starts it on trial, the one that coordinates \
                 last. A node with an armed vehicle refuses. It stops at the first node whose new version does not stay. Needs an operator with \
                 `may_upgrade`.",
            )
            .takes::<RolloutBody>()
            .json::<UpgradeReport>(StatusCode::ACCEPTED, "It has begun.")
            .fails(&[401, 403, 404, 409]),
        Endpoint::post("/api/v1/upgrades/back", "beginBack", upgrades::back)
            .about("upgrades", "The same, back to the version that each node ran before.")
            .takes::<RolloutBody>()
            .json::<UpgradeReport>(StatusCode::ACCEPTED, "It has begun.")
            .fails(&[401, 403, 404, 409]),
        Endpoint::delete("/api/v1/upgrades", "stopUpgrade", upgrades::stop)
            .about("upgrades", "Has a roll-out go no further than the node whose turn it is.")
            .json::<UpgradeReport>(StatusCode::OK, "It will stop there.")
            .fails(&[401, 403]),
    ]
}
