//! One short flight of the whole: found, up, a line, its coordinator killed, a wedge, down. The rest is in `flights.rs`.

use skein_domain::Shape;
use skein_tests_multihost::field::{Field, GROUND, usual};
use skein_tests_multihost::mission::Mission;

/// Found each other, and chosen again, within this, in seconds.
const TOGETHER_S: f64 = 30.0;

#[tokio::test(flavor = "multi_thread")]
async fn five_vehicles_lose_their_coordinator_in_flight() {
    let mut field = Field::start(20, usual());
    let coordinator = field.one_swarm(&[1, 2, 3, 4, 5, 6], TOGETHER_S).await;
    let mut mission = Mission::new(&mut field, GROUND);
    mission.take_off().await;
    mission.form_up(Shape::Line).await;
    field.host_mut(coordinator).kill().await;
    let rest: Vec<u8> = field.living();
    let successor = field.one_swarm(&rest, TOGETHER_S).await;
    assert_ne!(successor, coordinator);
    let mut mission = Mission::new(&mut field, GROUND);
    mission.vehicles.retain(|vehicle| *vehicle != coordinator);
    mission.form_up(Shape::Wedge).await;
    mission.land().await;
    field.end("short", &[coordinator]).await;
}
