//! One system id from two places, in simulated time.

use super::*;
use crate::frame::each_in_datagram;
use crate::metrics::EndpointCounters;
use mavlink::dialects::common::{HEARTBEAT_DATA, MavAutopilot, MavModeFlag, MavState, MavType};
use mavlink::{MAVLinkV2MessageRaw, MavHeader};

const ID: u8 = 7;
const STEP_S: f64 = 0.02;
const CLEAR_S: f64 = 3.0;

/// One endpoint, on which a vehicle is heard from port 1.
struct Scene {
    table: LinkTable,
    slot: Slot,
    link: Arc<Px4Link>,
    armed: bool,
    now: NodeTime,
    events: Vec<EndpointEvent>,
}

fn port(port: u16) -> Option<SocketAddr> {
    Some(SocketAddr::from(([127, 0, 0, 1], port)))
}

impl Scene {
    fn new(armed: bool) -> Self {
        let (table, now) = (LinkTable::new(), NodeTime::from_seconds(10.0));
        let slot = table.slot("px4");
        let first = Heartbeat {
            autopilot: 12,
            vehicle_type: 2,
            ..Heartbeat::default()
        };
        let settings = Arc::new(LinkSettings::default());
        let (link, _) = table.discover(now, ID, &first, &slot, port(1), &settings);
        let mut scene = Self {
            table,
            slot,
            link,
            armed,
            now,
            events: Vec::new(),
        };
        scene.run(1.0, &[1]);
        scene
    }

    /// A heartbeat from that port.
    fn heard(&mut self, from: u16) {
        let mut raw = MAVLinkV2MessageRaw::new();
        let header = MavHeader {
            system_id: u32::from(ID),
            component_id: 1,
            sequence: 0,
        };
        let armed = MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED;
        let message = HEARTBEAT_DATA {
            custom_mode: 3 << 24 | 4 << 16,
            mavtype: MavType::MAV_TYPE_QUADROTOR,
            autopilot: MavAutopilot::MAV_AUTOPILOT_PX4,
            base_mode: if self.armed { armed } else { MavModeFlag::empty() },
            system_status: MavState::MAV_STATE_ACTIVE,
            mavlink_version: 3,
        };
        raw.serialize_message_data(header, &message);
        let (table, slot, link, now) = (&self.table, &self.slot, &self.link, self.now);
        let mut event = None;
        each_in_datagram(raw.raw_bytes(), &mut EndpointCounters::default(), |_, frame| {
            if link.receive(now, slot.number, port(from), frame) == crate::link::Received::Foreign {
                event = table.on_foreign(now, ID, slot, port(from), CLEAR_S);
            }
        });
        self.events.extend(event);
    }

    fn tick(&mut self) {
        if let Some(ticked) = self.link.tick(self.now, self.slot.number) {
            let event = self.table.on_ticked(self.now, &self.link, ID, &ticked, CLEAR_S);
            self.events.extend(event);
        }
    }

    /// For so long these are heard.
    fn run(&mut self, for_s: f64, from: &[u16]) {
        for _ in 0..(for_s / STEP_S).round() as usize {
            self.now = self.now.plus_seconds(STEP_S);
            from.iter().for_each(|port| self.heard(*port));
            self.tick();
        }
    }

    fn is_at(&self, at: u16) -> bool {
        self.link.source().address == port(at)
    }

    fn told(&mut self) -> Vec<&'static str> {
        let word = |event: &EndpointEvent| match event {
            EndpointEvent::Duplicate { .. } => "duplicate",
            EndpointEvent::DuplicateCleared { .. } => "cleared",
            EndpointEvent::Moved { .. } => "moved",
            _ => "other",
        };
        self.events.drain(..).map(|event| word(&event)).collect()
    }
}

#[test]
fn a_vehicle_in_flight_is_never_left_for_one_that_spoke_beside_it() {
    let mut scene = Scene::new(true);
    scene.run(1.0, &[1, 2]);
    assert_eq!(scene.told(), ["duplicate"]);
    assert!(scene.is_at(1) && scene.link.is_contested());
    scene.run(20.0, &[2]);
    assert!(scene.is_at(1), "its silence is no reason");
    scene.run(1.0, &[1, 2]);
    scene.run(4.0, &[1]);
    assert_eq!(scene.told(), ["cleared"]);
    assert!(scene.is_at(1) && !scene.link.is_contested());
}

#[test]
fn on_the_ground_the_one_that_is_left_is_the_vehicle() {
    let mut scene = Scene::new(false);
    scene.run(1.0, &[1, 2]);
    scene.run(2.0, &[2]);
    assert!(scene.is_at(1));
    scene.run(2.0, &[2]);
    assert!(scene.is_at(2));
    assert_eq!(scene.told(), ["duplicate", "cleared"]);
}

#[test]
fn who_is_heard_at_the_old_place_again_has_not_moved() {
    let mut scene = Scene::new(true);
    scene.run(0.7, &[2]);
    assert!(scene.is_at(2), "a vehicle that changes its port is followed in flight");
    scene.run(1.0, &[1, 2]);
    assert!(scene.is_at(1), "whoever spoke into its pause does not keep it");
    assert_eq!(scene.told(), ["moved", "duplicate"]);
    scene.run(2.0, &[2]);
    assert!(scene.is_at(1));
}

#[test]
fn a_vehicle_that_moves_for_good_is_followed_each_time() {
    let mut scene = Scene::new(true);
    for at in [2, 3, 1, 2] {
        scene.run(2.0, &[at]);
        assert!(scene.is_at(at));
    }
    assert_eq!(scene.told(), ["moved"; 4]);
}

#[test]
fn what_lay_in_the_socket_while_this_node_stood_still_moves_nobody() {
    let mut scene = Scene::new(true);
    scene.now = scene.now.plus_seconds(2.0);
    for _ in 0..10 {
        scene.heard(2);
    }
    scene.heard(1);
    scene.run(1.0, &[1, 2]);
    assert!(scene.is_at(1));
    assert_eq!(scene.told(), ["duplicate"]);
}

#[test]
fn an_emergency_stop_says_when_nothing_takes_it() {
    let scene = Scene::new(true);
    // No socket is open here.
    let sent = scene.link.stop_motors_now(scene.now);
    assert!(matches!(sent, Err(skein_domain::Refusal::NotSent { .. })), "{sent:?}");
}

impl Px4Link {
    fn stop_motors_now(&self, now: NodeTime) -> Result<(), skein_domain::Refusal> {
        use skein_domain::link::VehicleLink;
        self.stop_motors(now, skein_domain::RequestId(1))
    }
}
