//! Two links of which each is heard or not, as the scene says.

use super::{HEARD_S, PairedLink, SILENT_AT_LEAST_S, SILENT_AT_MOST_S, STEADY_S};
use parking_lot::Mutex;
use proptest::prelude::*;
use skein_config::LinkKind;
use skein_domain::link::{LinkEvent, MessageTap, RoutePoint, VehicleLink};
use skein_domain::payload::MavlinkMessage;
use skein_domain::setpoint::LocalSetpoint;
use skein_domain::{
    AutopilotCommand, CommandId, FlightMode, Geodetic, LinkHealth, NodeTime, ParameterEvent, ParameterList,
    ParameterValue, ReadingAction, Refusal, RequestId, SystemId, Telemetry,
};
use std::sync::{Arc, Weak};

/// What a link of the scene was asked, and what it says.
#[derive(Default)]
struct Scene {
    last_heard: NodeTime,
    lost_after_s: f64,
    rate_hz: f32,
    mode: FlightMode,
    armed: bool,
    home: Option<Geodetic>,
    events: Vec<LinkEvent>,
    requests: Vec<(RequestId, AutopilotCommand)>,
    streamed: Vec<NodeTime>,
    stopped: usize,
    routes: usize,
    written: Vec<String>,
}

#[derive(Default)]
struct Scripted(Mutex<Scene>);

impl Scripted {
    fn new() -> Arc<Self> {
        let scene = Scene {
            lost_after_s: 1.5,
            rate_hz: 50.0,
            ..Scene::default()
        };
        Arc::new(Self(Mutex::new(scene)))
    }

    fn heard(&self, now: NodeTime) {
        self.0.lock().last_heard = now;
    }

    fn says(&self, event: LinkEvent) {
        self.0.lock().events.push(event);
    }
}

impl VehicleLink for Scripted {
    fn system_id(&self) -> SystemId {
        SystemId(7)
    }

    fn read(&self, now: NodeTime) -> (Telemetry, LinkHealth) {
        let scene = self.0.lock();
        let health = LinkHealth {
            connected: now.seconds_since(scene.last_heard) <= scene.lost_after_s,
            last_heard: scene.last_heard,
            receive_rate_hz: scene.rate_hz,
            ..LinkHealth::default()
        };
        let telemetry = Telemetry {
            mode: scene.mode,
            armed: scene.armed,
            home: scene.home,
            ..Telemetry::default()
        };
        (telemetry, health)
    }

    fn take_events(&self) -> Vec<LinkEvent> {
        std::mem::take(&mut self.0.lock().events)
    }

    fn request(&self, _: NodeTime, request: RequestId, command: AutopilotCommand) {
        self.0.lock().requests.push((request, command));
    }

    fn stop_motors(&self, now: NodeTime, request: RequestId) -> Result<(), Refusal> {
        self.request(now, request, AutopilotCommand::EmergencyStop);
        Ok(())
    }

    fn stream(&self, now: NodeTime, _: LocalSetpoint, _: NodeTime) {
        self.0.lock().streamed.push(now);
    }

    fn resume_stream(&self) {}

    fn stop_stream(&self, _: NodeTime) {
        self.0.lock().stopped += 1;
    }

    fn upload_route(&self, _: NodeTime, _: RequestId, _: &[RoutePoint]) {
        self.0.lock().routes += 1;
    }

    fn tap(&self, _: Weak<dyn MessageTap>) {}

    fn send_payload(&self, _: NodeTime, _: &MavlinkMessage) -> Result<(), Refusal> {
        Ok(())
    }

    fn parameters(&self, _: u64) -> Result<ParameterList, Refusal> {
        Ok(ParameterList::default())
    }

    fn read_parameters(&self, _: NodeTime, _: ReadingAction) -> Result<(), Refusal> {
        Ok(())
    }

    fn write_parameter(&self, _: NodeTime, _: CommandId, name: &str, _: ParameterValue) {
        self.0.lock().written.push(name.to_owned());
    }

    fn take_parameter_events(&self) -> Vec<ParameterEvent> {
        let written = std::mem::take(&mut self.0.lock().written);
        let event = |name| ParameterEvent {
            id: None,
            name,
            before: None,
            outcome: Ok(ParameterValue::Integer(1)),
        };
        written.into_iter().map(event).collect()
    }
}

const PERIOD_S: f64 = 0.02;

struct Flight {
    dds: Arc<Scripted>,
    mavlink: Arc<Scripted>,
    pair: PairedLink,
    now: NodeTime,
}

impl Flight {
    /// Both links are there and heard; DDS flies.
    fn begin() -> Self {
        let (dds, mavlink) = (Scripted::new(), Scripted::new());
        let pair = PairedLink::new([LinkKind::Dds, LinkKind::Mavlink], LinkKind::Dds, dds.clone());
        let now = NodeTime::from_seconds(100.0);
        dds.heard(now);
        assert!(pair.attach(now, LinkKind::Mavlink, mavlink.clone()));
        let mut flight = Self {
            dds,
            mavlink,
            pair,
            now,
        };
        flight.pass(1.0, true, true);
        flight.pair.take_events();
        flight
    }

    /// Flies on for so long; which of the links is heard meanwhile.
    fn pass(&mut self, seconds: f64, dds: bool, mavlink: bool) {
        let until = self.now.plus_seconds(seconds);
        while self.now < until {
            self.now = self.now.plus_seconds(PERIOD_S);
            if dds {
                self.dds.heard(self.now);
            }
            if mavlink {
                self.mavlink.heard(self.now);
            }
            self.pair.read(self.now);
            let expires = self.now.plus_seconds(0.1);
            self.pair.stream(self.now, LocalSetpoint::default(), expires);
        }
    }

    fn streamed(&self) -> Vec<(NodeTime, LinkKind)> {
        let of = |link: &Scripted, kind| link.0.lock().streamed.iter().map(|at| (*at, kind)).collect::<Vec<_>>();
        let mut all = of(&self.dds, LinkKind::Dds);
        all.extend(of(&self.mavlink, LinkKind::Mavlink));
        all.sort_unstable();
        all
    }
}

#[test]
fn the_launch_place_is_the_one_that_mavlink_tells_while_it_is_heard() {
    let place = |altitude_amsl_m| Geodetic {
        altitude_amsl_m,
        ..Geodetic::default()
    };
    let mut flight = Flight::begin();
    let home = |flight: &Flight| flight.pair.read(flight.now).0.home;
    flight.mavlink.0.lock().home = Some(place(7.0));
    assert_eq!(home(&flight), Some(place(7.0)), "over DDS nothing was heard of it");
    flight.dds.0.lock().home = Some(place(8.0));
    assert_eq!(home(&flight), Some(place(7.0)));
    flight.pass(3.0, true, false);
    assert_eq!(home(&flight), Some(place(8.0)));
}

fn changed(from: FlightMode, to: FlightMode, commanded: bool) -> LinkEvent {
    LinkEvent::ModeChanged { from, to, commanded }
}

#[test]
fn the_other_link_takes_over_before_px4_misses_a_setpoint_and_the_first_one_when_it_is_steady() {
    let mut flight = Flight::begin();
    flight.pass(2.0, false, true);
    assert_eq!(flight.pair.active(), LinkKind::Mavlink);
    assert_eq!(
        flight.dds.0.lock().stopped,
        1,
        "what still gets through holds no old place"
    );
    flight.pass(STEADY_S - 0.5, true, true);
    assert_eq!(flight.pair.active(), LinkKind::Mavlink, "not yet");
    flight.pass(1.0, true, true);
    assert_eq!(flight.pair.active(), LinkKind::Dds);
    let over = flight.streamed();
    let first = over.iter().find(|(_, kind)| *kind == LinkKind::Mavlink).unwrap().0;
    let last = over
        .iter()
        .rev()
        .find(|(at, kind)| *kind == LinkKind::Dds && *at < first);
    let silent_s = first.seconds_since(NodeTime::from_seconds(101.0));
    assert!(silent_s < SILENT_AT_LEAST_S + 3.0 * PERIOD_S, "{silent_s}");
    assert!(
        first.seconds_since(last.unwrap().0) <= 2.0 * PERIOD_S,
        "no period without one"
    );
}

#[test]
fn both_links_are_told_with_which_of_them_flies() {
    let ways = |flight: &Flight| {
        let ways = flight.pair.ways(flight.now);
        ways.into_iter()
            .map(|way| (way.name, way.flies, way.link.connected))
            .collect::<Vec<_>>()
    };
    let mut flight = Flight::begin();
    let (dds, mavlink) = ("DDS".to_owned(), "MAVLink".to_owned());
    assert_eq!(
        ways(&flight),
        [(dds.clone(), true, true), (mavlink.clone(), false, true)]
    );
    flight.dds.0.lock().lost_after_s = 1.0;
    flight.pass(2.0, false, true);
    assert_eq!(ways(&flight), [(dds, false, false), (mavlink, true, true)]);
}

#[test]
fn a_slow_link_is_waited_for_longer() {
    for (rate_hz, waited_s) in [(10.0, 4.0 / 10.0), (20.0, 4.0 / 20.0), (1.0, SILENT_AT_MOST_S)] {
        let mut flight = Flight::begin();
        flight.dds.0.lock().rate_hz = rate_hz;
        flight.pass(waited_s - PERIOD_S, false, true);
        assert_eq!(flight.pair.active(), LinkKind::Dds, "{rate_hz} Hz");
        flight.pass(3.0 * PERIOD_S, false, true);
        assert_eq!(flight.pair.active(), LinkKind::Mavlink, "{rate_hz} Hz");
    }
}

#[test]
fn a_pause_in_which_nothing_is_heard_changes_nothing() {
    let mut flight = Flight::begin();
    flight.pass(1.0, false, false);
    assert_eq!(flight.pair.active(), LinkKind::Dds);
    // after it the one is read a little before the other
    flight.pass(HEARD_S / 2.0, false, true);
    flight.pass(2.0, true, true);
    assert_eq!(flight.pair.active(), LinkKind::Dds);
    assert!(flight.mavlink.0.lock().streamed.is_empty());
}

#[test]
fn it_is_lost_when_neither_is_heard() {
    let mut flight = Flight::begin();
    flight.pass(3.0, false, true);
    let lost = |events: &[LinkEvent]| events.contains(&LinkEvent::Lost);
    assert!(!lost(&flight.pair.take_events()));
    flight.pass(2.0, false, false);
    assert!(lost(&flight.pair.take_events()));
    assert!(!flight.pair.read(flight.now).1.connected);
    flight.pass(0.2, true, false);
    assert!(flight.pair.take_events().contains(&LinkEvent::Regained));
    assert!(flight.pair.read(flight.now).1.connected);
    assert_eq!(flight.pair.active(), LinkKind::Dds);
}

#[test]
fn what_is_open_is_asked_again_over_the_other_link_and_answered_once() {
    let mut flight = Flight::begin();
    let request = RequestId(3);
    flight
        .pair
        .request(flight.now, request, AutopilotCommand::EnterOffboard);
    assert!(flight.mavlink.0.lock().requests.is_empty());
    flight.pass(1.0, false, true);
    let asked = flight.mavlink.0.lock().requests.clone();
    assert_eq!(asked, [(request, AutopilotCommand::EnterOffboard)]);
    let lost = Refusal::LinkLost {
        vehicle: skein_domain::VehicleId(7),
    };
    let result = |outcome| LinkEvent::Result { request, outcome };
    flight.dds.says(result(Err(lost.clone())));
    let is_result = |event: &LinkEvent| matches!(event, LinkEvent::Result { .. });
    assert!(
        !flight.pair.take_events().iter().any(is_result),
        "the other one may still say yes"
    );
    flight.mavlink.says(result(Ok(())));
    flight.dds.says(result(Ok(())));
    let told: Vec<_> = flight.pair.take_events().into_iter().filter(is_result).collect();
    assert_eq!(told, [result(Ok(()))]);
}

#[test]
fn the_emergency_stop_goes_over_both_and_is_refused_by_both_or_done() {
    let flight = Flight::begin();
    let request = RequestId(4);
    assert_eq!(flight.pair.stop_motors(flight.now, request), Ok(()));
    for link in [&flight.dds, &flight.mavlink] {
        assert_eq!(link.0.lock().requests, [(request, AutopilotCommand::EmergencyStop)]);
    }
    let refused = LinkEvent::Result {
        request,
        outcome: Err(Refusal::Superseded),
    };
    flight.mavlink.says(refused.clone());
    assert_eq!(flight.pair.take_events(), []);
    flight.dds.says(refused.clone());
    assert_eq!(flight.pair.take_events(), [refused]);
}

#[test]
fn only_the_link_that_flies_says_what_mode_it_is_and_what_was_missed_is_told_after_a_hand_over() {
    let mut flight = Flight::begin();
    let offboard = changed(FlightMode::Hold, FlightMode::Offboard, true);
    flight.dds.says(offboard.clone());
    flight
        .mavlink
        .says(changed(FlightMode::Hold, FlightMode::Offboard, false));
    assert_eq!(flight.pair.take_events(), [offboard]);
    // the pilot takes over while DDS is silent: what MAVLink told then counted for nothing
    flight
        .mavlink
        .says(changed(FlightMode::Offboard, FlightMode::Position, false));
    flight.mavlink.0.lock().mode = FlightMode::Position;
    flight.pass(0.1, false, true);
    flight.pair.take_events();
    flight.pass(2.5, false, true);
    let taken_over = changed(FlightMode::Offboard, FlightMode::Position, false);
    assert!(flight.pair.take_events().contains(&taken_over));
}

#[test]
fn whoever_was_disarmed_while_its_link_was_silent_is_told_to_be() {
    let mut flight = Flight::begin();
    flight.dds.says(LinkEvent::ArmedChanged { armed: true });
    flight.mavlink.0.lock().armed = true;
    flight.pair.take_events();
    flight.mavlink.says(LinkEvent::ArmedChanged { armed: false });
    flight.mavlink.0.lock().armed = false;
    flight.pass(0.1, false, true);
    flight.pair.take_events();
    flight.pass(2.5, false, true);
    let disarmed = LinkEvent::ArmedChanged { armed: false };
    assert!(flight.pair.take_events().contains(&disarmed));
}

#[test]
fn what_a_link_owed_that_another_one_replaces_is_refused() {
    let mut flight = Flight::begin();
    let request = RequestId(6);
    flight.pair.request(flight.now, request, AutopilotCommand::Land);
    flight.pass(3.0, false, false);
    flight.pair.take_events();
    let new = Scripted::new();
    new.heard(flight.now);
    assert!(flight.pair.attach(flight.now, LinkKind::Dds, new));
    let refused = |event: &LinkEvent| matches!(event, LinkEvent::Result { request: r, outcome: Err(Refusal::LinkLost { .. }) } if *r == request);
    assert!(flight.pair.take_events().iter().any(refused));
}

#[test]
fn a_restart_of_the_autopilot_is_told_once() {
    let flight = Flight::begin();
    flight.dds.says(LinkEvent::Rebooted);
    flight.mavlink.says(LinkEvent::Rebooted);
    assert_eq!(flight.pair.take_events(), [LinkEvent::Rebooted]);
}

#[test]
fn a_route_goes_over_mavlink_whichever_flies() {
    let flight = Flight::begin();
    let request = RequestId(5);
    flight.pair.upload_route(flight.now, request, &[]);
    assert_eq!((flight.dds.0.lock().routes, flight.mavlink.0.lock().routes), (0, 1));
    let outcome = LinkEvent::Result {
        request,
        outcome: Ok(()),
    };
    flight.mavlink.says(outcome.clone());
    assert_eq!(flight.pair.take_events(), [outcome]);
}

#[test]
fn another_one_with_the_same_system_id_is_not_taken_for_the_second_link() {
    let flight = Flight::begin();
    assert!(!flight.pair.attach(flight.now, LinkKind::Mavlink, Scripted::new()));
}

proptest! {
    /// However the links come and go: each period's setpoint goes over one of them, and none goes without one for as long as PX4 waits
    /// while one link is heard throughout.
    #[test]
    fn the_stream_goes_over_one_link_at_a_time_and_stays_on_one_that_is_heard(
        scene in prop::collection::vec((0.05_f64..3.0, any::<bool>()), 1..20),
    ) {
        let mut flight = Flight::begin();
        for (seconds, dds) in scene {
            // MAVLink is heard throughout
            flight.pass(seconds, dds, true);
        }
        let streamed = flight.streamed();
        for pair in streamed.windows(2) {
            let gap_s = pair[1].0.seconds_since(pair[0].0);
            prop_assert!(gap_s > PERIOD_S / 2.0, "two at a time");
            prop_assert!(gap_s < 1.5 * PERIOD_S, "{gap_s}");
        }
        // whatever was streamed over DDS was no more than that after it was last heard: the hand-over came in time
        let heard = flight.dds.0.lock().last_heard;
        let late = streamed.iter().filter(|(at, kind)| *kind == LinkKind::Dds && at.seconds_since(heard) > SILENT_AT_LEAST_S + 2.0 * PERIOD_S);
        prop_assert_eq!(late.count(), 0);
    }
}

#[test]
fn parameters_are_those_over_mavlink_whichever_link_flies() {
    let flight = Flight::begin();
    assert_eq!(flight.pair.active(), LinkKind::Dds);
    flight
        .pair
        .write_parameter(flight.now, CommandId(1), "A", ParameterValue::Integer(1));
    assert_eq!(flight.mavlink.0.lock().written, ["A"]);
    assert!(flight.dds.0.lock().written.is_empty());
    assert_eq!(flight.pair.take_parameter_events().len(), 1);
    assert!(flight.pair.take_parameter_events().is_empty());
}
