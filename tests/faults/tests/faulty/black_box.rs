//! The program killed in flight (`kill -9`) while it records: every recording opens, holds what happened until its last second, its decisions
//! can be made again, and its audit follows on itself, also across files.

use crate::killed::Field;
use reqwest::Method;
use serde_json::{Value, json};
use skein_domain::NodeTime;
use skein_recording::{AuditChain, AuditRecord, ReadError, Recording, Redecided, Redecider, Select, Topic};
use skein_testkit::{eventually, patience};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// What happened so long before the end is in the file, in seconds of the node's clock.
const LOST_AT_MOST_S: f64 = 1.0;
/// The node's time is looked at more often than that, in seconds: what is longer, the machine stood still, and nobody wrote.
const LOOK_EVERY_S: f64 = 0.1;

#[tokio::test(flavor = "multi_thread")]
async fn a_flight_that_is_killed_is_recorded_until_its_last_second() {
    killed(3).await;
}

#[tokio::test(flavor = "multi_thread")]
#[ignore = "long: part of `cargo xtask test faults`"]
async fn killed_a_hundred_times_every_recording_is_whole_until_its_last_second() {
    killed(100).await;
}

async fn killed(times: usize) {
    let mut field = Field::start(2, "fly_on").await;
    field.form().await;
    let flights = field.folder().join("flights");
    for time in 0..times {
        eventually(patience(), "a recording", async || {
            field.get("health").await["recorder"]["file"].as_str().map(drop)
        })
        .await;
        let asked = json!({"shape": "wedge", "spacing_m": 6.0 + (time % 2) as f64});
        // Before it hears its vehicles again it refuses, which is recorded too.
        field.try_put(Method::PUT, "formation", asked).await;
        let at_s = time_s(&field).await;
        // Any moment will do, once the second is over.
        let moment_s = LOST_AT_MOST_S + (time * 37 % 100) as f64 / 100.0;
        let (mut last_s, mut gone_s) = (at_s, 0.0);
        eventually(patience(), "a while later", async || {
            let now_s = time_s(&field).await;
            gone_s += (now_s - last_s).min(LOOK_EVERY_S);
            last_s = now_s;
            (gone_s >= moment_s).then_some(())
        })
        .await;
        field.kill_for(Duration::from_millis(200)).await;
        let files = recordings(&flights);
        assert_eq!(files.len(), time + 1, "a file for each run: {files:?}");
        let newest = files.last().expect("a file");
        let again = check(newest, at_s);
        // Later runs may have ended before they flew again.
        assert!(time > 0 || again.setpoints > 0, "{again:?}");
        field.start_again();
        field
            .until("heard again", |fleet| {
                fleet["vehicles"].as_array().is_some_and(|all| all.len() == 2)
            })
            .await;
    }
    field.kill_for(Duration::ZERO).await;
    // What was cut off is finished while the next run records.
    let files = recordings(&flights);
    let mut chain = AuditChain::default();
    for (index, path) in files.iter().enumerate() {
        let last = index + 2 >= files.len();
        let recording = match Recording::open(path) {
            Ok(recording) => recording,
            // It was killed before it had written anything.
            Err(ReadError::Empty { .. }) if last => continue,
            Err(error) => panic!("{error}"),
        };
        assert!(last || recording.is_finished(), "{} was not finished", path.display());
        chain = followed(&recording, &chain);
    }
}

/// In the order in which they were begun.
fn recordings(folder: &Path) -> Vec<PathBuf> {
    let files = std::fs::read_dir(folder)
        .expect("a folder")
        .filter_map(|entry| Some(entry.ok()?.path()));
    let mut files: Vec<_> = files
        .filter(|path| path.extension().is_some_and(|is| is == "mcap"))
        .collect();
    let begun = |path: &PathBuf| {
        Recording::open(path)
            .map(|recording| recording.header().base.unix_ns)
            .unwrap_or(u64::MAX)
    };
    files.sort_by_key(begun);
    files
}

async fn time_s(field: &Field) -> f64 {
    eventually(patience(), "the node's time", async || {
        let health: Value = field.get("health").await;
        health["time"].as_u64().map(|at| NodeTime(at).as_seconds())
    })
    .await
}

/// What was asked for at this time is in it, and what was decided is decided again.
fn check(path: &Path, asked_s: f64) -> Redecided {
    let recording = Recording::open(path).expect("opens");
    assert!(!recording.is_finished());
    let (mut asked, mut redecider) = (false, Redecider::default());
    for message in recording.messages(Select::default()) {
        let message = message.expect("is whole");
        match message.topic {
            Some(Topic::Audit) => {
                let record: AuditRecord = message.json().expect("is one");
                let at_s = record.audit.time.as_seconds();
                asked |= record.audit.what == "PUT /api/v1/formation" && at_s >= asked_s - 5.0 && at_s <= asked_s;
            }
            _ => redecider.take(&message),
        }
    }
    assert!(asked, "what was asked at {asked_s} s is not in {}", path.display());
    let again = redecider.finish();
    assert_eq!(again.differences, [], "{}", path.display());
    assert_eq!(again.without_inputs, 0, "{again:?}");
    again
}

fn followed(recording: &Recording, before: &AuditChain) -> AuditChain {
    let mut chain = AuditChain::default();
    for message in recording.messages(Select::only(|topic| *topic == Topic::Audit)) {
        let record: AuditRecord = message.expect("is whole").json().expect("is one");
        if record.number == 0 {
            assert_eq!(record.before, before.last(), "{}", recording.path().display());
        }
        chain.follow(&record).expect("follows");
    }
    chain
}
