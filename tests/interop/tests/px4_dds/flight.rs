//! The oldest and the newest release at once: found, let in, flown.

use crate::rig::{Flown, PATIENCE, PLACE, Skein, domain, nothing_wrong, number, peer, triple, vehicle};
use anyhow::{Context, Result, ensure};
use serde_json::json;
use skein_domain::link::{LinkEvent, StreamState, VehicleLink};
use skein_domain::setpoint::LocalSetpoint;
use skein_domain::{AutopilotCommand, FlightMode, LandedState, Refusal, SystemId, VelocityNed};
use skein_link_dds::definitions::Release;
use skein_tests_interop::Peer;
use std::sync::Arc;

#[test]
fn two_releases_fly_at_once() -> Result<()> {
    let (domain, mut peer) = (domain(), peer()?);
    let skein = Skein::start(domain)?;
    // One without its agent's clock, one with it, as PX4 is by default.
    let old = json!({"at": [1.5, -2.5], "stamps": "boot"});
    let new = json!({"at": [-4.0, 8.0], "stamps": "agent"});
    peer.say(&vehicle("old", domain, "px4_1", "1.15", 2, &old))?;
    peer.say(&vehicle("new", domain, "px4_2", "after 1.18", 3, &new))?;
    let mut old = skein.vehicle("px4_1", 2)?;
    let mut new = skein.vehicle("px4_2", 3)?;
    ensure!(old.releases == [Release::V1_15] && new.releases.contains(&Release::Later));
    std::thread::scope(|scope| {
        let other = scope.spawn(|| fly(&peer, &mut old, "old"));
        fly(&peer, &mut new, "new")?;
        other.join().map_err(|_| anyhow::anyhow!("it panicked"))?
    })
}

#[test]
fn all_releases_are_known_for_what_they_are() -> Result<()> {
    let (domain, mut peer) = (domain(), peer()?);
    let skein = Skein::start(domain)?;
    let all = ["1.15", "1.16", "1.17", "1.18", "after 1.18"];
    for (number, release) in (1..).zip(all) {
        let beside = if number > 1 {
            json!({"beside": "1.15"})
        } else {
            json!({})
        };
        peer.say(&vehicle(
            release,
            domain,
            &format!("px4_{number}"),
            release,
            number,
            &beside,
        ))?;
    }
    for (number, release) in (1..).zip(all) {
        let mut found = skein.vehicle(&format!("px4_{number}"), number)?;
        found.until("it says everything", |t, _| {
            t.local_frame.is_some()
                && t.battery.remaining == Some(0.75)
                && t.gnss.satellites == 14
                && t.global.is_some()
                // 1.15 does not say where it was launched, nor whether it stands but for its status.
                && (t.home.is_some() || release == "1.15")
                && t.landed == LandedState::OnGround
        })?;
        let known: Vec<_> = found.releases.iter().map(ToString::to_string).collect();
        // What came after 1.18 has another launch place alone, which may be found later than all that is needed.
        let alike = release.contains("1.18") && known == ["1.18", "after 1.18"];
        ensure!(known == [release] || alike, "{release}: {known:?}");
    }
    Ok(())
}

/// A whole flight; what the vehicle really does is the peer's to say.
fn fly(peer: &Peer, flown: &mut Flown, who: &str) -> Result<()> {
    says_the_truth(peer, flown, who)?;
    let early = flown.ask(AutopilotCommand::TakeOff { height_m: 5.0 })?;
    ensure!(matches!(early, Err(Refusal::NotPermitted { .. })), "{early:?}");
    let over = flown.enter_offboard()?;
    let in_the_air = flown.ask(AutopilotCommand::Disarm)?;
    let Err(Refusal::Autopilot { result, .. }) = in_the_air else {
        anyhow::bail!("{in_the_air:?}")
    };
    ensure!(result == "temporarily_rejected", "{result}");
    let goal = [over[0] + 6.0, over[1] - 3.0, -7.0];
    flown.stream_position(goal);
    flown.until("it is there", |_, _| {
        let (truth, mut off) = (triple(&peer.truth(who), "position"), 0.0_f64);
        truth
            .iter()
            .zip(goal)
            .for_each(|(is, to)| off = off.max((is - to).abs()));
        off < 0.3
    })?;
    let truth = peer.truth(who);
    ensure!((number(&truth, "yaw") - 1.0).abs() < 1e-3, "the nose: {truth}");
    flown.setpoint = Some(LocalSetpoint {
        velocity: Some(VelocityNed::new(0.0, 1.5, 0.0)),
        ..LocalSetpoint::default()
    });
    flown.until("it goes east", |_, _| triple(&peer.truth(who), "velocity")[1] > 1.3)?;
    stop_the_stream(peer, flown, who)?;
    flown.order(AutopilotCommand::Land)?;
    flown.until("it stands", |t, _| !t.armed && t.landed == LandedState::OnGround)?;
    let stands = |told: &skein_tests_interop::PeerReport| (told.truth[who]["landed"] == true).then_some(());
    peer.wait(PATIENCE, "the ground", stands)?;
    nothing_wrong(peer, who, &[400, 22, 176, 21])
}

fn says_the_truth(peer: &Peer, flown: &mut Flown, who: &str) -> Result<()> {
    let telemetry = flown.until("it says where it is", |t, _| {
        t.local.is_some() && t.local_frame.is_some() && t.global.is_some() && t.gnss.satellites == 14
    })?;
    let truth = peer.truth(who);
    let (local, at) = (telemetry.local.context("local")?, triple(&truth, "position"));
    ensure!(
        (local.north_m - at[0]).hypot(local.east_m - at[1]) < 0.01 && (local.down_m - at[2]).abs() < 0.01,
        "{local:?} {truth}"
    );
    ensure!((telemetry.yaw_rad - 0.3).abs() < 1e-3, "{}", telemetry.yaw_rad);
    let frame = telemetry.local_frame.context("a frame")?;
    let off_m = (frame.origin.latitude_deg - PLACE[0]).abs() * 111_000.0;
    ensure!(
        off_m < 0.1 && (frame.origin.altitude_amsl_m - PLACE[2]).abs() < 0.1,
        "{frame:?}"
    );
    ensure!(flown.link.system_id() == SystemId(if who == "old" { 2 } else { 3 }));
    let link = Arc::clone(&flown.link);
    let now = flown.clock();
    flown.until("its rates are known", |_, _| {
        let (_, health) = link.read(now.now());
        health.connected && health.receive_rate_hz > 30.0 && health.clock_offset_s.is_some()
    })?;
    Ok(())
}

/// The vehicle notices that the stream has ended, and it is not taken for what was asked for.
fn stop_the_stream(peer: &Peer, flown: &mut Flown, who: &str) -> Result<()> {
    flown.setpoint = None;
    flown.link.stop_stream(flown.now());
    peer.wait(PATIENCE, "the stream's loss", |told| {
        (told.truth[who]["streams_lost"] == 1).then_some(())
    })?;
    flown.until("that is told", |t, events| {
        let left = LinkEvent::ModeChanged {
            from: FlightMode::Offboard,
            to: FlightMode::Hold,
            commanded: false,
        };
        t.mode == FlightMode::Hold && events.contains(&left)
    })?;
    ensure!(flown.link.in_failsafe() && flown.link.stream_state() == StreamState::Stopped);
    Ok(())
}
