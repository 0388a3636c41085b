//! The links of this node as one answer: what came and went over its endpoints, and how each vehicle is heard.
//!
//! Must never do: open or close anything. It reads counters and the newest snapshot.

use crate::app::App;
use crate::protocol::{EndpointReport, LinkReport, VehicleLinkReport};
use axum::Json;
use axum::extract::State;
use skein_view::VehicleSnapshot;

pub(crate) async fn links(State(app): State<App>) -> Json<LinkReport> {
    let snapshot = app.node.snapshot();
    let addresses = app.node.endpoint_addresses();
    let mut endpoints: Vec<EndpointReport> = app
        .node
        .endpoint_metrics()
        .into_iter()
        .map(|(name, counters)| {
            let counters = counters.read();
            EndpointReport {
                address: addresses.get(name.as_ref()).map(ToString::to_string),
                name: name.to_string(),
                bytes_in: counters.bytes_in,
                frames_in: counters.frames_in,
                bytes_out: counters.bytes_out,
                frames_out: counters.frames_out,
                damaged: counters.bad_crc + counters.truncated + counters.undecodable,
                foreign: counters.foreign,
                unadopted: counters.unadopted,
                dropped: counters.dropped_full + counters.dropped_error,
            }
        })
        .collect();
    endpoints.sort_by(|a, b| a.name.cmp(&b.name));
    Json(LinkReport {
        time: app.node.now(),
        endpoints,
        vehicles: snapshot.vehicles.iter().map(of_vehicle).collect(),
    })
}

fn of_vehicle(vehicle: &VehicleSnapshot) -> VehicleLinkReport {
    VehicleLinkReport {
        id: vehicle.id,
        name: vehicle.name.clone(),
        node: vehicle.node,
        age_s: vehicle.age_s,
        link: vehicle.link,
        ways: vehicle.ways.clone(),
    }
}
