//! Vehicles that go and come back: started anew, in another release, two as one, another one in the same place.

use crate::rig::{Flown, PATIENCE, Skein, domain, nothing_wrong, peer, vehicle};
use anyhow::{Result, ensure};
use serde_json::{Value, json};
use skein_domain::link::{LinkEvent, StreamState};
use skein_domain::{AutopilotCommand, Refusal};
use skein_link_dds::DdsEvent;
use std::sync::Arc;
use std::time::Instant;

/// It is heard again, and known to have started anew; then it is flown like any other.
fn flies_again(flown: &mut Flown) -> Result<()> {
    flown.until("it is back", |_, events| events.contains(&LinkEvent::Regained))?;
    flown.until("it is known to have started anew", |_, events| {
        events.contains(&LinkEvent::Rebooted)
    })?;
    ensure!(
        flown.link.stream_state() == StreamState::Stopped,
        "nothing of before is sent"
    );
    flown.enter_offboard().map(|_| ())
}

/// It is silent, whatever the link was doing; what was streamed is not offered any more.
fn is_lost(flown: &mut Flown) -> Result<()> {
    flown.events.clear();
    flown.until("it is lost", |_, events| events.contains(&LinkEvent::Lost))?;
    flown.setpoint = None;
    Ok(())
}

#[test]
#[ignore = "long: part of `cargo xtask test interop`"]
fn one_that_starts_anew_is_taken_back_also_in_another_release() -> Result<()> {
    let (domain, mut first) = (domain(), peer()?);
    let skein = Skein::start(domain)?;
    first.say(&vehicle("it", domain, "px4_1", "1.15", 5, &json!({})))?;
    let mut flown = skein.vehicle("px4_1", 5)?;
    flown.enter_offboard()?;
    // Its computer starts anew: another participant after a while, its clock and its place from the beginning.
    first.say(&json!({"do": "stop", "who": "it"}))?;
    is_lost(&mut flown)?;
    first.say(&vehicle("it", domain, "px4_1", "1.15", 5, &json!({})))?;
    flies_again(&mut flown)?;
    // Without a farewell, and with a newer PX4 after it: other names, other messages.
    drop(first);
    is_lost(&mut flown)?;
    let mut second = peer()?;
    second.say(&vehicle("it", domain, "px4_1", "after 1.18", 5, &json!({})))?;
    flies_again(&mut flown)?;
    nothing_wrong(&second, "it", &[400, 22, 176])?;
    let links = skein
        .events()
        .into_iter()
        .filter(|event| matches!(event, DdsEvent::Discovered { .. }));
    ensure!(links.count() == 1, "the link stays the same: {:?}", skein.events());
    Ok(())
}

#[test]
#[ignore = "long: part of `cargo xtask test interop`"]
fn two_as_one_get_nothing_until_one_is_gone() -> Result<()> {
    let (domain, mut peer) = (domain(), peer()?);
    let skein = Skein::start(domain)?;
    peer.say(&vehicle("a", domain, "px4_1", "1.18", 4, &json!({})))?;
    let mut flown = skein.vehicle("px4_1", 4)?;
    flown.until("it is heard", |t, _| t.local.is_some())?;
    peer.say(&vehicle("b", domain, "px4_1", "1.18", 4, &json!({"at": [50.0, 0.0]})))?;
    skein.wait("two", |event| {
        matches!(event, DdsEvent::Duplicate { system_id: 4, .. }).then_some(())
    })?;
    let refused = flown.ask(AutopilotCommand::Arm)?;
    ensure!(
        refused == Err(Refusal::DuplicateSystemId { system_id: 4 }),
        "{refused:?}"
    );
    flown.stream_position([0.0, 0.0, -5.0]);
    // Not the first of them is left but the second.
    peer.say(&json!({"do": "stop", "who": "a"}))?;
    let cleared = |event: &DdsEvent| matches!(event, DdsEvent::DuplicateCleared { system_id: 4, .. }).then_some(());
    skein.wait("one", cleared)?;
    ensure!(peer.truth("b")["setpoints"] == 0, "{}", peer.truth("b"));
    flown.setpoint = None;
    flown.until("it is the second", |t, _| {
        t.local.is_some_and(|local| local.north_m > 49.0)
    })?;
    flown.order(AutopilotCommand::Arm)?;
    nothing_wrong(&peer, "b", &[400])
}

#[test]
#[ignore = "long: part of `cargo xtask test interop`"]
fn two_that_come_up_together_get_nothing_either() -> Result<()> {
    let (domain, mut peer) = (domain(), peer()?);
    for who in ["a", "b"] {
        peer.say(&vehicle(who, domain, "px4_1", "1.18", 4, &json!({})))?;
    }
    let skein = Skein::start(domain)?;
    let mut flown = skein.vehicle("px4_1", 4)?;
    skein.wait("two", |event| {
        matches!(event, DdsEvent::Duplicate { system_id: 4, .. }).then_some(())
    })?;
    let refused = flown.ask(AutopilotCommand::Arm)?;
    ensure!(
        refused == Err(Refusal::DuplicateSystemId { system_id: 4 }),
        "{refused:?}"
    );
    ensure!(peer.reports().is_empty(), "{:?}", peer.reports());
    Ok(())
}

#[test]
#[ignore = "long: part of `cargo xtask test interop`"]
fn another_vehicle_in_its_place_gets_nothing_of_what_was_meant_for_it() -> Result<()> {
    let (domain, mut peer) = (domain(), peer()?);
    let skein = Skein::start(domain)?;
    peer.say(&vehicle("first", domain, "px4_1", "1.16", 8, &json!({})))?;
    let mut first = skein.vehicle("px4_1", 8)?;
    first.until("it is heard", |t, _| t.local.is_some())?;
    first.stream_position([3.0, 0.0, -5.0]);
    first.until("its setpoints come", |_, _| peer.truth("first")["setpoints"] != 0)?;
    peer.say(&json!({"do": "stop", "who": "first"}))?;
    first.until("it is lost", |_, events| events.contains(&LinkEvent::Lost))?;
    peer.say(&vehicle("other", domain, "px4_1", "1.16", 9, &json!({})))?;
    let mut other = skein.vehicle("px4_1", 9)?;
    ensure!(!Arc::ptr_eq(&first.link, &other.link));
    let refused = first.ask(AutopilotCommand::Arm)?;
    ensure!(matches!(refused, Err(Refusal::LinkLost { .. })), "{refused:?}");
    // What was under way before the other one was known still comes, and is told late; a stream that went on would never be still.
    let mut heard = Value::Null;
    let begun = Instant::now();
    while heard != peer.truth("other")["setpoints"] {
        heard = peer.truth("other")["setpoints"].clone();
        ensure!(begun.elapsed() < PATIENCE, "it still comes: {}", peer.truth("other"));
        for _ in 0..25 {
            first.step()?;
        }
    }
    other.order(AutopilotCommand::Arm)?;
    peer.wait(PATIENCE, "armed", |told| {
        (told.truth["other"]["armed"] == true).then_some(())
    })
}
