//! Files that are no plugins; the ones that are or should be are the boundary tests' matter.

use super::*;

#[test]
fn what_is_no_shared_library_is_said_to_be_none() {
    let program = std::fs::read(std::env::current_exe().expect("is known")).expect("is there");
    for bytes in [
        &b""[..],
        b"#!/bin/sh",
        b"\x7fELF",
        &program[..1_000],
        &program[..program.len() / 2],
    ] {
        let error = judge(bytes).expect_err("is none");
        assert!(matches!(error, LoadError::NotLoadable { .. }), "{error}");
    }
}

#[test]
fn a_program_is_no_plugin() {
    // A position-independent program is a shared library by its form; it lacks the symbol.
    let program = std::fs::read(std::env::current_exe().expect("is known")).expect("is there");
    let error = judge(&program).expect_err("is none");
    assert!(
        matches!(error, LoadError::MissingSymbol | LoadError::NotLoadable { .. }),
        "{error}"
    );
}

#[test]
fn damaged_files_are_judged_without_a_panic() {
    let program = std::fs::read(std::env::current_exe().expect("is known")).expect("is there");
    let mut damaged = program.get(..200_000).unwrap_or(&program).to_vec();
    for at in (0..1_000).chain((1_000..damaged.len()).step_by(997)) {
        for value in [0x00, 0xff, 0x80] {
            let before = std::mem::replace(&mut damaged[at], value);
            assert!(judge(&damaged).is_err());
            damaged[at] = before;
        }
    }
}
