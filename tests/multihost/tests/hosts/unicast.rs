//! A flight over DDS through an air that does not carry its multicast.

use skein_domain::Shape;
use skein_tests_multihost::field::{Field, GROUND, usual};
use skein_tests_multihost::host::Transport;
use skein_tests_multihost::mission::Mission;

/// Found each other and chosen a coordinator within this, in seconds.
const TOGETHER_S: f64 = 30.0;
/// The best suited.
const COORDINATOR: u8 = 2;

#[tokio::test(flavor = "multi_thread")]
async fn over_dds_without_multicast() {
    let mut plans = usual();
    for plan in &mut plans {
        plan.transport = Transport::DdsPeers;
    }
    let mut field = Field::start(21, plans);
    field.led_by(COORDINATOR, &[1, 2, 3, 4, 5, 6], TOGETHER_S).await;
    let mut mission = Mission::new(&mut field, GROUND);
    mission.take_off().await;
    mission.form_up(Shape::Line).await;
    mission.form_up(Shape::Wedge).await;
    mission.land().await;
    field.end("over DDS without multicast", &[]).await;
}
