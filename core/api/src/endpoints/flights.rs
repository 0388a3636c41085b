//! The routes about recordings of flights, for the table.

use super::{Endpoint, schema_of};
use crate::flights;
use crate::protocol::FlightList;
use axum::http::StatusCode;

const FLIGHTS: &str = "flights";

pub(super) fn flights() -> Vec<Endpoint> {
    vec![
        Endpoint::get("/api/v1/flights", "getFlights", flights::list)
            .about(
                FLIGHTS,
                "Recordings of flights on this node, the newest first. At most 500 are named.",
            )
            .json::<FlightList>(StatusCode::OK, "The recordings."),
        Endpoint::get("/api/v1/flights/{file}", "getFlight", flights::file)
            .about(FLIGHTS, "A recording as an MCAP file, also of the flight under way.")
            .with::<String>("file")
            .answer(
                StatusCode::OK,
                "The file.",
                Some(("application/octet-stream", schema_of::<String>)),
            )
            .fails(&[400, 404]),
        Endpoint::get("/api/v1/flights/{file}/report", "getFlightReport", flights::report)
            .about(
                FLIGHTS,
                "The report of a flight, also of the one under way: a page of HTML that needs nothing else.",
            )
            .with::<String>("file")
            .answer(StatusCode::OK, "The report.", Some(("text/html", schema_of::<String>)))
            .fails(&[400, 404]),
    ]
}
