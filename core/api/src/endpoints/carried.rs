//! The routes about plugins and payloads, for the table.

use super::{Endpoint, schema_of};
use crate::body::PayloadCommandBody;
use crate::payloads::{self, UploadQuery};
use crate::protocol::{Accepted, PayloadList, PluginList, RestartList, SupervisionTree};
use crate::supervision;
use axum::http::StatusCode;
use skein_config::PayloadRule;
use skein_domain::VehicleId;
use skein_runtime::UpgradeReceipt;
use skein_view::CommandReceipt;

/// No library that is uploaded is longer, in bytes.
const MOST_LIBRARY_BYTES: usize = 128 << 20;

/// What can be done about plugins.
pub(super) fn plugins() -> Vec<Endpoint> {
    vec![
        Endpoint::get("/api/v1/plugins", "getPlugins", payloads::plugins)
            .about("plugins", "Plugins that were found, and files that were not taken.")
            .json::<PluginList>(StatusCode::OK, "The plugins."),
        Endpoint::post("/api/v1/plugins/rescan", "rescanPlugins", payloads::rescan)
            .about("plugins", "Looks for new and changed libraries. A new version of a known plugin waits for its upgrade.")
            .json::<PluginList>(StatusCode::OK, "The plugins after that."),
        Endpoint::post("/api/v1/plugins/{name}/upgrade", "upgradePlugin", payloads::upgrade)
            .about(
                "plugins",
                "Exchanges all instances of a plugin for its newest version, in flight and with their state. If one does not come \
                 up, all go back.",
            )
            .with::<String>("name")
            .json::<UpgradeReceipt>(StatusCode::OK, "What became of each instance.")
            .fails(&[404, 409]),
        Endpoint::post("/api/v1/plugins/{name}/rollback", "rollBackPlugin", payloads::roll_back)
            .about("plugins", "Exchanges all instances of a plugin for the version that was active before.")
            .with::<String>("name")
            .json::<UpgradeReceipt>(StatusCode::OK, "What became of each instance.")
            .fails(&[404, 409]),
        Endpoint::delete("/api/v1/plugins/{name}", "removePlugin", payloads::remove)
            .about("plugins", "Forgets a plugin that nothing uses.")
            .with::<String>("name")
            .answer(StatusCode::NO_CONTENT, "It is forgotten.", None)
            .fails(&[404, 409]),
        Endpoint::get("/api/v1/plugins/restarts", "getRestarts", payloads::restarts)
            .about("plugins", "Restarts of plugin instances after failures, oldest first. A bounded number is kept.")
            .json::<RestartList>(StatusCode::OK, "The restarts."),
        Endpoint::get("/api/v1/supervision", "getSupervision", supervision::tree)
            .about("plugins", "The supervision tree: actors and plugin instances with state, incarnation, restarts and call times.")
            .json::<SupervisionTree>(StatusCode::OK, "The tree."),
        Endpoint::post("/api/v1/plugins/uploads", "uploadPlugin", payloads::upload)
            .about("plugins", "Takes a library, where the configuration permits it. It stays off until it is enabled.")
            .asks::<UploadQuery>()
            .takes_bytes(MOST_LIBRARY_BYTES)
            .json::<Accepted>(StatusCode::ACCEPTED, "It is kept, and off.")
            .fails(&[400, 403, 409, 413]),
        Endpoint::post("/api/v1/plugins/uploads/enable", "enableUpload", payloads::enable_upload)
            .about("plugins", "Enables an uploaded library.")
            .asks::<UploadQuery>()
            .json::<PluginList>(StatusCode::OK, "The plugins after that.")
            .fails(&[400, 403, 404, 409]),
    ]
}

/// What vehicles carry.
pub(super) fn payloads() -> Vec<Endpoint> {
    vec![
        Endpoint::get("/api/v1/vehicles/{id}/payloads", "getPayloads", payloads::list)
            .about("payloads", "What a vehicle carries, with health and state.")
            .with::<VehicleId>("id")
            .json::<PayloadList>(StatusCode::OK, "The payloads.")
            .fails(&[400, 404]),
        Endpoint::post("/api/v1/vehicles/{id}/payloads", "attachPayload", payloads::attach)
            .about("payloads", "Puts a payload on a vehicle.")
            .with::<VehicleId>("id")
            .takes::<PayloadRule>()
            .json::<Accepted>(StatusCode::ACCEPTED, "It is being started.")
            .fails(&[400, 404]),
        Endpoint::delete(
            "/api/v1/vehicles/{id}/payloads/{payload}",
            "detachPayload",
            payloads::detach,
        )
        .about("payloads", "Takes a payload off a vehicle.")
        .with::<VehicleId>("id")
        .with::<String>("payload")
        .answer(StatusCode::NO_CONTENT, "It is gone.", None)
        .fails(&[400, 404]),
        Endpoint::post(
            "/api/v1/vehicles/{id}/payloads/{payload}/command",
            "commandPayload",
            payloads::command,
        )
        .about(
            "payloads",
            "Gives a command to a payload. It has to fit the command schema of its plugin.",
        )
        .with::<VehicleId>("id")
        .with::<String>("payload")
        .takes::<PayloadCommandBody>()
        .json::<CommandReceipt>(StatusCode::OK, "It was taken up; how it goes on comes as events.")
        .fails(&[400, 404, 409]),
    ]
}

/// Single instances and their frames.
pub(super) fn instances() -> Vec<Endpoint> {
    vec![
        Endpoint::post(
            "/api/v1/vehicles/{id}/payloads/{payload}/restart",
            "restartPayload",
            payloads::restart,
        )
        .about(
            "payloads",
            "Starts a payload's plugin instance anew and forgets its failures.",
        )
        .with::<VehicleId>("id")
        .with::<String>("payload")
        .json::<Accepted>(StatusCode::ACCEPTED, "It is being started.")
        .fails(&[400, 404, 409]),
        Endpoint::get(
            "/api/v1/vehicles/{id}/payloads/{payload}/frame",
            "getFrame",
            payloads::frame,
        )
        .about("payloads", "The last frame of a camera as a picture.")
        .with::<VehicleId>("id")
        .with::<String>("payload")
        .answer(
            StatusCode::OK,
            "PNG, or JPEG if the camera gives that or H.264.",
            Some(("image/png", schema_of::<String>)),
        )
        .fails(&[400, 404]),
        Endpoint::post(
            "/api/v1/vehicles/{id}/model/restart",
            "restartModel",
            payloads::restart_model,
        )
        .about("payloads", "Starts a vehicle's model anew and forgets its failures.")
        .with::<VehicleId>("id")
        .json::<Accepted>(StatusCode::ACCEPTED, "It is being started.")
        .fails(&[400, 404, 409]),
    ]
}
