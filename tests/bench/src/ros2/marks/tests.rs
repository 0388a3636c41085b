//! Steps, answers, and answers that do not come.

use super::*;

const MS: Duration = Duration::from_millis(1);

/// A node that looks every 20 ms, 3 ms after the sample of that moment, and sends 1 ms later.
fn flown(marks: &mut Marks, from: Instant, periods: u32, deaf: bool) -> Instant {
    let mut now = from;
    for _ in 0..periods {
        let origin_m = marks.publish(now);
        let north_m = if deaf { 7.0 } else { 7.0 - origin_m };
        marks.setpoint(now + 4 * MS, north_m);
        now += 20 * MS;
    }
    now
}

#[test]
fn the_time_is_from_the_sample_to_the_first_setpoint_that_knows() {
    let (mut marks, begun) = (Marks::default(), Instant::now());
    assert!(!marks.begin(begun), "nothing is held yet");
    let now = flown(&mut marks, begun, 3, false);
    assert!(marks.begin(now));
    let now = flown(&mut marks, now, 100, false);
    let found = marks.end();
    assert!(found.reactions_us.len() >= 16, "{found:?}");
    assert!(found.reactions_us.iter().all(|us| *us == 4000), "{found:?}");
    assert_eq!((found.intervals_us, found.lost), (vec![20_000; 100], 0));
    assert_eq!(marks.publish(now), 0.0, "no step is left");
}

#[test]
fn a_setpoint_that_was_on_its_way_already_is_no_answer() {
    let (mut marks, begun) = (Marks::default(), Instant::now());
    marks.setpoint(begun, 7.0);
    assert!(marks.begin(begun));
    assert_eq!(marks.publish(begun + 59 * MS), 0.0);
    assert_eq!(marks.publish(begun + 60 * MS), STEP_M);
    marks.setpoint(begun + 61 * MS, 7.01);
    assert_eq!(marks.publish(begun + 80 * MS), STEP_M, "it stays until it is answered");
    marks.setpoint(begun + 81 * MS, 6.01);
    assert_eq!(marks.end().reactions_us, [21_000]);
}

#[test]
fn steps_that_nobody_answers_are_counted_and_tried_again() {
    let (mut marks, begun) = (Marks::default(), Instant::now());
    marks.setpoint(begun, 7.0);
    assert!(marks.begin(begun));
    // Deaf ones say what was right before: every other step, the one back, seems to be answered.
    let now = flown(&mut marks, begun, 200, true);
    let found = marks.end();
    assert!(found.lost >= 2, "{found:?}");
    assert!(found.reactions_us.len() <= found.lost + 1, "{found:?}");
    assert!(now > begun);
}

#[test]
fn what_is_flown_is_in_the_frame_without_a_step() {
    let (mut marks, begun) = (Marks::default(), Instant::now());
    assert_eq!(marks.origin_of(-3.0), 0.0);
    marks.setpoint(begun, 7.0);
    assert!(marks.begin(begun));
    assert_eq!((marks.origin_of(7.02), marks.origin_of(5.98)), (0.0, STEP_M));
}
