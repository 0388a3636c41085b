//! How long a swarm is without a coordinator: the ground station's node coordinates and is killed, twenty times, while five vehicles fly.
//!
//! The figures are printed, not judged: other programs run on the machine. What is judged is that every vehicle hears of a successor, and
//! that none of them is without setpoints meanwhile.

use skein_domain::Shape;
use skein_tests_multihost::field::{Field, GROUND, usual};
use skein_tests_multihost::host::LogLine;
use skein_tests_multihost::mission::Mission;

const KILLS: usize = 20;
const TOGETHER_S: f64 = 30.0;
/// Something is broken beyond this, in seconds.
const SANE_S: f64 = 15.0;
const ALL: [u8; 6] = [1, 2, 3, 4, 5, 6];

#[tokio::test(flavor = "multi_thread")]
async fn twenty_coordinators_are_killed() {
    let mut plans = usual();
    plans[0].priority = Some(100);
    let mut field = Field::start(30, plans);
    field.led_by(GROUND, &ALL, TOGETHER_S).await;
    let mut mission = Mission::new(&mut field, 2);
    mission.take_off().await;
    mission.form_up(Shape::Line).await;
    let (mut first, mut last) = (Vec::new(), Vec::new());
    for kill in 0..KILLS {
        let at_s = field.host_mut(GROUND).kill().await;
        let after = taken_up(&mut field, at_s).await;
        first.push(after.iter().copied().fold(f64::INFINITY, f64::min));
        last.push(after.iter().copied().fold(0.0, f64::max));
        println!("kill {kill}: {:.3} s to {:.3} s", first[kill], last[kill]);
        field.host_mut(GROUND).restart();
        // nobody takes the leadership from the successor unless asked to
        field.led_by(GROUND, &ALL, TOGETHER_S).await;
        // it has passed on at every vehicle before the next kill
        field.pass(1.0).await;
    }
    println!("first vehicle: {}", percentiles(first));
    println!("last vehicle:  {}", percentiles(last));
    let mut mission = Mission::new(&mut field, 2);
    mission.land().await;
    field.end("failover", &[]).await;
}

/// How long after a moment each vehicle carried out the first intent of a term that began after it, in seconds.
async fn taken_up(field: &mut Field, at_s: f64) -> Vec<f64> {
    let vehicles = field.vehicles();
    let mut after = Vec::new();
    let all = async |field: &mut Field| {
        let first = |number: &u8| {
            // the successor's own vehicle has its intent as soon as it coordinates
            let begins = |line: &LogLine| ["intent taken up", "coordinates"].contains(&line.message());
            let lines = field.host(*number).lines();
            let times = lines
                .iter()
                .filter(|line| begins(line))
                .filter_map(|line| line.seconds_after(at_s));
            times.filter(|s| *s > 0.0).reduce(f64::min)
        };
        after = vehicles.iter().filter_map(first).collect();
        after.len() == vehicles.len()
    };
    field
        .until("all vehicles to take a successor's intent up", SANE_S, all)
        .await;
    after
}

fn percentiles(mut all: Vec<f64>) -> String {
    all.sort_by(f64::total_cmp);
    let at = |share: f64| all[((all.len() as f64 * share).ceil() as usize).clamp(1, all.len()) - 1];
    format!("p50 {:.3} s, p99 {:.3} s, of {}", at(0.5), at(0.99), all.len())
}
