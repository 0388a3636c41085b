//! pymavlink as an independent judge: every frame of several vehicles decodes, and the conversation goes as with a PX4.

use anyhow::{Context, Result, ensure};
use serde_json::Value;
use skein_sim::{PortPlan, SimSettings, Simulation};
use skein_tests_interop::Script;
use std::net::UdpSocket;
use std::time::Duration;

#[test]
fn every_frame_decodes_and_every_question_is_answered() -> Result<()> {
    let port = UdpSocket::bind("127.0.0.1:0")?.local_addr()?.port();
    let arguments = [port.to_string(), "--converse-with".into(), "2".into()];
    let mut script = Script::start("check_frames.py", &arguments, Duration::from_secs(120))?;
    let listening = script.report()?.context("the script listens")?;
    ensure!(listening["phase"] == "listening");
    let ports = PortPlan::SendTo(format!("127.0.0.1:{port}").parse()?);
    let simulation = Simulation::start(SimSettings {
        vehicles: 2,
        ports,
        ..SimSettings::default()
    })?;
    let report = script.report()?.context("a report at the end")?;
    ensure!(script.report()?.is_none(), "nothing after the end");
    ensure!(report["unknown_result"] == 3, "UNSUPPORTED: {report}");
    ensure!(report["stored"] == 3, "{report}");
    ensure!(report["version"] == 17_956_928, "{report}");
    let frames = report["frames"].as_u64().context("frames")?;
    // A busy machine may drop some, but what comes must be good.
    let lost = report["lost"].as_u64().context("lost")?;
    ensure!(frames > 2_000, "{frames} frames");
    ensure!(lost * 5 < frames, "{lost} lost of {frames}");
    for system in ["1", "2"] {
        let kinds: &Value = &report["systems"][system];
        for kind in [
            "HEARTBEAT",
            "SYS_STATUS",
            "SYSTEM_TIME",
            "GPS_RAW_INT",
            "ATTITUDE",
            "ATTITUDE_QUATERNION",
            "LOCAL_POSITION_NED",
            "GLOBAL_POSITION_INT",
            "SERVO_OUTPUT_RAW",
            "VFR_HUD",
            "ATTITUDE_TARGET",
            "POSITION_TARGET_LOCAL_NED",
            "HIGHRES_IMU",
            "TIMESYNC",
            "ALTITUDE",
            "BATTERY_STATUS",
            "ESTIMATOR_STATUS",
            "HOME_POSITION",
            "EXTENDED_SYS_STATE",
            "ODOMETRY",
            "GPS_GLOBAL_ORIGIN",
            "PARAM_VALUE",
        ] {
            ensure!(
                kinds[kind].as_u64().is_some_and(|n| n > 0),
                "no {kind} from system {system}: {kinds}"
            );
        }
    }
    simulation.stop();
    Ok(())
}
