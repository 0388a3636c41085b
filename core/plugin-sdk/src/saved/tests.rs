//! Saved states come back whole or not at all.

use super::*;

#[test]
fn what_was_saved_comes_back() {
    let state = (7_u32, Some(1.5_f64));
    let read: (u32, Option<f64>) = decode(3, &encode(3, &state)).unwrap();
    assert_eq!(read, state);
}

#[test]
fn another_version_is_named() {
    let error = decode::<u32>(3, &encode(2, &7_u32)).unwrap_err();
    assert!(matches!(error, Unreadable::Version { found: 2, wanted: 3 }), "{error}");
}

#[test]
fn what_is_cut_off_anywhere_is_an_error() {
    let bytes = encode(1, &"a longer state".to_owned());
    for length in 0..bytes.len() {
        let read = decode::<String>(1, &bytes[..length]);
        assert!(
            matches!(read, Err(Unreadable::Damaged(_))),
            "{length} bytes gave {read:?}"
        );
    }
}
