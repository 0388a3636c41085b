//! Children are read, waited for and ended.

use super::*;
use std::path::Path;

fn shell(script: &str) -> Process {
    let mut command = Command::new("sh");
    command.args(["-c", script]);
    Process::start(script, command)
}

#[tokio::test]
async fn output_and_errors_are_kept() {
    let mut child = shell("echo one; echo two >&2; exit 3");
    assert_eq!(child.exit_code(patience()).await, 3);
    assert!(
        child.output().contains("one") && child.output().contains("two"),
        "{}",
        child.output()
    );
}

#[tokio::test]
async fn a_line_is_waited_for() {
    let mut child = shell("echo port 4711; exec sleep 600");
    assert_eq!(child.line("port").await, "port 4711");
    assert_eq!(child.line("471").await, "port 4711");
    child.signal("TERM").await;
    assert_eq!(child.end(patience()).await.code(), None);
}

#[tokio::test]
#[should_panic(expected = "ended without saying \"three\"")]
async fn a_line_that_does_not_come_is_reported_with_what_came() {
    shell("echo one").line("three").await;
}

#[tokio::test]
async fn a_dropped_child_is_gone() {
    let child = shell("exec sleep 600");
    let folder = format!("/proc/{}", child.id().expect("it runs"));
    drop(child);
    crate::eventually(patience(), "the end of the child", async || {
        // until tokio has reaped it, it is there as a zombie
        let state = std::fs::read_to_string(format!("{folder}/stat")).unwrap_or_default();
        (!Path::new(&folder).exists() || state.contains(") Z ")).then_some(())
    })
    .await;
}
