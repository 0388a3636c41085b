//! The program killed (`kill -9`) while it records video: what was recorded until the last second can be played.

use serde_json::Value;
use skein_sim::{PortPlan, SimSettings, Simulation};
use skein_testkit::{Process, eventually, free_tcp_port, free_udp_port, patience, plugins_dir};
use std::net::{Ipv4Addr, SocketAddr};
use std::path::Path;

/// So long is recorded.
const RECORDED_S: f64 = 5.0;
/// A part is written when it is a second long; the next one may be nearly whole.
const LOST_AT_MOST_S: f64 = 2.0;
/// Ticks of the file's clock in a second.
const TIMESCALE: f64 = 90_000.0;

#[tokio::test(flavor = "multi_thread")]
async fn what_was_recorded_when_the_program_was_killed_can_be_played() {
    let (web, port) = (free_tcp_port(), free_udp_port());
    let folder = tempfile::tempdir().expect("a folder");
    let simulation = Simulation::start(SimSettings {
        vehicles: 1,
        ports: PortPlan::SendTo(SocketAddr::from((Ipv4Addr::LOCALHOST, port))),
        ..SimSettings::default()
    })
    .expect("a simulation");
    let simulated = "source = \"synthetic\"\nrate_hz = 12.0\nwidth_px = 480\nheight_px = 360";
    let mut node = run(folder.path(), web, port, simulated);
    live(web).await;
    let recording = format!("http://127.0.0.1:{web}/api/v1/vehicles/1/payloads/camera/video/recording");
    let begun = reqwest::Client::new().post(recording).send().await.expect("answered");
    assert!(begun.status().is_success(), "{}", begun.status());
    let recordings = folder.path().join("recordings");
    let recorded_s = eventually(patience(), "a recording of some seconds", async || {
        let last_s = last_place_s(&recordings)?;
        (last_s > RECORDED_S).then_some(last_s)
    })
    .await;
    node.kill().await;

    let video = named(&recordings, "mp4").expect("a recording");
    let bytes = std::fs::read(&video).expect("readable");
    let parts = parts_s(&bytes);
    let last_s = parts.last().expect("a part");
    assert!(recorded_s - last_s < LOST_AT_MOST_S + 1.0, "{recorded_s} s: {parts:?}");

    // It is a video like any other.
    let (web, port) = (free_tcp_port(), free_udp_port());
    let played = format!("source = \"video\"\npath = {video:?}");
    let node = run(folder.path(), web, port, &played);
    simulation.stop();
    let simulation = Simulation::start(SimSettings {
        vehicles: 1,
        ports: PortPlan::SendTo(SocketAddr::from((Ipv4Addr::LOCALHOST, port))),
        ..SimSettings::default()
    })
    .expect("a simulation");
    let stream = live(web).await;
    assert_eq!(
        (&stream["width_px"], &stream["height_px"]),
        (&480.into(), &360.into()),
        "{stream}"
    );
    drop(node);
    simulation.stop();
}

/// A node with one camera.
fn run(folder: &Path, web: u16, port: u16, camera: &str) -> Process {
    let config = format!(
        "[[endpoints]]\naddress = \"udp-listen://127.0.0.1:{port}\"\n[web]\nlisten = \"127.0.0.1:{web}\"\n[plugins]\ndirectories = [{:?}]\n[[adopt]]\n[[adopt.payloads]]\nname = \"camera\"\nplugin = \"camera\"\n[adopt.payloads.config]\n{camera}\n",
        plugins_dir()
    );
    let file = folder.join("node.toml");
    std::fs::write(&file, config).expect("is written");
    Process::skein(&["run", "--config", file.to_str().expect("is text")])
}

/// The stream of its camera, as soon as pictures come.
async fn live(web: u16) -> Value {
    eventually(patience(), "the camera is live", async || {
        let answer = reqwest::get(format!("http://127.0.0.1:{web}/api/v1/video"))
            .await
            .ok()?;
        let streams: Value = answer.json().await.ok()?;
        let stream = streams["streams"].get(0)?.clone();
        (stream["state"] == "live" && stream["width_px"].is_u64()).then_some(stream)
    })
    .await
}

fn named(recordings: &Path, extension: &str) -> Option<std::path::PathBuf> {
    let mut files = std::fs::read_dir(recordings)
        .ok()?
        .filter_map(|entry| Some(entry.ok()?.path()));
    files.find(|path| path.extension().is_some_and(|is| is == extension))
}

/// How long it is recorded already, by what is written beside the pictures.
fn last_place_s(recordings: &Path) -> Option<f64> {
    let lines = std::fs::read_to_string(named(recordings, "jsonl")?).ok()?;
    let last: Value = serde_json::from_str(lines.lines().last()?).ok()?;
    last["at_s"].as_f64()
}

/// When each whole part of the file begins: a `moof` box, with the `mdat` box that belongs to it.
fn parts_s(mut file: &[u8]) -> Vec<f64> {
    let mut parts = Vec::new();
    let mut begins_s = None;
    while let Some((head, _)) = file.split_first_chunk::<8>() {
        let size = u32::from_be_bytes([head[0], head[1], head[2], head[3]]) as usize;
        let Some(content) = file.get(8..size) else { break };
        match &head[4..] {
            b"moof" => begins_s = decode_time_s(content),
            b"mdat" => parts.extend(begins_s.take()),
            _ => {}
        }
        file = &file[size..];
    }
    parts
}

/// The time in its `tfdt` box.
fn decode_time_s(moof: &[u8]) -> Option<f64> {
    let at = moof.windows(4).position(|name| name == b"tfdt")? + 4;
    let long = *moof.get(at)? == 1;
    let digits = moof.get(at + 4..at + if long { 12 } else { 8 })?;
    let ticks = digits.iter().fold(0_u64, |ticks, digit| ticks << 8 | u64::from(*digit));
    Some(ticks as f64 / TIMESCALE)
}
