//! What repeats is told; what is old, alone or no line of ours is not.

use super::*;

fn history(text: &str) -> (tempfile::TempDir, History) {
    let folder = tempfile::tempdir().expect("a folder");
    let history = History::in_file(folder.path().join("deeper/unsteady.tsv"));
    if !text.is_empty() {
        history.append(text).expect("is written");
    }
    (folder, history)
}

#[test]
fn a_test_that_was_unsteady_in_two_runs_repeats() {
    let (_folder, history) = history("");
    assert!(history.repeated().is_empty(), "there is no file yet");
    history.add("a1", &[("e2e", "demo::flies"), ("faults", "losses::one")]);
    assert!(history.repeated().is_empty());
    history.add("b2", &[("e2e", "demo::flies")]);
    assert_eq!(history.repeated(), [("e2e: demo::flies".to_owned(), 2)]);
}

#[test]
fn old_lines_and_strange_ones_do_not_count() {
    let old_s = now_s() - COUNTED_S - 10;
    let (_folder, history) = history(&format!(
        "{old_s}\ta\te2e\tone\n{}\tb\te2e\tone\n\u{0}\nx\ty\n",
        now_s()
    ));
    assert!(history.repeated().is_empty());
}

#[test]
fn where_nothing_can_be_written_nothing_fails() {
    let history = History::in_file("/proc/nowhere/unsteady.tsv".into());
    history.add("a", &[("e2e", "one")]);
    assert!(history.repeated().is_empty());
}
