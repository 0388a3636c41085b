//! What comes out of a guard.

use super::*;

#[test]
fn the_message_and_its_place_come_out() {
    assert_eq!(guard(|| 7), Ok(7));
    let message = guard(|| panic!("number {}", 3)).expect_err("panicked");
    assert!(
        message.starts_with("number 3 (") && message.contains("guard/tests.rs:"),
        "{message}"
    );
}

#[test]
fn a_payload_that_panics_on_drop_is_no_matter() {
    struct Nasty;
    impl Drop for Nasty {
        fn drop(&mut self) {
            panic!("again");
        }
    }
    let message = guard(|| std::panic::panic_any(Nasty)).expect_err("panicked");
    assert!(message.starts_with("a panic without a message"), "{message}");
}

#[test]
fn guards_may_be_nested() {
    let outer = guard(|| {
        let inner: Result<(), String> = guard(|| panic!("inner"));
        assert!(inner.is_err());
        panic!("outer")
    });
    assert!(matches!(outer, Err::<(), _>(message) if message.starts_with("outer")));
}
