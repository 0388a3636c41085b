//! Routes about control, where several operators sit at several screens; and which console a request comes from.
//!
//! Must never do: stand between a request to stop and the vehicles.

use crate::app::App;
use crate::body::Body;
use crate::error::ApiError;
use crate::protocol::{ControlBody, ControlReceipts, ControlState};
use axum::Json;
use axum::extract::{FromRequestParts, State};
use axum::http::request::Parts;
use skein_domain::control::LONGEST_CONSOLE_TEXT;
use skein_domain::{Refusal, VehicleId};
use std::convert::Infallible;

/// Names the console that a request comes from.
pub(crate) const HEADER: &str = "skein-console";

/// The console that a request comes from, if it says so. A request is a sign of its life.
pub(crate) struct FromConsole(Option<String>);

impl FromConsole {
    pub(crate) fn id(&self) -> Option<&str> {
        self.0.as_deref()
    }
}

impl FromRequestParts<App> for FromConsole {
    type Rejection = Infallible;

    async fn from_request_parts(parts: &mut Parts, app: &App) -> Result<Self, Infallible> {
        let shown = parts.headers.get(HEADER).and_then(|value| value.to_str().ok());
        let console = shown.filter(|id| !id.is_empty() && id.len() <= LONGEST_CONSOLE_TEXT);
        if let Some(console) = console {
            app.node.hear_console(console);
        }
        Ok(Self(console.map(str::to_owned)))
    }
}

pub(crate) async fn state(State(app): State<App>) -> Json<ControlState> {
    Json(ControlState {
        time: app.node.now(),
        vehicles: app.node.control(),
    })
}

pub(crate) async fn change(
    State(app): State<App>,
    Body(body): Body<ControlBody>,
) -> Result<Json<ControlReceipts>, ApiError> {
    let receipts = app.node.change_control(&body.targets, &body.console, &body.action)?;
    if receipts.is_empty() {
        return Err(Refusal::NotEnoughVehicles { have: 0, need: 1 }.into());
    }
    Ok(Json(ControlReceipts { receipts }))
}

/// Whether a console may move these vehicles; all of the node's picture if none are named.
pub(crate) fn may_move(app: &App, console: &FromConsole, vehicles: Option<&[VehicleId]>) -> Result<(), Refusal> {
    match vehicles {
        Some(vehicles) => app.node.may_command(console.id(), vehicles),
        None => {
            let all: Vec<VehicleId> = app.node.snapshot().vehicles.iter().map(|vehicle| vehicle.id).collect();
            app.node.may_command(console.id(), &all)
        }
    }
}
