//! A peer beside ROS 2: Cyclone DDS reads a vehicle by the names of its topics and types on the wire, and steers it.
//!
//! Must never do: need a ROS 2.

use crate::rig::{Watched, all_agree, fresh_domain, number, place, swarm};
use anyhow::{Context, Result, ensure};
use skein_tests_interop::{CYCLONE, CYCLONE_ON_LOOPBACK, Script, python_of};
use std::process::Command;
use std::time::Duration;

#[tokio::test(flavor = "multi_thread")]
async fn cyclone_dds_reads_a_vehicle_and_steers_it() -> Result<()> {
    let domain_id = fresh_domain();
    let mut python = Command::new(tokio::task::spawn_blocking(|| python_of(&CYCLONE)).await??);
    python.env("CYCLONEDDS_URI", CYCLONE_ON_LOOPBACK);
    let swarm = swarm(1, domain_id).await;
    swarm.ready().await;
    let arguments = [domain_id.to_string(), "uav_1".to_owned()];
    let mut watched = Watched::new(Script::start_by(
        python,
        "ros2_cyclone.py",
        &arguments,
        Duration::from_secs(400),
    )?);
    while let Some((phase, report)) = watched.next().await? {
        if phase == "steered" {
            let forward_m_s = number(&report["forward"])?;
            ensure!((1.2..2.5).contains(&forward_m_s), "{report}");
            continue;
        }
        all_agree(&report, &swarm, 1).context(phase.clone())?;
        let off_m = place(&report["composed"])?.distance_m(&place(&report["pose"])?);
        ensure!(off_m < 1e-6, "{phase}: transforms off by {off_m} m: {report}");
        if phase == "ground" {
            swarm.take_off(5.0).await;
        }
    }
    let phases = ["ground", "up", "steered", "stands"];
    ensure!(watched.phases() == phases, "{:?}", watched.phases());
    swarm.stop().await;
    Ok(())
}
