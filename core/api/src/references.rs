//! Routes about references that formations may be anchored to, and about how a formation would look.

use crate::app::App;
use crate::body::Body;
use crate::error::ApiError;
use crate::protocol::{FormationPreview, ReferenceList, SlotView};
use axum::Json;
use axum::extract::rejection::PathRejection;
use axum::extract::{Path, State};
use axum::http::StatusCode;
use skein_coordination::ReferenceReport;
use skein_domain::{FormationRequest, OffsetFrd, Refusal};
use skein_flight::formation;
use skein_view::VehicleSnapshot;

/// No place of a formation is farther from its anchor along any axis, in metres.
const FARTHEST_PLACE_M: f64 = 100_000.0;

type Name = Result<Path<String>, PathRejection>;

pub(crate) async fn list(State(app): State<App>) -> Json<ReferenceList> {
    Json(ReferenceList {
        references: app.node.references(),
    })
}

pub(crate) async fn tell(
    State(app): State<App>,
    name: Name,
    Body(report): Body<ReferenceReport>,
) -> Result<StatusCode, ApiError> {
    let Path(name) = name?;
    app.node.tell_reference(&name, report)?;
    Ok(StatusCode::NO_CONTENT)
}

pub(crate) async fn forget(State(app): State<App>, name: Name) -> Result<StatusCode, ApiError> {
    let Path(name) = name?;
    app.node.forget_reference(&name)?;
    Ok(StatusCode::NO_CONTENT)
}

/// Where the places of a formation would be, without flying it.
pub(crate) async fn preview(
    State(app): State<App>,
    Body(request): Body<FormationRequest>,
) -> Result<Json<FormationPreview>, ApiError> {
    let snapshot = app.node.snapshot();
    let count = request
        .members
        .as_ref()
        .map_or(snapshot.vehicles.len(), Vec::len)
        .max(1);
    let takes_part = |id| request.members.as_ref().is_none_or(|members| members.contains(id));
    let looks = |vehicle: &&VehicleSnapshot| vehicle.limits.is_some_and(|limits| limits.keeps_view);
    let members = snapshot.vehicles.iter().filter(|vehicle| takes_part(&vehicle.id));
    let slots = formation::anchored_slots(&request, count).map_err(|e| Refusal::invalid(e.to_string()))?;
    if !slots.iter().all(is_near) {
        let detail = "the formation is larger than numbers mean anything about its anchor".to_owned();
        return Err(Refusal::InvalidValue { detail }.into());
    }
    let foreseen = app.node.foresee_formation(request.clone()).await;
    Ok(Json(FormationPreview {
        smallest_distance_m: Some(formation::smallest_distance_m(&slots)).filter(|d| d.is_finite()),
        views: formation::views(&slots).into_iter().map(view).collect(),
        looking: u32::try_from(members.filter(looks).count()).unwrap_or(u32::MAX),
        slots,
        refusal: foreseen.as_ref().err().cloned(),
        forecast: foreseen.ok(),
    }))
}

/// Whether a place is one that may be told: see [`OffsetFrd`]'s schema.
fn is_near(place: &OffsetFrd) -> bool {
    let along = [place.forward_m, place.right_m, place.down_m];
    along.iter().all(|along_m| along_m.abs() <= FARTHEST_PLACE_M)
}

fn view(view: formation::View) -> SlotView {
    match view {
        formation::View::Ahead => SlotView::Ahead,
        formation::View::Outward => SlotView::Outward,
        formation::View::Blocked => SlotView::Blocked,
    }
}
