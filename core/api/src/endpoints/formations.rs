//! The routes about formations, for the table.

use super::Endpoint;
use crate::protocol::{FormationAnswer, FormationPreview, ReferenceList, RouteBody};
use crate::{references, routes};
use axum::http::StatusCode;
use skein_coordination::ReferenceReport;
use skein_domain::{FormationRequest, Route};
use skein_view::FormationReceipt;

/// The formation, its route, and what it may be anchored to.
pub(super) fn formations() -> Vec<Endpoint> {
    vec![
        Endpoint::get("/api/v1/formation", "getFormation", routes::formation)
            .about("formation", "The formation that is flown.")
            .json::<FormationAnswer>(StatusCode::OK, "The formation, or null."),
        Endpoint::put("/api/v1/formation", "setFormation", routes::set_formation)
            .about(
                "formation",
                "Flies a formation, from wherever the vehicles are now; or changes the one that is flown.",
            )
            .takes::<FormationRequest>()
            .json::<FormationReceipt>(StatusCode::OK, "It has begun; how it will look.")
            .fails(&[404, 409]),
        Endpoint::post("/api/v1/formation/preview", "previewFormation", references::preview)
            .about(
                "formation",
                "Where the places of a formation would be, without flying it.",
            )
            .takes::<FormationRequest>()
            .json::<FormationPreview>(StatusCode::OK, "The places.")
            .fails(&[409]),
        Endpoint::delete("/api/v1/formation", "dissolveFormation", routes::dissolve_formation)
            .about("formation", "Ends the formation; its members hold.")
            .answer(StatusCode::NO_CONTENT, "It has ended.", None)
            .fails(&[409]),
        Endpoint::put("/api/v1/formation/route", "setRoute", routes::set_route)
            .about(
                "formation",
                "Has the leader fly a route, with the formation behind it, as fast as the formation can.",
            )
            .takes::<RouteBody>()
            .json::<Route>(StatusCode::ACCEPTED, "It has begun; the route as it is flown.")
            .fails(&[409]),
        Endpoint::get("/api/v1/references", "getReferences", references::list)
            .about("formation", "Things that move and that formations may be anchored to.")
            .json::<ReferenceList>(StatusCode::OK, "The references."),
        Endpoint::put("/api/v1/references/{name}", "tellReference", references::tell)
            .about(
                "formation",
                "Tells where a reference is: 1 to 10 times a second while it moves.",
            )
            .with::<String>("name")
            .takes::<ReferenceReport>()
            .answer(StatusCode::NO_CONTENT, "It is known.", None)
            .fails(&[409]),
        Endpoint::delete("/api/v1/references/{name}", "forgetReference", references::forget)
            .about(
                "formation",
                "Forgets a reference. A formation that follows it stands where it was.",
            )
            .with::<String>("name")
            .answer(StatusCode::NO_CONTENT, "It is forgotten.", None)
            .fails(&[404]),
    ]
}
