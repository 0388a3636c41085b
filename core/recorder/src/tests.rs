//! Files begin, end, are interrupted, go on, are finished later, and go when there are too many.

use crate::finishing::finish_all;
use crate::folder::{self, Keep};
use crate::tapes::{Tapes, Told};
use skein_domain::NodeTime;
use skein_recording::{Audit, AuditChain, Encoded, FORMAT, Header, Recording, Select, TimeBase, Topic, Writer};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

const KEEP: Keep = Keep {
    bytes: 1 << 30,
    age: Duration::from_secs(86_400),
};

fn second(seconds: u64) -> NodeTime {
    NodeTime(seconds * 1_000_000)
}

fn header(at: NodeTime) -> Header {
    Header {
        format: FORMAT,
        version: "0.1.0".into(),
        node: None,
        name: "north/1".into(),
        swarm: String::new(),
        base: TimeBase {
            node: at,
            unix_ns: 1_800_000_000_000_000_000 + at.0 * 1_000,
        },
    }
}

fn action(chain: &mut AuditChain, at: NodeTime) -> Vec<Encoded> {
    let audit = Audit {
        time: at,
        what: "a test".into(),
        ..Audit::default()
    };
    vec![Encoded::json(Topic::Audit, at, &chain.add(audit)).expect("encodes")]
}

fn files(folder: &Path) -> Vec<String> {
    let name = |path: PathBuf| path.file_name().expect("has a name").to_string_lossy().into_owned();
    let mut files: Vec<String> = folder::all(folder).expect("is there").into_iter().map(name).collect();
    files.sort();
    files
}

#[test]
fn a_flight_is_a_file_and_standing_is_another_that_says_so() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut tapes = Tapes::new(folder.path().join("flights"), KEEP);
    let mut chain = tapes.last_chain("north/1");
    assert_eq!(chain, AuditChain::default());
    for (begin, has_flown) in [(0, true), (100, false)] {
        assert!(tapes.wants_file(second(begin)));
        assert_eq!(tapes.begin(header(second(begin)), second(begin)), None);
        chain = AuditChain::after(chain.last());
        assert_eq!(tapes.write(&action(&mut chain, second(begin)), second(begin)), None);
        assert_eq!(tapes.flush(true, second(begin + 1)), None);
        assert!(tapes.bytes() > 100);
        tapes.end(has_flown).expect("ends");
    }
    let flights = folder.path().join("flights");
    let expected = [
        "2027-01-15T08-00-00Z_north-1.mcap",
        "2027-01-15T08-01-40Z_north-1_ground.mcap",
    ];
    assert_eq!(files(&flights), expected);
    // The next run of the program goes on with the chain.
    assert_eq!(tapes.last_chain("north/1").last(), chain.last());
    assert_eq!(tapes.last_chain("another"), AuditChain::default());
}

#[test]
fn a_disk_that_does_not_take_it_is_told_once_and_tried_again() {
    let folder = tempfile::tempdir().expect("a folder");
    let flights = folder.path().join("flights");
    fs::write(&flights, "in the way").expect("is written");
    let mut tapes = Tapes::new(flights.clone(), KEEP);
    let mut chain = AuditChain::default();
    assert!(matches!(
        tapes.begin(header(second(0)), second(0)),
        Some(Told::Interrupted(_))
    ));
    assert!(!tapes.wants_file(second(0)), "it is not tried again at once");
    assert_eq!(tapes.write(&action(&mut chain, second(0)), second(0)), None);
    assert!(tapes.wants_file(second(2)));
    assert_eq!(tapes.begin(header(second(2)), second(2)), None, "it is told once");
    assert_eq!(tapes.write(&action(&mut chain, second(2)), second(2)), None);
    fs::remove_file(&flights).expect("goes");
    assert_eq!(tapes.begin(header(second(4)), second(4)), None);
    assert_eq!(tapes.write(&action(&mut chain, second(4)), second(4)), None);
    assert_eq!(tapes.flush(true, second(5)), Some(Told::GoesOn(2)));
    assert_eq!(tapes.flush(true, second(6)), None);
    tapes.end(true).expect("ends");
    assert_eq!(files(&flights).len(), 1);
}

#[test]
fn what_was_cut_off_is_finished_and_loses_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("cut.mcap");
    let mut writer = Writer::create(&path, header(second(0))).expect("begins");
    let mut chain = AuditChain::default();
    for n in 0..20 {
        for message in action(&mut chain, second(n)) {
            writer.write(&message, second(n)).expect("takes it");
        }
        writer.flush().expect("flushes");
    }
    let bytes = fs::read(&path).expect("is there");
    assert!(folder::is_being_written(&path));
    finish_all(folder.path());
    assert_eq!(
        fs::read(&path).expect("is there"),
        bytes,
        "one that is being written is left alone"
    );
    drop(writer);
    fs::write(&path, &bytes).expect("is as it was");
    let when = SystemTime::now() - Duration::from_secs(5_000);
    let file = fs::File::options().append(true).open(&path).expect("opens");
    file.set_modified(when).expect("is set");
    drop(file);
    finish_all(folder.path());
    let recording = Recording::open(&path).expect("opens");
    assert!(recording.is_finished());
    assert_eq!(recording.messages(Select::default()).filter_map(Result::ok).count(), 20);
    let changed = fs::metadata(&path).and_then(|of| of.modified()).expect("has a time");
    assert!(changed.duration_since(when).expect("is later") < Duration::from_secs(1));
    assert_eq!(files(folder.path()), ["cut.mcap"]);
}

fn put(folder: &Path, name: &str, bytes: usize, age_s: u64) -> PathBuf {
    let path = folder.join(name);
    fs::write(&path, vec![0; bytes]).expect("is written");
    let file = fs::File::options().append(true).open(&path).expect("opens");
    let changed = SystemTime::now() - Duration::from_secs(age_s);
    file.set_modified(changed).expect("is set");
    path
}

#[test]
fn the_oldest_go_first_those_without_a_flight_before_them_and_never_the_present_one() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let present = put(at, "a.mcap", 1_000, 900);
    put(at, "b.mcap", 1_000, 800);
    put(at, "c.mcap", 1_000, 700);
    put(at, "d_ground.mcap", 1_000, 10);
    put(at, "notes.txt", 9_000, 100_000);
    put(at, "old.mcap", 10, 90_000);
    let keep = Keep { bytes: 2_500, ..KEEP };
    let gone = folder::prune(at, keep, 0, std::slice::from_ref(&present)).expect("is read");
    assert_eq!(gone.len(), 3, "{gone:?}");
    assert_eq!(files(at), ["a.mcap", "c.mcap"]);
    assert!(
        folder::prune(at, KEEP, 1, &[present])
            .expect("is read")
            .ends_with(&[at.join("c.mcap")])
    );
}

#[test]
fn names_are_free_ones() {
    let folder = tempfile::tempdir().expect("a folder");
    let name = folder::name(1_800_000_000_000_000_000, "Ada's node #1");
    assert_eq!(name, "2027-01-15T08-00-00Z_Ada-s-node--1");
    put(folder.path(), &format!("{name}.mcap"), 1, 0);
    let free = folder::free_path(folder.path(), &name);
    assert!(free.ends_with("2027-01-15T08-00-00Z_Ada-s-node--1-2.mcap"), "{free:?}");
}
