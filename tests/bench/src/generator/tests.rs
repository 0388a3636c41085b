//! Load generator and bare loop against each other, over real sockets.

use super::*;
use crate::bare::{BareLoopSettings, serve};

/// How often a vehicle sends, all its streams together.
const LOAD_HZ: f64 = 115.0;

/// Whether each stream has sent all that is due and no more, however late the ticks came.
fn is_up_to_date(generator: &mut Generator) -> bool {
    let before_s = generator.started.elapsed().as_secs_f64();
    generator.send_due();
    let after_s = generator.started.elapsed().as_secs_f64();
    let mut due = generator.posts.iter().flat_map(|post| post.due_s.iter().zip(STREAMS));
    due.all(|(due_s, (_, rate_hz))| *due_s > before_s && *due_s - 1.0 / rate_hz <= after_s)
}

/// How many messages were due until each stream's next.
fn due_so_far(generator: &Generator) -> f64 {
    let due = generator.posts.iter().flat_map(|post| post.due_s.iter().zip(STREAMS));
    due.map(|(due_s, (_, rate_hz))| due_s * rate_hz).sum()
}

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
        let before = due_so_far(&generator);
        while generator.window_started.elapsed().as_secs_f64() < 1.0 {
            generator.turn().unwrap();
        }
        assert!(is_up_to_date(&mut generator));
        let wanted = due_so_far(&generator) - before;
        assert!(
            (generator.sent as f64 - wanted).abs() < 1e-3,
            "{} sent of {wanted}",
            generator.sent
        );
        generator.figures()
    });
    let figures = figures.await.unwrap();
    serving.abort();
    assert_eq!(
        (figures.vehicles_streaming, figures.misaddressed, figures.not_sent),
        (8, 0, 0),
        "{figures:?}"
    );
    let sums_up: f64 = STREAMS.iter().map(|(_, rate_hz)| rate_hz).sum();
    assert_eq!(sums_up, LOAD_HZ);
    assert!(
        figures.telemetry_hz_per_vehicle > 0.0 && figures.setpoint_hz_per_vehicle > 0.0,
        "{figures:?}"
    );
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
