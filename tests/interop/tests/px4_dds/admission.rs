//! What is not as Skein knows it is refused with its reason, and nobody else with it.

use crate::rig::{Skein, domain, peer, vehicle};
use anyhow::{Result, ensure};
use serde_json::{Value, json};
use skein_link_dds::DdsEvent;

/// What is wrong with a vehicle, and what of the reason has to be said.
fn wrong() -> Vec<(&'static str, Value, &'static str)> {
    let fault = |topic: &str, what: Value| json!({ "faults": { topic: what } });
    let local = |what: Value| fault("vehicle_local_position", what);
    let status = |what: Value| fault("vehicle_status", what);
    let other_type = json!({"types": {"battery_status": "sensor_msgs::msg::dds_::BatteryState_"}});
    vec![
        (
            "type",
            other_type,
            "/type/fmu/out/battery_status_v1 carries sensor_msgs::msg::dds_::BatteryState_",
        ),
        (
            "version",
            json!({"versions": {"vehicle_status": 9}}),
            "/version/fmu/out/vehicle_status_v9 has version 9",
        ),
        (
            "old",
            json!({"versions": {"home_position": 7}}),
            "/old/fmu/out/home_position_v7 has version 7",
        ),
        (
            "cut",
            local(json!({"cut": 10})),
            "vehicle_local_position_v1 has samples of 20",
        ),
        ("stump", status(json!({"cut": 81})), "vehicle_status_v4 has samples of"),
        (
            "long",
            status(json!({"more": 2000})),
            "vehicle_status_v4 has samples of",
        ),
        ("nan", local(json!({"fields": {"x": "nan"}})), "x is NaN"),
        ("inf", local(json!({"fields": {"vz": "-inf"}})), "vz is -inf"),
        (
            "huge",
            local(json!({"fields": {"ref_lat": "1e308"}})),
            "ref_lat is 1000",
        ),
        (
            "bool",
            local(json!({"octets": {"xy_valid": 255}})),
            "does not fit its type",
        ),
        ("mode", status(json!({"octets": {"nav_state": 77}})), "nav_state is 77"),
        ("nobody", status(json!({"octets": {"system_id": 0}})), "system_id is 0"),
    ]
}

#[test]
fn what_does_not_fit_is_refused_with_its_reason_and_nobody_else() -> Result<()> {
    let (domain, mut peer) = (domain(), peer()?);
    let skein = Skein::start(domain)?;
    peer.say(&vehicle("good", domain, "good", "1.18", 1, &json!({})))?;
    for (id, (name, mut what, _)) in (2..).zip(wrong()) {
        what["beside"] = json!("good");
        peer.say(&vehicle(name, domain, name, "1.18", id, &what))?;
    }
    for (name, _, reason) in wrong() {
        let told = skein.wait(&format!("{name} is refused"), |event| match event {
            DdsEvent::Refused { namespace, mismatch } if namespace.name() == name => Some(mismatch.to_string()),
            _ => None,
        })?;
        ensure!(told.contains(reason), "{name}: {told}");
    }
    let mut good = skein.vehicle("good", 1)?;
    good.until("it says where it is", |t, _| t.local.is_some())?;
    let admitted: Vec<_> = skein.events().into_iter().filter(is_admitted).collect();
    ensure!(admitted.len() == 1, "{admitted:?}");
    Ok(())
}

fn is_admitted(event: &DdsEvent) -> bool {
    matches!(event, DdsEvent::Discovered { .. })
}

#[test]
#[ignore = "long: part of `cargo xtask test interop`"]
fn what_is_missing_is_named_and_taken_when_it_comes() -> Result<()> {
    let (domain, mut peer) = (domain(), peer()?);
    let skein = Skein::start(domain)?;
    let deaf = json!({"unread": ["vehicle_command", "trajectory_setpoint"]});
    let dumb = json!({"silent": ["vehicle_local_position"], "beside": "deaf"});
    peer.say(&vehicle("deaf", domain, "deaf", "1.17", 1, &deaf))?;
    peer.say(&vehicle("dumb", domain, "dumb", "1.17", 2, &dumb))?;
    // Encoded in the second version of CDR: the writer itself finds that nobody here reads that.
    let second = json!({"representation": "second", "beside": "deaf"});
    peer.say(&vehicle("second", domain, "second", "1.17", 3, &second))?;
    // Who records what is sent to it makes it no vehicle that listens; and whatever type they take it for, it is not refused for that.
    for topic in ["vehicle_command", "trajectory_setpoint"] {
        let name = format!("rt/deaf/fmu/in/{topic}");
        let recorder = json!({"do": "stranger", "who": topic, "domain": domain, "topic": name, "message": "Recorded", "reads": true});
        peer.say(&recorder)?;
    }
    // On a slow machine more may be missing at first.
    let misses = |of: &str, expected: &[&str]| {
        skein.wait(&format!("what {of} misses"), |event| match event {
            DdsEvent::Incomplete { namespace, missing } if namespace.name() == of => {
                missing.starts_with(expected).then_some(())
            }
            _ => None,
        })
    };
    misses("deaf", &["vehicle_command", "trajectory_setpoint"])?;
    misses("dumb", &["vehicle_local_position"])?;
    misses("second", &["vehicle_status", "vehicle_local_position"])?;
    peer.say(&json!({"do": "change", "who": "dumb", "silent": []}))?;
    skein.vehicle("dumb", 2)?;
    let refused = skein
        .events()
        .into_iter()
        .any(|event| matches!(event, DdsEvent::Refused { .. }));
    ensure!(!refused, "{:?}", skein.events());
    Ok(())
}
