//! What calls cost: many instances of the plugin that ships, all called once per period by tasks of their own, as a node does it.
//! `cargo run --release -p skein-tests-plugin-boundary --example call_cost -- [instances] [seconds]`

use skein_domain::exchange::{Event, EventBatch, OwnState};
use skein_domain::telemetry::VehicleKinematics;
use skein_domain::{FlightMode, LandedState, NodeTime};
use skein_plugin_host::{Isolation, Runners};
use skein_tests_plugin_boundary::{create_uav, shipped};
use std::sync::Arc;
use std::time::{Duration, Instant};
use tokio::sync::watch;

const PERIOD: Duration = Duration::from_millis(20);

fn batch(now: NodeTime) -> EventBatch {
    // In the air and in OFFBOARD, so that every call makes a setpoint.
    let own = OwnState {
        kinematics: Some(VehicleKinematics {
            measured: now,
            ..Default::default()
        }),
        mode: FlightMode::Offboard,
        armed: true,
        landed: LandedState::InAir,
        link_connected: true,
        ..Default::default()
    };
    EventBatch {
        now,
        events: vec![Event::Own(own), Event::Tick],
    }
}

/// Processor time of this process so far in seconds.
fn processor_s() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields: Vec<_> = stat.rsplit(')').next().unwrap_or_default().split_whitespace().collect();
    let ticks = |i: usize| fields.get(i).and_then(|f| f.parse::<f64>().ok()).unwrap_or_default();
    (ticks(11) + ticks(12)) / 100.0
}

#[tokio::main(worker_threads = 2)]
async fn main() {
    let argument = |i: usize, default: u64| std::env::args().nth(i).and_then(|a| a.parse().ok()).unwrap_or(default);
    let (instances, seconds) = (argument(1, 100), argument(2, 5));
    let (runners, plugin) = (Runners::new(2, Duration::from_millis(50)), shipped("generic-uav"));
    let (beat, beats) = watch::channel(NodeTime(0));
    let mut tasks = Vec::new();
    for id in 0..instances {
        let create = create_uav(id as u16, "{}", None);
        let instance = runners
            .create(Arc::clone(&plugin), Isolation::InProcess, create)
            .await
            .expect("is created");
        let mut beats = beats.clone();
        tasks.push(tokio::spawn(async move {
            let mut slowest = Duration::ZERO;
            while beats.changed().await.is_ok() {
                let now = *beats.borrow_and_update();
                let asked = Instant::now();
                instance.call(batch(now), &[]).await.expect("answers");
                slowest = slowest.max(asked.elapsed());
            }
            (instance.statistics(), slowest)
        }));
    }
    let (began, before_s) = (Instant::now(), processor_s());
    let mut interval = tokio::time::interval(PERIOD);
    while began.elapsed() < Duration::from_secs(seconds) {
        interval.tick().await;
        let _ = beat.send(NodeTime(began.elapsed().as_micros() as u64));
    }
    drop(beat);
    let (wall_s, used_s) = (began.elapsed().as_secs_f64(), processor_s() - before_s);
    let (mut calls, mut p99_us, mut slowest) = (0, 0.0_f64, Duration::ZERO);
    for task in tasks {
        let (statistics, took) = task.await.expect("ended well");
        calls += statistics.calls;
        p99_us = p99_us.max(statistics.p99_us);
        slowest = slowest.max(took);
    }
    println!(
        "{instances} instances, {calls} calls in {wall_s:.1} s: {:.1} % of one core, {:.1} µs per call in all; \
         inside the plugin p99 at most {p99_us:.0} µs; slowest round trip {slowest:?}",
        100.0 * used_s / wall_s,
        1e6 * used_s / calls as f64,
    );
}
