//! The table of all routes: path, method, handler and what the published document says of it. Router and document are made from
//! the same table, so that neither can have a route that the other lacks.

mod carried;
mod control;
mod flights;
mod formations;
mod logs;
mod parameters;
mod replay;
mod resume;
mod safety;
mod swarm;
mod tracks;
mod trajectories;
mod upgrades;
mod video;

use crate::app::App;
use crate::example::Example;
use crate::links;
use crate::protocol::{
    Accepted, AcknowledgeBody, Acknowledged, CommandBody, CommandReceipts, EventList, Health, LinkReport, VehicleList,
    VersionInfo,
};
use crate::routes::{self, EventQuery};
use crate::stream::{self, StreamQuery};
use axum::extract::DefaultBodyLimit;
use axum::handler::Handler;
use axum::http::StatusCode;
use axum::routing::{MethodRouter, delete, get, patch, post, put};
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde_json::Value;
use skein_domain::VehicleId;
use skein_runtime::Fault;
use skein_view::{FleetSnapshot, VehicleSnapshot};
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
    /// Schema of the body, and one.
    pub(crate) body: Option<(SchemaOf, Value)>,
    /// The body is a file of this kind.
    pub(crate) file: Option<&'static str>,
    /// It becomes a WebSocket, which OpenAPI has no place for.
    pub(crate) is_websocket: bool,
    pub(crate) answers: Vec<DescribedAnswer>,
    /// Statuses of errors beside those that any route may give.
    pub(crate) errors: &'static [u16],
}

/// One answer that is not an error.
pub(crate) struct DescribedAnswer {
    pub(crate) status: StatusCode,
    pub(crate) description: &'static str,
    pub(crate) content: Option<(&'static str, SchemaOf)>,
}

const JSON: &str = "application/json";
/// The tag of live video, which no other node passes on.
pub(crate) const VIDEO: &str = "video";

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
            file: None,
            is_websocket: false,
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

    fn patch<H: Handler<T, App>, T: 'static>(path: &'static str, id: &'static str, handler: H) -> Self {
        Self::new(HttpMethod::Patch, path, id, patch(handler))
    }

    fn delete<H: Handler<T, App>, T: 'static>(path: &'static str, id: &'static str, handler: H) -> Self {
        Self::new(HttpMethod::Delete, path, id, delete(handler))
    }

    fn about(mut self, tag: &'static str, summary: &'static str) -> Self {
        (self.tag, self.summary) = (tag, summary);
        self
    }

    fn takes<T: JsonSchema + Example>(mut self) -> Self {
        self.body = Some((schema_of::<T>, T::example()));
        self
    }

    /// Takes an SDP offer.
    fn takes_sdp(mut self) -> Self {
        self.file = Some("application/sdp");
        self
    }

    /// Takes bodies up to this length, instead of the one that is enough for JSON.
    fn takes_bytes(mut self, most: usize) -> Self {
        self.handler = self.handler.layer(DefaultBodyLimit::max(most));
        self.file = Some("application/octet-stream");
        self
    }

    fn websocket(mut self) -> Self {
        self.is_websocket = true;
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
        self.answers.push(DescribedAnswer {
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
    all.extend(parameters::parameters());
    all.extend(control::control());
    all.extend(formations::formations());
    all.extend(trajectories::trajectories());
    all.extend(safety::safety());
    all.extend(swarm::swarm());
    all.extend(upgrades::upgrades());
    all.extend(resume::resume());
    all.extend(carried::plugins());
    all.extend(carried::payloads());
    all.extend(carried::instances());
    all.extend(tracks::tracks());
    all.extend(video::videos());
    all.extend(video::recordings());
    all.extend(flights::flights());
    all.extend(logs::logs());
    all.extend(replay::replay());
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
        Endpoint::post("/api/v1/events/acknowledge", "acknowledge", routes::acknowledge)
            .about("node", "Marks alerts (events that are warnings or worse) as seen; all pages of this node hear of it as an event.")
            .takes::<AcknowledgeBody>()
            .json::<Acknowledged>(StatusCode::OK, "They count as seen."),
        Endpoint::post("/api/v1/faults", "injectFault", routes::inject_fault)
            .about("node", "Injects a fault, for drills and tests. Only where the configuration permits it.")
            .takes::<Fault>()
            .json::<Accepted>(StatusCode::ACCEPTED, "It was injected; what comes of it comes as events.")
            .fails(&[404, 409]),
        Endpoint::get("/api/v1/stream", "openStream", stream::open)
            .about(
                "node",
                "A WebSocket: binary telemetry frames and, as text, the messages of the schema. A client may send the messages \
                 of the schema ClientMessage: another rate of frames, and the sticks of a vehicle that is steered by hand.",
            )
            .websocket()
            .asks::<StreamQuery>()
            .json::<crate::protocol::ServerMessage>(StatusCode::SWITCHING_PROTOCOLS, "The stream is open. The schema is that of its text messages.")
            .fails(&[400, 426, 503]),
        Endpoint::get("/api/v1/links", "getLinks", links::links)
            .about("node", "What came and went over this node's endpoints, and how each vehicle is heard.")
            .json::<LinkReport>(StatusCode::OK, "The links."),
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
