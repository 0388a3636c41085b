//! Simulated vehicles on DDS, found, admitted and flown by the link that flies real ones: another participant of a domain of their own.
#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

#[path = "behind_its_agent/rig.rs"]
mod rig;

use rig::{Pilot, Rig, calm};
use skein_domain::link::LinkEvent;
use skein_domain::{AutopilotCommand, FlightMode, LandedState, LocalPositionNed, Refusal};
use skein_link_dds::DdsEvent;
use skein_link_dds::definitions::Release;
use skein_sim::{Face, Faces, Fault, Impairment, ModeCause, PortPlan, SimSettings};
use skein_sim_dds::{DdsCarrier, DdsSettings, Namespaces, OpenError, StartError};
use std::net::UdpSocket;
use std::sync::Arc;
use std::time::Duration;

/// Height of the flights in metres.
const HEIGHT_M: f64 = 3.0;

#[test]
fn vehicles_of_every_release_are_admitted_as_what_they_are() {
    let mut rig = Rig::start(calm(Release::ALL.len()), |dds| {
        dds.others = (1..).zip(Release::ALL).collect();
    });
    rig.until("all are admitted", |rig| rig.links().len() == Release::ALL.len());
    for (system_id, release) in (1..).zip(Release::ALL) {
        let releases = rig.releases(system_id);
        assert!(releases.contains(&release), "{release}: {releases:?}");
        // Only what a release has in common with its neighbours can be taken for theirs.
        assert!(releases.len() <= 2, "{release}: {releases:?}");
        let namespace = rig.link(system_id).namespace().to_string();
        assert_eq!(namespace, Namespaces::Instances.of(system_id).to_string());
        rig.until("its telemetry agrees with the truth", |rig| {
            rig.agrees_with_truth(system_id)
        });
    }
    let refused = rig.events(|event| matches!(event, DdsEvent::Refused { .. } | DdsEvent::Ignored { .. }));
    assert!(refused.is_empty(), "{refused:?}");
}

#[test]
fn one_flies_there_by_setpoints_survives_their_end_and_lands() {
    let mut rig = Rig::start(calm(1), |dds| dds.namespaces = Namespaces::SystemIds);
    let mut pilots = rig.pilots();
    assert_eq!(rig.link(1).namespace().name(), "px4_1");
    rig.until("it is ready", |rig| rig.telemetry(1).ready_to_arm == Some(true));
    // Without setpoints the link does not even ask.
    let refused = rig.ask(&mut pilots, 0, AutopilotCommand::EnterOffboard);
    assert!(refused.is_err(), "{refused:?}");
    rig.take_off(&mut pilots, HEIGHT_M);
    let above = rig.local(1);
    let there = LocalPositionNed::new(above.north_m + 4.0, above.east_m - 3.0, above.down_m - 1.0);
    rig.fly_to(&mut pilots, &[there]);

    rig.stop_stream(&mut pilots[0]);
    rig.fly_until(&mut pilots, "the failsafe acts", |rig| rig.truth(1).failsafe);
    assert_eq!(rig.truth(1).mode, FlightMode::Return);
    rig.fly_until(&mut pilots, "the link has seen it", |rig| rig.link(1).in_failsafe());
    let causes: Vec<_> = rig.truth(1).mode_changes.iter().map(|change| change.cause).collect();
    assert_eq!(causes.last(), Some(&ModeCause::Failsafe));

    pilots[0].stream(there);
    assert_eq!(rig.ask(&mut pilots, 0, AutopilotCommand::EnterOffboard), Ok(()));
    rig.fly_to(&mut pilots, &[there]);
    rig.land(&mut pilots);
    assert_eq!(rig.telemetry(1).landed, LandedState::OnGround);
}

#[test]
#[ignore = "long: part of `cargo xtask test wire`"]
fn six_fly_at_once() {
    let mut rig = Rig::start(calm(6), |_| {});
    let mut pilots = rig.pilots();
    rig.take_off(&mut pilots, HEIGHT_M);
    let there: Vec<_> = pilots
        .iter()
        .map(|pilot| {
            let above = rig.local(pilot.system_id);
            LocalPositionNed::new(
                above.north_m + 2.0 + f64::from(pilot.system_id),
                above.east_m,
                above.down_m,
            )
        })
        .collect();
    rig.fly_to(&mut pilots, &there);
    let frame = rig.simulation.truth();
    assert!(frame.smallest_distance_m().is_some_and(|metres| metres > 3.0));
    rig.land(&mut pilots);
}

#[test]
fn a_cut_face_is_lost_and_regained_and_the_other_stays() {
    let listener = UdpSocket::bind("127.0.0.1:0").unwrap();
    listener.set_read_timeout(Some(Duration::from_millis(200))).unwrap();
    let settings = SimSettings {
        faces: Faces::Both,
        ports: PortPlan::SendTo(listener.local_addr().unwrap()),
        ..calm(1)
    };
    let mut rig = Rig::start(settings, |_| {});
    let mut pilots = rig.pilots();
    rig.take_off(&mut pilots, HEIGHT_M);
    let cut = |face, cut| Fault::Cut { face, cut };
    rig.simulation.inflict(1, cut(Face::Dds, true)).unwrap();
    rig.fly_until(&mut pilots, "its failsafe acts", |rig| rig.truth(1).failsafe);
    rig.until_told(&mut pilots, 0, &LinkEvent::Lost);
    assert!(!rig.is_connected(1));
    until_frames_come(&listener, &mut rig, &mut pilots);
    let refused = rig.ask(&mut pilots, 0, AutopilotCommand::Land);
    assert!(matches!(refused, Err(Refusal::LinkLost { .. })), "{refused:?}");

    rig.simulation.inflict(1, cut(Face::Mavlink, true)).unwrap();
    rig.simulation.inflict(1, cut(Face::Dds, false)).unwrap();
    rig.until_told(&mut pilots, 0, &LinkEvent::Regained);
    until_silent(&listener, &mut rig, &mut pilots);
    assert_eq!(rig.ask(&mut pilots, 0, AutopilotCommand::EnterOffboard), Ok(()));
    // Through bad air as well.
    let bad = Impairment {
        loss: 0.2,
        delay_s: 0.04,
        jitter_s: 0.02,
    };
    rig.simulation.impair_face(1, Face::Dds, bad).unwrap();
    rig.land(&mut pilots);
}

/// Flies until more frames of MAVLink have come than a socket keeps: they are still sent.
fn until_frames_come(listener: &UdpSocket, rig: &mut Rig, pilots: &mut [Pilot]) {
    let (mut buffer, mut frames) = ([0; 512], 0);
    rig.fly_until(pilots, "frames come", |_| {
        frames += (0..100).take_while(|_| listener.recv_from(&mut buffer).is_ok()).count();
        frames > 1500
    });
}

/// Flies until no frame of MAVLink comes any more.
fn until_silent(listener: &UdpSocket, rig: &mut Rig, pilots: &mut [Pilot]) {
    let mut buffer = [0; 512];
    rig.fly_until(pilots, "MAVLink is silent", |_| {
        (0..100).any(|_| listener.recv_from(&mut buffer).is_err())
    });
}

#[test]
fn what_cannot_be_is_said() {
    let beyond = DdsSettings {
        domain_id: 102,
        ..DdsSettings::default()
    };
    let started = skein_sim_dds::start(calm(1), &beyond);
    assert!(matches!(started, Err(StartError::Open(OpenError::Domain(102)))));
    let nobody = skein_sim::Simulation::start(calm(1));
    assert!(matches!(nobody, Err(skein_sim::SimError::NoCarrier(1))), "{nobody:?}");
    let carrier = DdsCarrier::open(&rig::fresh_domain()).unwrap();
    let simulation = skein_sim::Simulation::start_with(calm(2), Some(Arc::new(carrier))).unwrap();
    assert_eq!(simulation.system_ids(), [1, 2]);
    assert!(simulation.ports().is_empty(), "no port is bound");
    simulation.stop();
}
