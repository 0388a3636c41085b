//! Waiting ends when it should.

use super::*;

#[tokio::test]
async fn a_probe_that_succeeds_at_last_is_returned() {
    let mut left = 3;
    let value = eventually(PATIENCE, "the countdown", async || {
        left -= 1;
        (left == 0).then_some("done")
    })
    .await;
    assert_eq!(value, "done");
}

#[tokio::test]
#[should_panic(expected = "in vain for something that never comes")]
async fn a_probe_that_never_succeeds_says_what_was_waited_for() {
    eventually(Duration::from_millis(50), "something that never comes", async || {
        None::<()>
    })
    .await;
}
