//! A recording is written, cut off, damaged, merged and judged again.

use crate::{
    Audit, AuditChain, AuditRecord, Broken, Encoded, Header, Message, ReadError, Recording, Select, TimeBase, Topic,
    Writer,
};
use proptest::prelude::*;
use skein_domain::exchange::Severity;
use skein_domain::{NodeId, NodeTime, VehicleId};
use skein_view::{EventKind, EventRecord};
use std::path::{Path, PathBuf};

mod redecide;

const BASE: TimeBase = TimeBase {
    node: NodeTime(5_000_000),
    unix_ns: 1_800_000_000_000_000_000,
};

fn header(node: u64) -> Header {
    Header {
        format: crate::FORMAT,
        version: "0.1.0".into(),
        node: Some(NodeId(node)),
        name: format!("node {node}"),
        swarm: "north".into(),
        base: BASE,
    }
}

fn event(seq: u64, at: NodeTime) -> Encoded {
    let record = EventRecord {
        seq,
        time: at,
        node: None,
        vehicle: Some(VehicleId(3)),
        severity: Severity::Info,
        kind: EventKind::Notice,
        text: format!("event {seq}"),
    };
    Encoded::json(Topic::Events, at, &record).expect("encodes")
}

fn second(seconds: u64) -> NodeTime {
    NodeTime(5_000_000 + seconds * 1_000_000)
}

/// One event a second, each in a chunk of its own.
fn written(folder: &Path, seconds: u64, finish: bool) -> PathBuf {
    let path = folder.join("flight.mcap");
    let mut writer = Writer::create(&path, header(1)).expect("begins");
    for n in 0..seconds {
        writer.write(&event(n, second(n)), second(n)).expect("takes it");
        writer.flush().expect("flushes");
    }
    if finish {
        writer.finish().expect("ends");
    } else {
        // As a program that is killed: nothing that comes at the end is written.
        let bytes = std::fs::read(&path).expect("is there");
        drop(writer);
        std::fs::write(&path, bytes).expect("is put back");
    }
    path
}

fn numbers(recording: &Recording, select: Select) -> Vec<u64> {
    let messages = recording.messages(select).filter_map(Result::ok);
    messages
        .map(|message: Message| message.json::<EventRecord>().expect("is one").seq)
        .collect()
}

#[test]
fn what_was_written_is_read_and_found_by_its_time() {
    let folder = tempfile::tempdir().expect("a folder");
    let recording = Recording::open(&written(folder.path(), 10, true)).expect("opens");
    assert!(recording.is_finished());
    assert_eq!(recording.header(), &header(1));
    assert_eq!(recording.span(), (second(0), second(9)));
    let topics: Vec<_> = recording
        .topics()
        .map(|(info, count)| (info.name.to_string(), count))
        .collect();
    assert_eq!(topics, [("/skein/events".to_owned(), 10)]);
    assert_eq!(numbers(&recording, Select::default()), (0..10).collect::<Vec<_>>());
    let middle = Select::default().from(second(3)).until(second(6));
    assert_eq!(numbers(&recording, middle), [3, 4, 5]);
    assert!(numbers(&recording, Select::only(|topic| *topic == Topic::Audit)).is_empty());
}

#[test]
fn a_file_that_was_cut_off_anywhere_gives_what_was_flushed_before() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = written(folder.path(), 5, false);
    let bytes = std::fs::read(&path).expect("is there");
    let mut most = 0;
    for length in 0..=bytes.len() {
        std::fs::write(&path, bytes.get(..length).expect("is in it")).expect("is written");
        match Recording::open(&path) {
            Ok(recording) => {
                assert!(!recording.is_finished());
                let read = numbers(&recording, Select::default());
                assert_eq!(read, (0..read.len() as u64).collect::<Vec<_>>());
                assert!(read.len() >= most, "less of a longer file at {length}");
                most = read.len();
            }
            Err(ReadError::NotMcap { .. } | ReadError::Empty { .. }) => assert_eq!(most, 0, "at {length}"),
            Err(other) => panic!("{other} at {length}"),
        }
    }
    assert_eq!(most, 5);
    let mut shares = Vec::new();
    Recording::open_telling(&path, &mut |share| shares.push(share)).expect("opens");
    assert!(
        shares.is_sorted() && shares.last().is_some_and(|last| *last == 1.0),
        "{shares:?}"
    );
}

#[test]
fn a_damaged_chunk_is_told_and_the_others_are_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = written(folder.path(), 5, true);
    let at = Recording::open(&path).expect("opens").chunks()[2];
    let mut bytes = std::fs::read(&path).expect("is there");
    let middle = usize::try_from(at.offset + at.length - 10).expect("fits");
    bytes[middle] ^= 0xFF;
    std::fs::write(&path, bytes).expect("is written");
    let recording = Recording::open(&path).expect("opens");
    assert_eq!(recording.messages(Select::default()).filter(Result::is_err).count(), 1);
    assert_eq!(numbers(&recording, Select::default()), [0, 1, 3, 4]);
}

#[test]
fn other_files_are_told_by_name() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("other");
    std::fs::write(&path, "ULog\x01\x12\x35 nothing of ours").expect("is written");
    assert!(matches!(Recording::open(&path), Err(ReadError::NotMcap { .. })));
    assert!(matches!(Recording::open(folder.path()), Err(ReadError::Io { .. })));
    assert!(matches!(
        Recording::open(&folder.path().join("none")),
        Err(ReadError::Io { .. })
    ));
    let mut theirs = mcap::Writer::new(std::fs::File::create(&path).expect("is made")).expect("begins");
    let channel = theirs
        .add_channel(0, "/chatter", "json", &Default::default())
        .expect("is added");
    let of_theirs = mcap::records::MessageHeader {
        channel_id: channel,
        sequence: 0,
        log_time: 1,
        publish_time: 1,
    };
    theirs.write_to_known_channel(&of_theirs, b"{}").expect("is written");
    theirs.finish().expect("ends");
    drop(theirs);
    assert!(matches!(Recording::open(&path), Err(ReadError::NotOurs { .. })));
}

#[test]
fn time_never_goes_back_in_a_file_but_what_happened_keeps_its_own() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("flight.mcap");
    let mut writer = Writer::create(&path, header(1)).expect("begins");
    writer.write(&event(0, second(4)), second(4)).expect("takes it");
    writer.write(&event(1, second(2)), second(3)).expect("takes it");
    writer.finish().expect("ends");
    let recording = Recording::open(&path).expect("opens");
    let read: Vec<_> = recording.messages(Select::default()).filter_map(Result::ok).collect();
    assert_eq!((read[1].recorded, read[1].at), (second(4), second(2)));
}

#[test]
fn every_topic_has_one_name() {
    let camera = Topic::Video(VehicleId(7), "front".into());
    for topic in [
        Topic::Fleet,
        Topic::Audit,
        Topic::Log,
        Topic::Telemetry(VehicleId(12)),
        camera,
    ] {
        assert_eq!(Topic::parse(&topic.to_string()), Some(topic.clone()));
        assert!(!topic.schema().name.is_empty());
    }
    for foreign in [
        "/chatter",
        "/vehicles/x/telemetry",
        "/vehicles/3",
        "/vehicles/3/else",
        "",
    ] {
        assert_eq!(Topic::parse(foreign), None, "{foreign}");
    }
}

fn action(n: u64) -> Audit {
    Audit {
        time: NodeTime(n),
        who: "Ada".into(),
        over: "api".into(),
        what: format!("POST /api/v1/commands {n}"),
        ..Audit::default()
    }
}

fn chain(count: u64) -> Vec<AuditRecord> {
    let mut chain = AuditChain::default();
    (0..count).map(|n| chain.add(action(n))).collect()
}

fn followed(records: &[AuditRecord]) -> Result<(), Broken> {
    let mut chain = AuditChain::default();
    records.iter().try_for_each(|record| chain.follow(record))
}

#[test]
fn a_chain_goes_on_in_the_next_file() {
    let records = chain(4);
    assert_eq!(followed(&records), Ok(()));
    let mut next = AuditChain::after(&records[3].hash);
    let first = next.add(action(9));
    assert_eq!((first.number, &first.before), (0, &records[3].hash));
    assert_eq!(followed(&[first]), Ok(()));
}

proptest! {
    #[test]
    fn any_change_of_a_chain_is_named(count in 2u64..8, at in 0usize..8, what in 0u8..4) {
        let mut records = chain(count);
        let at = at % records.len();
        let last = at + 1 == records.len();
        match what {
            0 => records[at].audit.who = "Eve".into(),
            1 => records[at].audit.time = NodeTime(999),
            2 if !last => { records.remove(at); }
            _ => { let (a, b) = (at, (at + 1) % records.len()); records.swap(a, b); }
        }
        prop_assert!(followed(&records).is_err());
    }

    #[test]
    fn time_of_day_and_node_time_are_the_same_moment(us in 0u64..4_000_000_000_000) {
        prop_assert_eq!(BASE.node_time(BASE.unix_ns(NodeTime(us))), NodeTime(us));
    }
}
