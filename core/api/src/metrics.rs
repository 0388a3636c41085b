//! `/metrics` in Prometheus' text format: what the program counted (the `metrics` crate's global recorder), and the state of this
//! node's fleet at the moment of the scrape.
//!
//! The fleet's part is made anew for each scrape with a recorder of its own: a vehicle that is gone is gone from it, and two nodes
//! in one process do not mix. Must never do: keep state per vehicle.

use metrics::{counter, gauge};
use metrics_exporter_prometheus::{PrometheusBuilder, PrometheusHandle};
use skein_domain::FlightState;
use skein_domain::payload::{PayloadKind, TrackSource};
use skein_runtime::{CameraVideo, NodeHandle, SeenCounts};
use skein_view::{
    ActorHealth, ActorStatus, FleetSnapshot, PayloadSnapshot, PluginHealth, RecorderStatus, RecorderWord,
    VehicleSnapshot,
};
use std::sync::OnceLock;
use std::time::Duration;

/// How often the recorder folds what it collected, so that it stays small when nobody scrapes.
pub const UPKEEP_EVERY: Duration = Duration::from_secs(5);

static RECORDER: OnceLock<Option<PrometheusHandle>> = OnceLock::new();

/// Installs the recorder, once for the whole process. If the process has another one already, its metrics go there.
pub fn install() {
    RECORDER.get_or_init(|| {
        let installed = PrometheusBuilder::new().install_recorder();
        installed
            .inspect_err(|error| tracing::warn!("counters are not shown at /metrics: {error}"))
            .ok()
    });
    metrics::describe_gauge!("skein_streams_open", "Event streams that are open.");
    metrics::describe_counter!(
        "skein_stream_events_missed_total",
        "Events that readers of a stream missed because they were slow."
    );
}

/// Folds what the recorder collected.
pub fn upkeep() {
    if let Some(Some(handle)) = RECORDER.get() {
        handle.run_upkeep();
    }
}

/// Everything, as Prometheus reads it.
#[must_use]
pub fn render(node: &NodeHandle) -> String {
    let mut text = RECORDER
        .get()
        .and_then(Option::as_ref)
        .map(PrometheusHandle::render)
        .unwrap_or_default();
    text.push_str(&render_node(node));
    text
}

fn render_node(node: &NodeHandle) -> String {
    let recorder = PrometheusBuilder::new().build_recorder();
    metrics::with_local_recorder(&recorder, || {
        let (snapshot, now) = (node.snapshot(), node.now());
        gauge!("skein_info", "version" => env!("CARGO_PKG_VERSION"), "node" => node.name().to_owned()).set(1.0);
        gauge!("skein_uptime_seconds").set(now.as_seconds());
        gauge!("skein_snapshot_age_seconds").set(now.seconds_since(snapshot.time).max(0.0));
        describe();
        describe_tracks();
        recording(&node.recorder(), node.tape().dropped());
        fleet(&snapshot);
        tracks(&snapshot, &node.seen_counts());
        node.streams().videos().iter().for_each(video);
        for (name, counters) in node.endpoint_metrics() {
            endpoint(&name, &counters.read().named());
        }
    });
    recorder.handle().render()
}

fn describe() {
    use metrics::describe_gauge;
    describe_gauge!("skein_info", "Version and name of the node.");
    describe_gauge!("skein_uptime_seconds", "How long the node has been running.");
    describe_gauge!(
        "skein_snapshot_age_seconds",
        "Age of the newest picture of the fleet; grows if the control loop stands still."
    );
    describe_gauge!("skein_vehicles", "Vehicles in each flight state.");
    describe_gauge!("skein_vehicles_unadopted", "Vehicles that are heard but not flown.");
    describe_gauge!(
        "skein_formation_members",
        "Vehicles in the formation; 0 if none is flown."
    );
    describe_gauge!("skein_vehicle_connected", "1 if frames of the vehicle arrive.");
    describe_gauge!("skein_vehicle_armed", "1 if its motors are armed.");
    describe_gauge!("skein_vehicle_age_seconds", "Since when it was not heard.");
    describe_gauge!("skein_vehicle_link_loss_ratio", "Share of frames lost on the way here.");
    describe_gauge!("skein_vehicle_receive_rate_hertz", "Frames received per second.");
    describe_gauge!("skein_vehicle_setpoint_rate_hertz", "Setpoints sent per second.");
    describe_gauge!("skein_vehicle_round_trip_seconds", "Round trip on the link.");
    describe_gauge!("skein_vehicle_battery_ratio", "Remaining charge.");
    describe_gauge!(
        "skein_vehicle_tracking_error_metres",
        "Distance to where its task wants it."
    );
    describe_gauge!("skein_actor_up", "1 if the actor or model instance is running.");
    describe_gauge!("skein_plugin_restarts", "How often the instance was started again.");
    describe_gauge!("skein_plugin_call_p50_seconds", "Median time of a call into it.");
    describe_gauge!(
        "skein_plugin_call_p99_seconds",
        "99th percentile of the time of a call into it."
    );
    metrics::describe_counter!("skein_actor_restarts_total", "How often it was started again.");
    describe_gauge!("skein_video_rate_hertz", "Pictures per second of a camera.");
    describe_gauge!(
        "skein_video_lost_ratio",
        "Share of a camera's pictures lost on their way here."
    );
    describe_gauge!("skein_video_viewers", "How many look at a camera.");
    describe_gauge!("skein_video_age_seconds", "Since when no picture of a camera came.");
    describe_gauge!(
        "skein_video_glass_to_glass_p50_seconds",
        "Median of the time from a camera's picture to the eyes, as a viewer told it."
    );
    describe_gauge!(
        "skein_video_glass_to_glass_p99_seconds",
        "99th percentile of the time from a camera's picture to the eyes, as a viewer told it."
    );
}

/// Nothing where flights are not to be recorded.
fn recording(status: &RecorderStatus, dropped: u64) {
    if status.state == RecorderWord::Off {
        return;
    }
    metrics::describe_gauge!(
        "skein_recorder_recording",
        "1 while flights are recorded; 0 while the disk does not take them."
    );
    metrics::describe_counter!(
        "skein_recorder_dropped_total",
        "Messages that were not recorded, because the disk did not take them in time."
    );
    let records = status.state == RecorderWord::Recording;
    gauge!("skein_recorder_recording").set(f64::from(u8::from(records)));
    counter!("skein_recorder_dropped_total").absolute(dropped);
}

fn describe_tracks() {
    use metrics::describe_gauge;
    describe_gauge!("skein_tracks", "What is tracked, by who says so.");
    describe_gauge!(
        "skein_detector_pictures_dropped",
        "Pictures that a detector did not look at, as it says itself."
    );
    describe_gauge!(
        "skein_camera_to_track_p50_seconds",
        "Median of the time from the taking of a picture until the tracks know what is in it, where this node makes them."
    );
    describe_gauge!("skein_camera_to_track_p95_seconds", "95th percentile of the same.");
    metrics::describe_counter!(
        "skein_sightings_total",
        "What sensors saw: cameras of this node's vehicles, others as told over the API, those of other nodes."
    );
    metrics::describe_counter!(
        "skein_sightings_dropped_total",
        "What sensors saw and nobody worked on, because it was too much."
    );
}

fn tracks(snapshot: &FleetSnapshot, seen: &SeenCounts) {
    for (source, word) in [(TrackSource::Told, "told"), (TrackSource::Fused, "fused")] {
        let count = snapshot.tracks.iter().filter(|track| track.source == source).count();
        gauge!("skein_tracks", "source" => word).set(count as f64);
    }
    for (sensor, count) in [
        ("camera", seen.by_cameras),
        ("told", seen.told),
        ("other_node", seen.heard),
    ] {
        counter!("skein_sightings_total", "sensor" => sensor).absolute(count);
    }
    counter!("skein_sightings_dropped_total").absolute(seen.dropped);
    if let Some((p50_us, p95_us)) = seen.camera_to_track_us {
        gauge!("skein_camera_to_track_p50_seconds").set(p50_us as f64 * 1e-6);
        gauge!("skein_camera_to_track_p95_seconds").set(p95_us as f64 * 1e-6);
    }
}

/// The gauges of a snapshot, in the recorder of the moment.
fn fleet(snapshot: &FleetSnapshot) {
    for state in FlightState::ALL {
        let count = snapshot
            .vehicles
            .iter()
            .filter(|vehicle| vehicle.flight_state == *state)
            .count();
        gauge!("skein_vehicles", "state" => state.word()).set(count as f64);
    }
    gauge!("skein_vehicles_unadopted").set(snapshot.unadopted.len() as f64);
    gauge!("skein_formation_members").set(
        snapshot
            .formation
            .as_ref()
            .map_or(0.0, |formation| formation.members.len() as f64),
    );
    for health in &snapshot.actors {
        actor(health);
    }
    for one in &snapshot.vehicles {
        vehicle(one);
        actor(&one.actor);
        plugin(&one.model);
        for payload in &one.payloads {
            plugin(&payload.plugin);
            detector(one, payload);
        }
    }
}

fn plugin(health: &PluginHealth) {
    actor(&health.as_actor());
    let labels = [("actor", health.name.clone()), ("plugin", health.plugin.clone())];
    gauge!("skein_plugin_restarts", &labels).set(health.restarts as f64);
    gauge!("skein_plugin_call_p50_seconds", &labels).set(health.call_p50_us * 1e-6);
    gauge!("skein_plugin_call_p99_seconds", &labels).set(health.call_p99_us * 1e-6);
}

/// What a detector says of itself beside what every one does.
fn detector(vehicle: &VehicleSnapshot, payload: &PayloadSnapshot) {
    let state = payload.state.as_ref().filter(|_| payload.kind == PayloadKind::Detector);
    let dropped = state.and_then(|state| state.get("dropped")?.as_f64());
    if let Some(dropped) = dropped {
        let labels = [("vehicle", vehicle.id.to_string()), ("payload", payload.name.clone())];
        gauge!("skein_detector_pictures_dropped", &labels).set(dropped);
    }
}

fn video(video: &CameraVideo) {
    let labels = [
        ("vehicle", video.vehicle.to_string()),
        ("payload", video.payload.clone()),
    ];
    let health = &video.health;
    gauge!("skein_video_rate_hertz", &labels).set(health.measured.rate_hz);
    gauge!("skein_video_lost_ratio", &labels).set(health.measured.lost);
    gauge!("skein_video_viewers", &labels).set(health.viewers as f64);
    if let Some(age_s) = health.age_s {
        gauge!("skein_video_age_seconds", &labels).set(age_s);
    }
    if let Some((p50_s, p99_s)) = health.glass_to_glass_s {
        gauge!("skein_video_glass_to_glass_p50_seconds", &labels).set(p50_s);
        gauge!("skein_video_glass_to_glass_p99_seconds", &labels).set(p99_s);
    }
}

fn vehicle(vehicle: &VehicleSnapshot) {
    let labels = [("vehicle", vehicle.id.to_string()), ("name", vehicle.name.clone())];
    let link = &vehicle.link;
    gauge!("skein_vehicle_connected", &labels).set(f64::from(u8::from(link.connected)));
    gauge!("skein_vehicle_armed", &labels).set(f64::from(u8::from(vehicle.armed)));
    gauge!("skein_vehicle_age_seconds", &labels).set(vehicle.age_s);
    gauge!("skein_vehicle_link_loss_ratio", &labels).set(f64::from(link.loss));
    gauge!("skein_vehicle_receive_rate_hertz", &labels).set(f64::from(link.receive_rate_hz));
    gauge!("skein_vehicle_setpoint_rate_hertz", &labels).set(f64::from(link.setpoint_rate_hz));
    // What is not known is left out: a zero would look like a measurement.
    if let Some(round_trip_s) = link.round_trip_s {
        gauge!("skein_vehicle_round_trip_seconds", &labels).set(f64::from(round_trip_s));
    }
    if let Some(remaining) = vehicle.battery.remaining {
        gauge!("skein_vehicle_battery_ratio", &labels).set(f64::from(remaining));
    }
    if let Some(tracking_error_m) = vehicle.tracking_error_m {
        gauge!("skein_vehicle_tracking_error_metres", &labels).set(tracking_error_m);
    }
}

fn endpoint(endpoint: &str, counts: &[(&'static str, u64)]) {
    for (name, count) in counts {
        let told = name.replace('_', " ");
        let name = format!("skein_endpoint_{name}_total");
        metrics::describe_counter!(name.clone(), format!("Of an endpoint: {told}."));
        counter!(name, "endpoint" => endpoint.to_owned()).absolute(*count);
    }
}

fn actor(health: &ActorHealth) {
    let labels = [("actor", health.name.clone())];
    gauge!("skein_actor_up", &labels).set(if health.status == ActorStatus::Running {
        1.0
    } else {
        0.0
    });
    counter!("skein_actor_restarts_total", &labels).absolute(u64::from(health.incarnation.0.saturating_sub(1)));
}

#[cfg(test)]
mod tests;
