//! The routes about parameters of autopilots, for the table.

use super::Endpoint;
use crate::parameters::{self, ParameterQuery};
use crate::protocol::{Accepted, ParameterBody, ParameterName, ReadingBody};
use axum::http::StatusCode;
use skein_domain::{ParameterList, VehicleId};
use skein_runtime::ParameterReceipt;

/// What an autopilot is set to.
pub(super) fn parameters() -> Vec<Endpoint> {
    vec![
        Endpoint::get("/api/v1/vehicles/{id}/parameters", "getParameters", parameters::list)
            .about(
                "parameters",
                "What is known of the parameters of a vehicle's autopilot, and how far the reading of all has come. With `read` it is \
                 begun, with `since` only what has changed is given.",
            )
            .with::<VehicleId>("id")
            .asks::<ParameterQuery>()
            .json::<ParameterList>(StatusCode::OK, "The parameters.")
            .fails(&[400, 404, 409]),
        Endpoint::post("/api/v1/vehicles/{id}/parameters/reading", "readParameters", parameters::read)
            .about("parameters", "Begins to read all parameters, or what is missing of them, or ends that.")
            .with::<VehicleId>("id")
            .takes::<ReadingBody>()
            .json::<Accepted>(StatusCode::ACCEPTED, "So it is done.")
            .fails(&[404, 409]),
        Endpoint::put("/api/v1/vehicles/{id}/parameters/{name}", "writeParameter", parameters::write)
            .about(
                "parameters",
                "Writes a parameter and waits until the autopilot says that it keeps it. Refused while the vehicle is armed, or another \
                 operator has control authority over it. It is read first if its type is not known; no type is guessed.",
            )
            .with::<VehicleId>("id")
            .with::<ParameterName>("name")
            .takes::<ParameterBody>()
            .json::<ParameterReceipt>(StatusCode::OK, "It is kept.")
            .fails(&[404, 409]),
    ]
}
