//! Whoever was started is found and ended, also when its parent is gone; nobody else is.

use super::*;
use std::io::{BufRead, BufReader};
use std::os::unix::process::CommandExt;
use std::process::{Command, Stdio};

/// Starts a shell in a group of its own and reads as many ids as it says.
fn shell(script: &str, ids: usize) -> (std::process::Child, Vec<i32>) {
    let mut child = Command::new("sh")
        .args(["-c", script])
        .process_group(0)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .spawn()
        .expect("sh starts");
    let output = BufReader::new(child.stdout.take().expect("piped"));
    let lines = output.lines().take(ids);
    let ids = lines.map(|line| line.expect("a line").trim().parse().expect("an id"));
    let ids = ids.collect();
    (child, ids)
}

fn is_running(pid: i32) -> bool {
    running().iter().any(|process| process.pid == pid)
}

#[test]
fn a_child_and_its_children_are_found_and_ended() {
    let (mut child, ids) = shell("sleep 600 & echo $!; sh -c 'sleep 600 & echo $!; wait' & wait", 2);
    let found: Vec<i32> = below(child.id()).iter().map(|process| process.pid).collect();
    assert!(ids.iter().all(|id| found.contains(id)), "{ids:?} of {found:?}");
    end(child.id());
    child.wait().expect("is waited for");
    assert!(!ids.iter().any(|id| is_running(*id)));
}

#[test]
fn one_whose_parent_is_gone_is_found_by_its_group() {
    let (mut child, ids) = shell("sh -c 'sleep 600 & echo $!'; exit", 1);
    child.wait().expect("is waited for");
    assert!(is_running(ids[0]));
    let left = below(child.id());
    assert_eq!(left.iter().map(|process| process.pid).collect::<Vec<_>>(), ids);
    assert!(left[0].to_string().ends_with(&format!(" ({})", ids[0])), "{}", left[0]);
    end(child.id());
    assert!(!is_running(ids[0]));
}

#[test]
fn a_name_may_hold_anything() {
    let process = read(7, "7 (a b) (c) S 3 4 4 0").expect("is read");
    assert_eq!(
        (process.name.as_str(), process.parent, process.group),
        ("a b) (c", 3, 4)
    );
    assert!(read(7, "7 (gone) Z 3 4 4 0").is_none());
    assert!(read(7, "").is_none());
}
