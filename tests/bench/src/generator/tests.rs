//! Load generator and bare loop against each other, over real sockets.

use super::*;
use crate::bare::{BareLoopSettings, serve};

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn every_vehicle_sends_its_load_and_gets_its_setpoints() {
    let socket = tokio::net::UdpSocket::bind("127.0.0.1:0").await.unwrap();
    let settings = LoadGeneratorSettings {
        vehicles: 8,
        target: socket.local_addr().unwrap(),
        reserved_system_ids: vec![3, 245],
    };
    let serving = tokio::spawn(serve(socket, BareLoopSettings::default()));
    let figures = tokio::task::spawn_blocking(move || {
        let mut generator = Generator::new(&settings).unwrap();
        while generator.gaps.streaming() < 8 {
            generator.turn().unwrap();
        }
        generator.begin();
        while generator.window_started.elapsed().as_secs_f64() < 1.0 {
            generator.turn().unwrap();
        }
        generator.figures()
    });
    let figures = figures.await.unwrap();
    serving.abort();
    assert_eq!(
        (figures.vehicles_streaming, figures.misaddressed, figures.not_sent),
        (8, 0, 0),
        "{figures:?}"
    );
    // A late tick is made up for: however busy the machine, the load is what it should be.
    assert!((figures.telemetry_hz_per_vehicle - 115.0).abs() < 15.0, "{figures:?}");
    assert!((5.0..80.0).contains(&figures.setpoint_hz_per_vehicle), "{figures:?}");
    assert!(
        figures.gaps.p50_ms > 5.0 && figures.gaps.p50_ms <= figures.gaps.max_ms,
        "{figures:?}"
    );
}

#[test]
fn settings_that_make_no_sense_are_refused() {
    assert!(matches!(run_load_generator("{"), Err(BenchError::Settings(_))));
    let settings = |vehicles| LoadGeneratorSettings {
        vehicles,
        target: SocketAddr::from(([127, 0, 0, 1], 9)),
        reserved_system_ids: (10..=250).collect(),
    };
    assert!(matches!(Generator::new(&settings(0)), Err(BenchError::Argument(_))));
    assert!(matches!(Generator::new(&settings(10)), Err(BenchError::Argument(_))));
    assert_eq!(Generator::new(&settings(9)).unwrap().posts.len(), 9);
}
