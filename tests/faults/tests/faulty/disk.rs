//! The disk of the recordings is full, read-only, or silent for ten seconds, while a formation flies: nothing of the flight changes, operators are
//! told, and recording goes on by itself.
//!
//! The disks are real: a `tmpfs` in a mount namespace of the program, and an `ext4` that is frozen.

use crate::killed::{Field, flies};
use serde_json::Value;
use skein_domain::FlightMode;
use skein_recording::{Recording, Select, Topic};
use skein_testkit::{Process, eventually, patience, skein_binary};
use std::fs::{self, File};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::time::Duration;
use tokio::process::Command;

const VEHICLES: usize = 2;
/// Large enough for a flight of a minute, small enough to be filled at once.
const MOUNT: &str = "mkdir -p \"$1\" && mount -t tmpfs -o size=4m tmpfs \"$1\" && shift && exec \"$@\"";

/// The program with a small disk of its own for its recordings.
fn on_small_disk(folder: &Path) -> Process {
    let mut command = Command::new("unshare");
    command
        .args(["--user", "--map-root-user", "--mount", "--", "sh", "-c", MOUNT, "sh"])
        .arg(folder.join("flights"))
        .arg(skein_binary())
        .args(["run", "--config"])
        .arg(folder.join("node.toml"));
    Process::start("skein on a small disk", command)
}

/// That disk, as it is seen from outside.
fn seen_from_outside(field: &Field) -> PathBuf {
    let pid = field.node.id().expect("runs");
    let flights = field.folder().join("flights");
    PathBuf::from(format!("/proc/{pid}/root")).join(flights.strip_prefix("/").expect("is whole"))
}

async fn must(program: &str, arguments: &[&str]) {
    let ended = Command::new(program).args(arguments).output().await.expect("is there");
    let said = String::from_utf8_lossy(&ended.stderr);
    assert!(ended.status.success(), "{program} {arguments:?}: {said}");
}

fn fill(disk: &Path) -> PathBuf {
    let filler = disk.join("filler");
    let mut file = File::create(&filler).expect("is begun");
    let (mut block, zeros) = (1 << 16, vec![0; 1 << 16]);
    while block > 0 {
        match file.write_all(&zeros[..block]) {
            Ok(()) => {}
            Err(_) => block /= 2,
        }
    }
    filler
}

/// Number of the newest event.
async fn newest(field: &Field) -> u64 {
    let events = field.get("events?after=0").await;
    let last = events["events"].as_array().and_then(|all| all.last()?["seq"].as_u64());
    last.unwrap_or_default()
}

/// Waits for an event of the recorder, and gives its number.
async fn told(field: &Field, after: u64, text: &str) -> u64 {
    eventually(patience() + Duration::from_secs(20), text, async || {
        let events = field.get(&format!("events?after={after}")).await;
        let told = events["events"].as_array()?.iter().find(|event| {
            let says = event["text"].as_str().is_some_and(|said| said.contains(text));
            says && event["kind"]["kind"] == "recorder"
        })?;
        told["seq"].as_u64()
    })
    .await
}

/// Everybody flies in the formation, and nothing else than the recorder had anything to say.
async fn flies_on(field: &Field, after: u64, setpoints: &[u64]) {
    let fleet = field.get("fleet").await;
    assert!(flies(&fleet, VEHICLES), "{fleet}");
    for (id, before) in (1..=VEHICLES as u8).zip(setpoints) {
        let truth = field.vehicle(id);
        assert!(
            truth.armed && truth.mode == FlightMode::Offboard && truth.setpoints > *before,
            "{id}"
        );
    }
    let events = field.get(&format!("events?after={after}")).await;
    let others = |event: &&Value| event["severity"] != "info" && event["kind"]["kind"] != "recorder";
    let others: Vec<&Value> = events["events"]
        .as_array()
        .expect("a list")
        .iter()
        .filter(others)
        .collect();
    // This computer's own pace is none of it.
    let others: Vec<&&Value> = others
        .iter()
        .filter(|event| {
            !event["kind"]["kind"]
                .as_str()
                .is_some_and(|kind| kind.starts_with("overrun"))
        })
        .collect();
    assert!(others.is_empty(), "{others:?}");
}

fn setpoints(field: &Field) -> Vec<u64> {
    (1..=VEHICLES as u8).map(|id| field.vehicle(id).setpoints).collect()
}

/// Every file opens and nothing in it is damaged; the last ones of all reach to the end of the flight.
fn all_can_be_read(folder: &Path) {
    let files = fs::read_dir(folder)
        .expect("a folder")
        .filter_map(|entry| Some(entry.ok()?.path()));
    let files: Vec<PathBuf> = files
        .filter(|path| path.extension().is_some_and(|is| is == "mcap"))
        .collect();
    assert!(!files.is_empty());
    for path in &files {
        let recording = Recording::open(path).expect("opens");
        let telemetry = recording.messages(Select::only(|topic| matches!(topic, Topic::Telemetry(_))));
        let telemetry: Result<Vec<_>, _> = telemetry.collect();
        assert!(!telemetry.expect("is whole").is_empty(), "{}", path.display());
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_full_disk_changes_nothing_in_flight() {
    let mut field = Field::start_by(on_small_disk, VEHICLES, "fly_on").await;
    field.form().await;
    let disk = seen_from_outside(&field);
    let (before, flown) = (newest(&field).await, setpoints(&field));
    let filler = fill(&disk);
    let full = told(&field, before, "is full").await;
    flies_on(&field, before, &flown).await;
    let flown = setpoints(&field);
    fs::remove_file(filler).expect("goes");
    told(&field, full, "flights are recorded again").await;
    flies_on(&field, before, &flown).await;

    // The disk goes with the program.
    let kept = tempfile::tempdir().expect("a folder");
    // What was taken is in the file after 0.8 s, at the latest.
    tokio::time::sleep(Duration::from_secs(2)).await;
    for entry in fs::read_dir(&disk).expect("a folder") {
        let entry = entry.expect("an entry");
        fs::copy(entry.path(), kept.path().join(entry.file_name())).expect("is kept");
    }
    field.node.signal("TERM").await;
    assert_eq!(field.node.exit_code(Duration::from_secs(20)).await, 0);
    all_can_be_read(kept.path());
}

/// A file of 80 MB with an `ext4` in it, mounted where flights are recorded: it can be frozen and can fail as a disk does.
struct Disk {
    _image: tempfile::NamedTempFile,
    at: PathBuf,
}

impl Disk {
    async fn mount(at: &Path) -> Self {
        let image = tempfile::NamedTempFile::new().expect("a file");
        image.as_file().set_len(80 << 20).expect("is long");
        let path = image.path().to_str().expect("is text").to_owned();
        must("mkfs.ext4", &["-q", "-F", &path]).await;
        fs::create_dir_all(at).expect("a folder");
        let options = "loop,errors=remount-ro";
        must("mount", &["-o", options, &path, at.to_str().expect("is text")]).await;
        Self {
            _image: image,
            at: at.to_owned(),
        }
    }

    /// The kernel's own switch for "an error was found": it makes the file system read-only.
    fn fail(&self) {
        let mounts = fs::read_to_string("/proc/mounts").expect("is there");
        let at = self.at.to_str().expect("is text");
        let line = mounts.lines().find(|line| line.split(' ').nth(1) == Some(at));
        let device = line
            .and_then(|line| line.split(' ').next()?.rsplit('/').next())
            .expect("is mounted");
        fs::write(format!("/sys/fs/ext4/{device}/trigger_fs_error"), "1").expect("fails");
    }

    async fn freeze(&self, how: &str) {
        must("fsfreeze", &[how, self.at.to_str().expect("is text")]).await;
    }
}

impl Drop for Disk {
    fn drop(&mut self) {
        for arguments in [["fsfreeze", "-u"], ["umount", "-l"]] {
            // What is not frozen cannot be thawed; what is not mounted is gone.
            let _ = std::process::Command::new(arguments[0])
                .arg(arguments[1])
                .arg(&self.at)
                .output();
        }
    }
}

fn run(folder: &Path) -> Process {
    Process::skein(&["run", "--config", folder.join("node.toml").to_str().expect("is text")])
}

#[tokio::test(flavor = "multi_thread")]
#[ignore = "long, and mounts a disk, as root: part of `cargo xtask test faults`"]
async fn a_disk_that_stalls_and_one_that_fails_change_nothing_in_flight() {
    let mut field = Field::start_by(run, VEHICLES, "fly_on").await;
    field.kill_for(Duration::ZERO).await;
    let flights = field.folder().join("flights");
    let disk = Disk::mount(&flights).await;
    field.start_again();
    field.form().await;

    let (before, flown) = (newest(&field).await, setpoints(&field));
    disk.freeze("-f").await;
    let silent = told(&field, before, "the disk does not answer").await;
    tokio::time::sleep(Duration::from_secs(10)).await;
    flies_on(&field, before, &flown).await;
    let flown = setpoints(&field);
    disk.freeze("-u").await;
    let again = told(&field, silent, "flights are recorded again").await;
    flies_on(&field, before, &flown).await;

    let flown = setpoints(&field);
    disk.fail();
    told(&field, again, "flights are not recorded").await;
    flies_on(&field, before, &flown).await;
    field.node.signal("TERM").await;
    assert_eq!(field.node.exit_code(Duration::from_secs(20)).await, 0);
    all_can_be_read(&flights);
}
