//! What a bag would hold: everything that ten vehicles tell in a minute of flight, taken by a program of ROS 2 and held against itself and
//! against the node's own pictures.
//!
//! Must never do: judge by the clock on the wall. On a busy machine the node itself may be late; what it did tell must all have come.

use crate::rig::{Watched, fresh_domain, names, program, swarm_with};
use anyhow::{Context, Result, ensure};
use skein_domain::{FormationRequest, Shape};
use skein_runtime::NodeHandle;
use skein_testkit::Swarm;
use skein_tests_interop::{Ros2, say};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

const VEHICLES: u8 = 10;
const SECONDS: f64 = 64.0;
/// What must be there of it: from when the last began to when the first ended.
const SECONDS_WHOLE: f64 = 60.0;
const SECOND_NS: u64 = 1_000_000_000;
/// Between two of the node's pictures of the fleet.
const MOTION_PERIOD_NS: u64 = SECOND_NS / 20;
const STATUS_PERIOD_NS: u64 = SECOND_NS / 2;
/// The node's clock is put on the system's at two moments that are not quite the same.
const SAME_NS: u64 = 4_000_000;

type Stamps = BTreeSet<u64>;

/// What the node itself says of where its vehicles are: by vehicle the moments, of the system's clock.
async fn pictures(node: NodeHandle, vehicles: &mut BTreeMap<String, Stamps>) {
    loop {
        let (fleet, now) = (node.snapshot(), node.now());
        let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        for vehicle in &fleet.vehicles {
            if let Some(at) = vehicle.kinematics {
                let age = Duration::from_micros(now.0.saturating_sub(at.measured.0));
                let stamp = since_1970.saturating_sub(age).as_nanos() as u64;
                let known = vehicles.entry(format!("uav_{}", vehicle.id)).or_default();
                // The same picture, seen again.
                if known.last().is_none_or(|last| stamp > last + SAME_NS) {
                    known.insert(stamp);
                }
            }
        }
        tokio::time::sleep(Duration::from_millis(4)).await;
    }
}

/// One shape after the other, so that all of them move.
async fn fly(node: NodeHandle) -> Result<()> {
    for shape in [Shape::Wedge, Shape::Line, Shape::Circle].into_iter().cycle() {
        let receipt = node
            .set_formation(FormationRequest::new(shape, 6.0))
            .await
            .context("a formation")?;
        say(&format!(
            "  {shape:?} of {}, {:.1} s",
            receipt.members.len(),
            receipt.duration_s
        ));
        tokio::time::sleep(Duration::from_secs(15)).await;
    }
    Ok(())
}

fn within(stamps: &Stamps, from: u64, to: u64) -> Stamps {
    stamps.range(from..to).copied().collect()
}

/// The longest time between two that follow each other.
fn longest_gap_ns(stamps: &Stamps) -> u64 {
    let gaps = stamps.iter().zip(stamps.iter().skip(1)).map(|(a, b)| b - a);
    gaps.max().unwrap_or(u64::MAX)
}

/// What was taken, by topic. In order, nothing twice.
fn taken(path: &Path) -> Result<BTreeMap<String, Stamps>> {
    let text = std::fs::read_to_string(path).context("what was recorded")?;
    let lists: BTreeMap<String, Vec<u64>> = serde_json::from_str(&text)?;
    let mut taken = BTreeMap::new();
    for (topic, list) in lists {
        // A fix is told again when the vehicle has not been heard since; everything else is told once.
        let again = list.windows(2).filter(|pair| pair[0] >= pair[1]).count();
        ensure!(
            again == 0 || topic.ends_with("nav_sat_fix"),
            "{topic}: {again} out of order or twice"
        );
        taken.insert(topic, list.into_iter().collect());
    }
    Ok(taken)
}

/// Holds what was taken of one vehicle against itself and what the node knows.
fn is_whole(taken: &BTreeMap<String, Stamps>, name: &str, own: &Stamps, from: u64, to: u64) -> Result<String> {
    let of =
        |topic: &str| Ok::<_, anyhow::Error>(within(taken.get(topic).with_context(|| topic.to_owned())?, from, to));
    let topic = |part: &str| of(&format!("/skein/{name}/{part}"));
    // All three are told at once: what only one of them has, the others have lost.
    let (pose, odometry, transform) = (
        topic("pose")?,
        topic("odometry")?,
        of(&format!("/tf {name}/base_link"))?,
    );
    let lost = |a: &Stamps, b: &Stamps| a.difference(b).count();
    ensure!(
        pose == transform && odometry == transform,
        "{name}: of {} transforms {} poses and {} odometries are missing; {} and {} have no transform",
        transform.len(),
        lost(&transform, &pose),
        lost(&transform, &odometry),
        lost(&pose, &transform),
        lost(&odometry, &transform)
    );
    let own = within(own, from, to);
    let near = |at: &u64| pose.range(at - SAME_NS..at + SAME_NS).next().is_some();
    let untold = own.iter().filter(|at| !near(at)).count();
    let (gap_ns, own_gap_ns) = (longest_gap_ns(&pose), longest_gap_ns(&own));
    ensure!(
        gap_ns <= own_gap_ns + 3 * MOTION_PERIOD_NS,
        "{name}: a gap of {gap_ns} ns between poses, {own_gap_ns} ns between the node's own"
    );
    // Who speaks may have been late for a picture, as the machine has it.
    ensure!(
        untold * 20 <= own.len(),
        "{name}: {untold} of {} were not told",
        own.len()
    );
    let (battery, state, fix) = (topic("battery")?, topic("state")?, topic("nav_sat_fix")?);
    ensure!(
        battery == state,
        "{name}: {} batteries, {} states",
        battery.len(),
        state.len()
    );
    for status in [&battery, &fix] {
        let gap_ns = longest_gap_ns(status);
        ensure!(
            gap_ns <= own_gap_ns + 3 * STATUS_PERIOD_NS,
            "{name}: a gap of {gap_ns} ns"
        );
    }
    Ok(format!(
        "{name}: {} poses, {untold} of {} pictures untold, longest gap {} ms (own {} ms), {} states",
        pose.len(),
        own.len(),
        gap_ns / 1_000_000,
        own_gap_ns / 1_000_000,
        state.len()
    ))
}

async fn recorded(swarm: &Swarm, watched: &mut Watched) -> Result<BTreeMap<String, Stamps>> {
    let mut own = BTreeMap::new();
    tokio::select! {
        ended = async {
            while watched.next().await?.is_some() {}
            Ok::<_, anyhow::Error>(())
        } => ended?,
        failed = fly(swarm.node()) => failed?,
        () = pictures(swarm.node(), &mut own) => {}
    }
    Ok(own)
}

#[tokio::test(flavor = "multi_thread")]
#[ignore = "long: part of `cargo xtask test interop`"]
async fn a_minute_of_ten_vehicles_is_recorded_without_a_gap() -> Result<()> {
    let domain_id = fresh_domain();
    let ros2 = tokio::task::spawn_blocking(Ros2::jazzy).await??;
    // Poses that are sent once may be lost where the system has no room; a bag that must have each asks for them to be repeated.
    let swarm = swarm_with(VEHICLES, domain_id, |config, _| config.ros2.reliable_motion = true).await;
    swarm.take_off(10.0).await;
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("stamps.json");
    let mut arguments = vec!["reliable".to_owned(), SECONDS.to_string(), path.display().to_string()];
    arguments.extend(names(VEHICLES));
    let script = program(
        &ros2,
        domain_id,
        "ros2_recorder.py",
        &arguments,
        Duration::from_secs(400),
    )?;
    let mut watched = Watched::new(script);
    let own = recorded(&swarm, &mut watched).await?;
    ensure!(watched.phases() == ["recording", "recorded"], "{:?}", watched.phases());
    let taken = taken(&path)?;
    let begins = taken
        .values()
        .filter_map(|stamps| stamps.first())
        .max()
        .context("stamps")?;
    let ends = taken
        .values()
        .filter_map(|stamps| stamps.last())
        .min()
        .context("stamps")?;
    // What was sent at the edges may have come on one topic and not yet on another.
    let (from, to) = (begins + SECOND_NS / 10, ends - SECOND_NS / 10);
    let seconds = (to - from) as f64 / SECOND_NS as f64;
    ensure!(seconds > SECONDS_WHOLE, "{seconds} s");
    let mut faults = Vec::new();
    for name in names(VEHICLES) {
        match is_whole(&taken, &name, own.get(&name).context("its own")?, from, to) {
            Ok(line) => say(&format!("  {line}")),
            Err(fault) => faults.push(format!("{fault:#}")),
        }
    }
    ensure!(faults.is_empty(), "{faults:#?}");
    swarm.stop().await;
    Ok(())
}
