//! Tests of the Prometheus text.

mod monitoring;

use super::*;
use crate::generated::golden::{flying_vehicle, unknown_vehicle};
use skein_domain::Incarnation;

fn rendered(snapshot: &FleetSnapshot) -> String {
    let recorder = PrometheusBuilder::new().build_recorder();
    metrics::with_local_recorder(&recorder, || {
        describe();
        fleet(snapshot);
    });
    recorder.handle().render()
}

#[test]
fn a_fleet_becomes_gauges_and_what_is_not_known_is_left_out() {
    let health = |name: &str, status, starts| ActorHealth {
        name: name.into(),
        status,
        incarnation: Incarnation(starts),
        ..ActorHealth::default()
    };
    let snapshot = FleetSnapshot {
        vehicles: vec![
            VehicleSnapshot {
                actor: health("vehicle-1", ActorStatus::Running, 3),
                ..flying_vehicle(1)
            },
            unknown_vehicle(2),
        ],
        actors: vec![health("coordinator", ActorStatus::Restarting, 1)],
        ..FleetSnapshot::default()
    };
    let text = rendered(&snapshot);
    for line in [
        "# TYPE skein_vehicles gauge",
        "skein_vehicles{state=\"leading\"} 1",
        "skein_vehicles{state=\"idle\"} 1",
        "skein_vehicles{state=\"faulted\"} 0",
        "skein_vehicle_connected{vehicle=\"1\",name=\"uav-1\"} 1",
        "skein_vehicle_connected{vehicle=\"2\",name=\"uav-2\"} 0",
        "skein_actor_up{actor=\"coordinator\"} 0",
        "skein_actor_up{actor=\"vehicle-1\"} 1",
        "skein_actor_restarts_total{actor=\"vehicle-1\"} 2",
        "skein_formation_members 0",
    ] {
        assert!(text.lines().any(|is| is == line), "{line:?} is not in\n{text}");
    }
    assert!(text.contains("skein_vehicle_round_trip_seconds{vehicle=\"1\""));
    assert!(
        !text.contains("skein_vehicle_round_trip_seconds{vehicle=\"2\""),
        "never measured"
    );
}

#[test]
fn tracks_are_counted_by_who_says_so() {
    let told = skein_domain::payload::TrackEstimate::told(skein_domain::payload::Track {
        track: 4,
        position: skein_domain::PositionNed::default(),
        velocity: skein_domain::VelocityNed::default(),
        time: skein_domain::NodeTime::default(),
        error_m: None,
    });
    let snapshot = FleetSnapshot {
        tracks: vec![told],
        ..FleetSnapshot::default()
    };
    let seen = SeenCounts {
        by_cameras: 7,
        dropped: 3,
        camera_to_track_us: Some((60_000, 90_000)),
        ..SeenCounts::default()
    };
    let recorder = PrometheusBuilder::new().build_recorder();
    metrics::with_local_recorder(&recorder, || tracks(&snapshot, &seen));
    let text = recorder.handle().render();
    for line in [
        "skein_tracks{source=\"told\"} 1",
        "skein_tracks{source=\"fused\"} 0",
        "skein_sightings_total{sensor=\"camera\"} 7",
        "skein_sightings_dropped_total 3",
        "skein_camera_to_track_p50_seconds 0.06",
    ] {
        assert!(text.lines().any(|is| is == line), "{line:?} is not in\n{text}");
    }
}

#[test]
fn a_name_cannot_break_out_of_its_label() {
    let vehicle = VehicleSnapshot {
        name: "a\"b\\c\nd".into(),
        ..unknown_vehicle(1)
    };
    let text = rendered(&FleetSnapshot {
        vehicles: vec![vehicle],
        ..FleetSnapshot::default()
    });
    assert!(text.contains("name=\"a\\\"b\\\\c\\nd\""), "{text}");
}

#[test]
fn installing_twice_is_no_error() {
    install();
    install();
    upkeep();
}
