//! The containers of the demonstration, each in a network namespace in place of a container: the same commands, the same configurations.

use skein_domain::Shape;
use skein_tests_multihost::compose;
use skein_tests_multihost::field::Field;
use skein_tests_multihost::mission::Mission;

const VEHICLES: u8 = 6;
/// The ground station is the last host.
const GROUND: u8 = VEHICLES + 1;
/// Found each other and chosen a coordinator within this, in seconds; six of them load a detector or start at once.
const TOGETHER_S: f64 = 60.0;

/// Two vehicles that observe, four of the simple class, and the ground station fly line, a way, and wedge, and land.
#[tokio::test(flavor = "multi_thread")]
async fn the_demonstration_of_the_compose_file_flies() {
    let plans = compose::plans("demo.yml");
    assert_eq!(plans.len(), usize::from(GROUND));
    let mut field = Field::start(31, plans);
    let all: Vec<u8> = (1..=GROUND).collect();
    field.one_swarm(&all, TOGETHER_S).await;
    let mut mission = Mission::new(&mut field, GROUND);
    mission.take_off().await;
    mission.form_up(Shape::Line).await;
    let (leader, to) = mission.set_out(40.0, 20.0).await;
    mission.arrives(leader, to).await;
    mission.stands_as(Shape::Line).await;
    mission.form_up(Shape::Wedge).await;
    mission.land().await;
    field.end("the compose file", &[]).await;
}
