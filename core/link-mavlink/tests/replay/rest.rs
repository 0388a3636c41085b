//! A real PX4 that stands, and the simulated one beside it: what the link makes of the one, and whether the other is like it.

use crate::log;
use crate::replay::fly;
use mavlink::dialects::common::{
    ATTITUDE_DATA, AUTOPILOT_VERSION_DATA, BATTERY_STATUS_DATA, COMMAND_LONG_DATA, ESTIMATOR_STATUS_DATA, MavCmd,
};
use mavlink::{MAVLinkV2MessageRaw, MavHeader, MavlinkVersion, MessageData};
use nalgebra::Vector3;
use skein_domain::{EstimatorHealth, PositionNed};
use skein_link_mavlink::EndpointCounters;
use skein_link_mavlink::frame::each_in_datagram;
use skein_sim::vehicle::{LinkKind, Outbox, SimVehicle, VehicleIdentity};
use skein_sim::{Airframe, SimSettings};

/// Both are at rest for this long, in seconds.
const REST_S: f64 = 47.0;
const STEP_S: f64 = 0.004;
/// `CONST_POS_MODE`.
const AT_REST: u16 = 128;

/// What a vehicle told while it stood.
#[derive(Default)]
struct Told {
    /// Flags of `ESTIMATOR_STATUS`, one after the other, without repetition.
    flags: Vec<u16>,
    uid: Option<u64>,
    /// Charge in per cent: lowest and highest.
    charge: Option<(i8, i8)>,
}

impl Told {
    fn hear(&mut self, message_id: u32, payload: &[u8]) {
        match message_id {
            ESTIMATOR_STATUS_DATA::ID => {
                let flags = ESTIMATOR_STATUS_DATA::deser(MavlinkVersion::V2, payload)
                    .unwrap()
                    .flags
                    .bits();
                if self.flags.last() != Some(&flags) {
                    self.flags.push(flags);
                }
            }
            AUTOPILOT_VERSION_DATA::ID => {
                self.uid = Some(AUTOPILOT_VERSION_DATA::deser(MavlinkVersion::V2, payload).unwrap().uid);
            }
            BATTERY_STATUS_DATA::ID => {
                let now = BATTERY_STATUS_DATA::deser(MavlinkVersion::V2, payload)
                    .unwrap()
                    .battery_remaining;
                let (low, high) = self.charge.unwrap_or((now, now));
                self.charge = Some((low.min(now), high.max(now)));
            }
            _ => {}
        }
    }

    fn of_the_recording() -> Self {
        let mut told = Self::default();
        for frame in log::read("rest-system-1").iter().filter(|frame| frame.system_id() == 1) {
            told.hear(frame.message_id(), frame.payload());
        }
        told
    }

    fn of_the_simulation() -> Self {
        let identity = VehicleIdentity {
            system_id: 1,
            position: PositionNed::new(0.0, 0.0, 0.0),
            yaw_rad: 0.0,
            number: 0,
            ground_link: false,
            started_s: 0.0,
            airframe: Airframe::Sih,
            battery: None,
            utc_at_zero_us: 0,
        };
        let mut vehicle = SimVehicle::new(identity, &SimSettings::default().as_software_in_the_loop());
        let (mut told, mut out) = (Self::default(), Outbox::default());
        for step in 0..(REST_S / STEP_S) as u32 {
            if step == 2_500 {
                vehicle.receive(LinkKind::Onboard, &ask_for_version(), &mut out);
            }
            vehicle.step(STEP_S, &Vector3::zeros(), &mut out);
            for (_, bytes) in out.frames() {
                each_in_datagram(bytes, &mut EndpointCounters::default(), |_, got| {
                    told.hear(got.header.message_id, got.payload);
                });
            }
            out.clear();
        }
        told
    }
}

/// `REQUEST_MESSAGE` for `AUTOPILOT_VERSION`, as one frame.
fn ask_for_version() -> Vec<u8> {
    let ask = COMMAND_LONG_DATA {
        target_system: 1,
        target_component: 1,
        command: MavCmd::MAV_CMD_REQUEST_MESSAGE,
        param1: AUTOPILOT_VERSION_DATA::ID as f32,
        ..COMMAND_LONG_DATA::default()
    };
    let header = MavHeader {
        system_id: 245,
        component_id: 190,
        sequence: 0,
    };
    let mut raw = MAVLinkV2MessageRaw::new();
    raw.serialize_message_data(header, &ask);
    raw.raw_bytes().to_vec()
}

#[test]
fn the_link_takes_a_vehicle_that_stands_for_one_that_knows_where_it_is() {
    let flight = fly("rest-system-1", 1, &[], &[]);
    let (early, ..) = flight.at(2.5);
    assert!(
        early
            .estimator
            .is_none_or(|estimator| !estimator.is_position_good(false))
    );
    for second in [6.5, 20.0, 45.0] {
        let (telemetry, ..) = flight.at(second);
        let estimator: EstimatorHealth = telemetry.estimator.unwrap();
        assert!(estimator.flags & AT_REST != 0, "{estimator:?}");
        assert!(estimator.is_position_good(false), "{estimator:?}");
        // In the air the same flags say that it has lost its way.
        assert!(!estimator.is_position_good(true), "{estimator:?}");
        assert_eq!(telemetry.ready_to_arm, Some(true));
    }
    let (asked, ..) = flight.at(45.0);
    assert!(asked.simulated, "its uid has been told by then");
}

#[test]
fn the_simulated_vehicle_tells_the_same_while_it_stands() {
    let (real, simulated) = (Told::of_the_recording(), Told::of_the_simulation());
    assert_eq!(real.flags, [164, 229, 1023]);
    assert_eq!(simulated.flags, real.flags[1..], "flags of ESTIMATOR_STATUS");
    assert_eq!((simulated.uid, real.uid), (real.uid, Some(0x4954_414C_4449_4E4F)));
    let full = |told: &Told| told.charge.is_some_and(|(low, _)| low >= 99);
    assert!(
        full(&real) && full(&simulated),
        "{:?}, {:?}",
        real.charge,
        simulated.charge
    );
}

#[test]
fn the_time_of_both_goes_slower_than_ours() {
    let times: Vec<(f64, f64)> = log::read("rest-system-1")
        .iter()
        .filter(|frame| frame.system_id() == 1 && frame.message_id() == ATTITUDE_DATA::ID)
        .map(|frame| {
            let told = ATTITUDE_DATA::deser(MavlinkVersion::V2, frame.payload()).unwrap();
            (frame.time_s, f64::from(told.time_boot_ms) * 1e-3)
        })
        .collect();
    let (first, last) = (times.first().unwrap(), times.last().unwrap());
    let real = (last.1 - first.1) / (last.0 - first.0);
    let simulated = SimSettings::default().as_software_in_the_loop().pace;
    assert!(
        (real - simulated).abs() < 0.015,
        "{real} s per second, {simulated} simulated"
    );
}
