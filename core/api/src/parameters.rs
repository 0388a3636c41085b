//! Routes about the parameters of a vehicle's autopilot.
//!
//! Must never do: write one without asking who has control authority over the vehicle.

use crate::app::App;
use crate::body::Body;
use crate::control::FromConsole;
use crate::error::ApiError;
use crate::protocol::{Accepted, ParameterBody, ReadingBody};
use axum::Json;
use axum::extract::rejection::{PathRejection, QueryRejection};
use axum::extract::{Path, Query, State};
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use schemars::JsonSchema;
use serde::Deserialize;
use skein_domain::{ParameterList, ParameterValue, ReadingAction, Refusal, VehicleId};
use skein_runtime::ParameterReceipt;

type OfVehicle = Result<Path<VehicleId>, PathRejection>;

/// What is asked of the parameters.
#[derive(Debug, Clone, Copy, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct ParameterQuery {
    /// The revision that is known already; everything that is known if left out.
    #[serde(default)]
    #[schemars(range(max = u64::MAX))]
    since: u64,
    /// Begins to read all of them, unless that is under way or done.
    #[serde(default)]
    read: bool,
}

pub(crate) async fn list(
    State(app): State<App>,
    id: OfVehicle,
    query: Result<Query<ParameterQuery>, QueryRejection>,
) -> Result<Json<ParameterList>, ApiError> {
    let (Path(id), Query(ParameterQuery { since, read })) = (id?, query?);
    if read {
        match app.node.read_parameters(id, ReadingAction::Begin) {
            // What was read before is known all the same.
            Ok(()) | Err(Refusal::LinkLost { .. }) => {}
            Err(refusal) => return Err(refusal.into()),
        }
    }
    Ok(Json(app.node.parameters(id, since)?))
}

pub(crate) async fn read(
    State(app): State<App>,
    id: OfVehicle,
    Body(body): Body<ReadingBody>,
) -> Result<Response, ApiError> {
    let Path(id) = id?;
    app.node.read_parameters(id, body.action)?;
    Ok((StatusCode::ACCEPTED, Json(Accepted { accepted: true })).into_response())
}

pub(crate) async fn write(
    State(app): State<App>,
    console: FromConsole,
    of: Result<Path<(VehicleId, String)>, PathRejection>,
    Body(body): Body<ParameterBody>,
) -> Result<Json<ParameterReceipt>, ApiError> {
    let Path((id, name)) = of?;
    let value = ParameterValue::of_number(body.value);
    Ok(Json(app.node.write_parameter(console.id(), id, &name, value).await?))
}
