//! Of a flood the newest goes on, and a refusal is told once.

use super::*;
use futures_util::FutureExt;

fn forward(forward_m_s: f64) -> Stick {
    Stick {
        forward_m_s,
        ..Stick::default()
    }
}

#[tokio::test]
async fn of_a_flood_the_newest_goes_on() {
    let (mut sticks, id) = (Sticks::new(), VehicleId(3));
    for step in 0..100 {
        sticks.put(id, forward(f64::from(step)));
    }
    assert_eq!(sticks.due().await, (id, forward(99.0)));
    assert_eq!(sticks.due().now_or_never(), None, "none is left");
    // One that nobody waited for to its end is still there, or what has replaced it.
    sticks.put(id, forward(1.0));
    let _ = sticks.due().now_or_never();
    sticks.put(id, forward(2.0));
    assert_eq!(sticks.due().await, (id, forward(2.0)));
}

#[tokio::test]
async fn a_refusal_is_told_once_until_it_is_another_or_one_was_taken() {
    let (mut sticks, id) = (Sticks::new(), VehicleId(3));
    let told = sticks.refused(id, Refusal::PilotInControl).expect("is told");
    assert_eq!(
        (told.code.as_str(), &told.detail["stick"]),
        ("pilot_in_control", &json!(3))
    );
    assert_eq!(sticks.refused(id, Refusal::PilotInControl), None);
    assert!(sticks.refused(VehicleId(4), Refusal::PilotInControl).is_some());
    assert!(sticks.refused(id, Refusal::NoPosition).is_some());
    sticks.taken();
    assert!(sticks.refused(id, Refusal::NoPosition).is_some());
}
