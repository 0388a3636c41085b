//! The table of all routes: path, method, handler and what the published document says of it. Router and document are made from
//! the same table, so that neither can have a route that the other lacks.

use crate::app::App;
use crate::body::{PayloadCommandBody, TracksBody};
use crate::payloads::{self, UploadQuery};
use crate::protocol::{
    Accepted, CommandBody, CommandReceipts, EventList, FormationAnswer, Health, PayloadList, PluginList, RestartList,
    RouteBody, VehicleList, VersionInfo,
};
use crate::routes::{self, EventQuery};
use crate::stream::{self, StreamQuery};
use axum::handler::Handler;
use axum::http::StatusCode;
use axum::routing::{MethodRouter, delete, get, post, put};
use schemars::{JsonSchema, Schema, SchemaGenerator};
use skein_config::PayloadRule;
use skein_domain::{FormationRequest, VehicleId};
use skein_runtime::{CommandReceipt, Fault, FleetSnapshot, FormationReceipt, UpgradeReceipt, VehicleSnapshot};
use utoipa::openapi::HttpMethod;

/// Makes the schema of a type in a document.
pub(crate) type SchemaOf = fn(&mut SchemaGenerator) -> Schema;

/// One route with one method.
pub(crate) struct Endpoint {
    pub(crate) path: &'static str,
    pub(crate) method: HttpMethod,
    pub(crate) handler: MethodRouter<App>,
    /// Unique name, for generated clients.
    pub(crate) id: &'static str,
    pub(crate) tag: &'static str,
    pub(crate) summary: &'static str,
    /// Names and schemas of the path's variables.
    pub(crate) variables: Vec<(&'static str, SchemaOf)>,
    /// Schema of the query, an object.
    pub(crate) query: Option<SchemaOf>,
    pub(crate) body: Option<SchemaOf>,
    pub(crate) answers: Vec<Answer>,
    /// Statuses of errors beside those that any route may give.
    pub(crate) errors: &'static [u16],
}

/// One answer that is not an error.
pub(crate) struct Answer {
    pub(crate) status: StatusCode,
    pub(crate) description: &'static str,
    pub(crate) content: Option<(&'static str, SchemaOf)>,
}

const JSON: &str = "application/json";

fn schema_of<T: JsonSchema>(generator: &mut SchemaGenerator) -> Schema {
    generator.subschema_for::<T>()
}

impl Endpoint {
    fn new(method: HttpMethod, path: &'static str, id: &'static str, handler: MethodRouter<App>) -> Self {
        Self {
            path,
            method,
            handler,
            id,
            tag: "",
            summary: "",
            variables: Vec::new(),
            query: None,
            body: None,
            answers: Vec::new(),
            errors: &[],
        }
    }

    fn get<H: Handler<T, App>, T: 'static>(path: &'static str, id: &'static str, handler: H) -> Self {
        Self::new(HttpMethod::Get, path, id, get(handler))
    }

    fn post<H: Handler<T, App>, T: 'static>(path: &'static str, id: &'static str, handler: H) -> Self {
        Self::new(HttpMethod::Post, path, id, post(handler))
    }

    fn put<H: Handler<T, App>, T: 'static>(path: &'static str, id: &'static str, handler: H) -> Self {
        Self::new(HttpMethod::Put, path, id, put(handler))
    }

    fn delete<H: Handler<T, App>, T: 'static>(path: &'static str, id: &'static str, handler: H) -> Self {
        Self::new(HttpMethod::Delete, path, id, delete(handler))
    }

    fn about(mut self, tag: &'static str, summary: &'static str) -> Self {
        (self.tag, self.summary) = (tag, summary);
        self
    }

    fn takes<T: JsonSchema>(mut self) -> Self {
        self.body = Some(schema_of::<T>);
        self
    }

    fn asks<T: JsonSchema>(mut self) -> Self {
        self.query = Some(schema_of::<T>);
        self
    }

    fn with<T: JsonSchema>(mut self, variable: &'static str) -> Self {
        self.variables.push((variable, schema_of::<T>));
        self
    }

    fn answer(
        mut self,
        status: StatusCode,
        description: &'static str,
        content: Option<(&'static str, SchemaOf)>,
    ) -> Self {
        self.answers.push(Answer {
            status,
            description,
            content,
        });
        self
    }

    fn json<T: JsonSchema>(self, status: StatusCode, description: &'static str) -> Self {
        self.answer(status, description, Some((JSON, schema_of::<T>)))
    }

    fn fails(mut self, errors: &'static [u16]) -> Self {
        self.errors = errors;
        self
    }
}

/// Every route.
pub(crate) fn all() -> Vec<Endpoint> {
    let mut all = node();
    all.extend(fleet());
    all.extend(formation());
    all.extend(plugins());
    all.extend(payloads());
    all
}

fn node() -> Vec<Endpoint> {
    vec![
        Endpoint::get("/api/v1/version", "getVersion", routes::version)
            .about("node", "Which program, which version, which node.")
            .json::<VersionInfo>(StatusCode::OK, "The version."),
        Endpoint::get("/api/v1/health", "getHealth", routes::health)
            .about("node", "Whether the node is well, for people and for whatever restarts it.")
            .json::<Health>(StatusCode::OK, "It runs; possibly degraded.")
            .json::<Health>(StatusCode::SERVICE_UNAVAILABLE, "The picture of the fleet is not renewed any more."),
        Endpoint::get("/api/v1/events", "getEvents", routes::events)
            .about("node", "What happened, oldest first. A bounded number is kept.")
            .asks::<EventQuery>()
            .json::<EventList>(StatusCode::OK, "The events.")
            .fails(&[400]),
        Endpoint::post("/api/v1/faults", "injectFault", routes::inject_fault)
            .about("node", "Injects a fault, for drills and tests. Only where the configuration permits it.")
            .takes::<Fault>()
            .json::<Accepted>(StatusCode::ACCEPTED, "It was injected; what comes of it comes as events.")
            .fails(&[404, 503]),
        Endpoint::get("/api/v1/stream", "openStream", stream::open)
            .about(
                "node",
                "A WebSocket: binary telemetry frames and, as text, the messages of the schema. A client may send the messages \
                 of the schema ClientMessage.",
            )
            .asks::<StreamQuery>()
            .json::<crate::protocol::ServerMessage>(StatusCode::SWITCHING_PROTOCOLS, "The stream is open. The schema is that of its text messages.")
            .fails(&[400, 426, 503]),
        Endpoint::get("/api/v1/openapi.json", "getDocument", routes::document)
            .about("node", "This document.")
            .json::<serde_json::Map<String, serde_json::Value>>(StatusCode::OK, "An OpenAPI 3.1 document."),
        Endpoint::get("/metrics", "getMetrics", routes::prometheus)
            .about("node", "Counters and gauges as Prometheus reads them.")
            .answer(StatusCode::OK, "Prometheus text format.", Some(("text/plain", schema_of::<String>))),
    ]
}

fn fleet() -> Vec<Endpoint> {
    vec![
        Endpoint::get("/api/v1/fleet", "getFleet", routes::fleet)
            .about("fleet", "The whole newest picture of the fleet.")
            .json::<FleetSnapshot>(StatusCode::OK, "The fleet."),
        Endpoint::get("/api/v1/vehicles", "getVehicles", routes::vehicles)
            .about("fleet", "All vehicles.")
            .json::<VehicleList>(StatusCode::OK, "The vehicles."),
        Endpoint::get("/api/v1/vehicles/{id}", "getVehicle", routes::vehicle)
            .about("fleet", "One vehicle.")
            .with::<VehicleId>("id")
            .json::<VehicleSnapshot>(StatusCode::OK, "The vehicle.")
            .fails(&[400, 404]),
        Endpoint::post("/api/v1/commands", "giveCommand", routes::command)
            .about(
                "fleet",
                "Gives a command to one, several or all vehicles. Each answers for itself: look into the receipts.",
            )
            .takes::<CommandBody>()
            .json::<CommandReceipts>(StatusCode::OK, "One receipt per vehicle; some or all may be refusals.")
            .fails(&[404, 409]),
    ]
}

fn plugins() -> Vec<Endpoint> {
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
        Endpoint::post("/api/v1/plugins/uploads", "uploadPlugin", payloads::upload)
            .about("plugins", "Takes a library, where the configuration permits it. It stays off until it is enabled.")
            .asks::<UploadQuery>()
            .json::<Accepted>(StatusCode::ACCEPTED, "It is kept, and off.")
            .fails(&[400, 403, 422]),
        Endpoint::post("/api/v1/plugins/uploads/enable", "enableUpload", payloads::enable_upload)
            .about("plugins", "Enables an uploaded library.")
            .asks::<UploadQuery>()
            .json::<PluginList>(StatusCode::OK, "The plugins after that.")
            .fails(&[400, 403, 404, 422]),
    ]
}

fn payloads() -> Vec<Endpoint> {
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
        .fails(&[400, 404, 409, 503]),
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
        .fails(&[400, 404, 503]),
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
            "PNG, or JPEG if the camera gives that.",
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
        .fails(&[400, 404, 503]),
        Endpoint::put("/api/v1/tracks", "setTracks", payloads::tracks)
            .about(
                "payloads",
                "Replaces what is tracked, for vehicles that are to observe it.",
            )
            .takes::<TracksBody>()
            .json::<Accepted>(StatusCode::ACCEPTED, "It is known from now on."),
    ]
}

fn formation() -> Vec<Endpoint> {
    vec![
        Endpoint::get("/api/v1/formation", "getFormation", routes::formation)
            .about("formation", "The formation that is flown.")
            .json::<FormationAnswer>(StatusCode::OK, "The formation, or null."),
        Endpoint::put("/api/v1/formation", "setFormation", routes::set_formation)
            .about("formation", "Flies a formation, from wherever the vehicles are now.")
            .takes::<FormationRequest>()
            .json::<FormationReceipt>(StatusCode::OK, "It has begun; how it will look.")
            .fails(&[404, 409, 503]),
        Endpoint::delete("/api/v1/formation", "dissolveFormation", routes::dissolve_formation)
            .about("formation", "Ends the formation; its members hold.")
            .answer(StatusCode::NO_CONTENT, "It has ended.", None)
            .fails(&[409, 503]),
        Endpoint::put("/api/v1/formation/route", "setRoute", routes::set_route)
            .about("formation", "Has the leader fly a route, with the formation behind it.")
            .takes::<RouteBody>()
            .json::<Accepted>(StatusCode::ACCEPTED, "It has begun.")
            .fails(&[409, 503]),
    ]
}
