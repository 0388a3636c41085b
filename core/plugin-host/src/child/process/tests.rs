//! Ends of real processes in words. Programs that take the argument `plugin-host` for what they like stand in for a host.

use super::*;

fn started(script: &str) -> (tempfile::TempDir, Started) {
    let directory = tempfile::tempdir().expect("a directory");
    let path = directory.path().join("host");
    // Written by another process: a file that this one had open to write could not be started ("text file busy") while a child of
    // another test, forked at that moment, still holds it open.
    let written = std::process::Command::new("sh")
        .args(["-c", r#"printf '%s\n' "$2" >"$1" && chmod 700 "$1""#, "sh"])
        .arg(&path)
        .arg(format!("#!/bin/sh\n{script}"))
        .status();
    assert!(written.expect("sh runs").success());
    let started = ChildProcess::start(&path).expect("is started");
    (directory, started)
}

/// Waits until its output ends.
fn ended(script: &str) -> PluginError {
    let (_directory, mut started) = started(script);
    while started.errors.drain(|_| {}) {
        crate::child::wire::wait(&[started.errors.file()], rustix::event::PollFlags::IN, None).expect("waits");
    }
    let error = started.process.end(&mut started.errors);
    assert_eq!(started.process.pid(), None);
    assert!(!started.process.kill(), "buried");
    error
}

#[test]
fn ends_are_told_with_the_last_words() {
    for (script, expected_how, expected_said) in [
        ("exit 0", "exit code 0", ""),
        ("echo one >&2; echo two; echo >&2; exit 7", "exit code 7", "two"),
        (
            "echo why >&2; echo 'note: run it again' >&2; kill -SEGV $$",
            "killed by signal 11 (SIGSEGV)",
            "why",
        ),
        ("kill -USR1 $$", "killed by signal 10", ""),
    ] {
        let PluginError::ProcessEnded { how, said } = ended(script) else {
            panic!("another error")
        };
        assert_eq!((how.as_str(), said.as_str()), (expected_how, expected_said), "{script}");
    }
}

#[test]
fn long_words_are_cut() {
    let PluginError::ProcessEnded { said, .. } = ended("head -c 100000 /dev/zero | tr '\\0' x >&2") else {
        panic!("another error")
    };
    assert_eq!(said, "x".repeat(MAX_SAID_BYTES));
}

#[test]
fn one_that_only_closes_its_ends_is_helped_along() {
    // An ignored signal stays ignored in the next program; SIGKILL is none that can be.
    let PluginError::ProcessEnded { how, .. } = ended("trap '' TERM; exec sleep 1000 <&- >&- 2>&-") else {
        panic!("another error")
    };
    assert_eq!(how, "killed by signal 9 (SIGKILL)");
}

#[test]
fn it_goes_with_its_value_and_is_seen_until_then() {
    let (_directory, started) = started("exec sleep 1000");
    let pid = started.process.pid().expect("is there");
    assert!(started.process.processor_s().expect("is told") < 60.0);
    assert!(started.process.has_ended().is_none());
    drop(started);
    assert!(
        !std::path::Path::new(&format!("/proc/{pid}")).exists(),
        "neither running nor unburied"
    );
}
