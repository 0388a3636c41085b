//! What is learnt of the air from six recorded vehicles that fly a route: the drag of PX4's own simulation, 1.0 in 1/s.

use crate::log;
use skein_domain::NodeTime;
use skein_flight::DragEstimator;
use skein_flight::drag::Look;
use skein_link_mavlink::EndpointCounters;
use skein_link_mavlink::decode::{decode, heartbeat};
use skein_link_mavlink::frame::each_in_datagram;
use skein_link_mavlink::vehicle::VehicleCore;
use skein_px4::LinkSettings;
use std::sync::Arc;

/// The control period in seconds, in which a node looks at its vehicles.
const PERIOD_S: f64 = 0.02;

/// The drag that a node would have found after each of these times in seconds.
fn found(system_id: u8, after_s: &[f64]) -> Vec<f64> {
    let settings = Arc::new(LinkSettings::default());
    let mut core: Option<VehicleCore> = None;
    let mut estimator = DragEstimator::default();
    let (mut due, mut found) = (NodeTime::default(), Vec::new());
    for frame in log::read(&format!("route-of-six-system-{system_id}")) {
        let now = frame.now();
        if frame.system_id() != system_id {
            continue;
        }
        each_in_datagram(&frame.bytes, &mut EndpointCounters::default(), |_, got| {
            if core.is_none() {
                let first = heartbeat(got);
                core = first.map(|first| VehicleCore::new(Arc::clone(&settings), system_id, &first, now));
                due = now;
            }
            if let Some(core) = &mut core {
                core.on_frame(now, &got.header, decode(got).and_then(Result::ok));
            }
        });
        while let Some(core) = core.as_mut().filter(|_| due <= now) {
            let (telemetry, _) = core.read(due);
            if let Some(velocity) = telemetry.velocity {
                estimator.see(Look {
                    time: telemetry.position_time,
                    velocity,
                    roll_rad: f64::from(telemetry.roll_rad),
                    pitch_rad: f64::from(telemetry.pitch_rad),
                    yaw_rad: f64::from(telemetry.yaw_rad),
                });
            }
            due = due.plus_seconds(PERIOD_S);
        }
        if after_s.get(found.len()).is_some_and(|after_s| frame.time_s >= *after_s) {
            found.push(estimator.drag_per_s());
        }
    }
    found
}

#[test]
fn a_real_autopilots_drag_is_found_in_flight() {
    for system_id in 1..=6 {
        // The route begins some eight seconds into the recordings.
        let found = found(system_id, &[12.0, 18.0, 28.0, 50.0]);
        println!("system {system_id}: {found:.3?}");
        for (per_s, at_least) in found.iter().zip([0.6, 0.8, 0.9, 0.95]) {
            assert!((at_least..=1.05).contains(per_s), "system {system_id}: {found:?}");
        }
    }
}
