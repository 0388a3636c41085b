//! The obeyed term survives, and what is damaged is not taken for none.

use super::*;
use skein_domain::NodeId;
use skein_failover::Standing;

fn term(number: u64) -> Term {
    let holder = Standing {
        priority: 7,
        node: NodeId(3),
    };
    Term { number, holder }
}

#[test]
fn what_was_kept_is_there_for_the_next_run() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("term.json");
    let mut store = TermStore::open(Some(path.clone()));
    assert_eq!(store.load().expect("no file is no error"), None);
    store.save(Some(term(4))).expect("kept");
    store.save(Some(term(5))).expect("kept");
    assert_eq!(TermStore::open(Some(path)).load().expect("read"), Some(term(5)));
    let left: Vec<_> = std::fs::read_dir(folder.path()).expect("listed").collect();
    assert_eq!(left.len(), 1, "nothing else is left behind: {left:?}");
}

#[test]
fn a_damaged_file_is_not_taken_for_none() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("term.json");
    std::fs::write(&path, "{\"number\":").expect("written");
    let error = TermStore::open(Some(path)).load().expect_err("refused").to_string();
    assert!(error.contains("term.json"), "{error}");
}

#[test]
fn what_cannot_be_written_is_an_error_every_time() {
    let mut store = TermStore::open(Some(PathBuf::from("/nowhere/term.json")));
    assert!(store.save(Some(term(1))).is_err());
    assert!(store.save(Some(term(1))).is_err());
}
