//! What the gate lets payloads send never flies a vehicle: whatever passes, a hovering vehicle hovers on as if nothing had come.
#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

use mavlink::Message;
use mavlink::dialects::common::MavMessage;
use nalgebra::Vector3;
use proptest::prelude::*;
use skein_domain::payload::{MavlinkMessage, PayloadKind};
use skein_domain::{FlightMode, PositionNed, SystemId};
use skein_safety::{Gate, Limits};
use skein_sim::vehicle::{LinkKind, Outbox, SimVehicle, VehicleIdentity};
use skein_sim::{NoiseSettings, PayloadPlan, SimSettings, VehicleTruth, WindSettings};

const STEP_S: f64 = 0.008;
const SYSTEM: u8 = 1;

fn frame(id: u32, payload: &[u8]) -> Vec<u8> {
    let [a, b, c, _] = id.to_le_bytes();
    let mut bytes = vec![0xFD, payload.len() as u8, 0, 0, 7, 245, 190, a, b, c];
    bytes.extend(payload);
    let crc = mavlink::calculate_crc(&bytes[1..], MavMessage::extra_crc(id));
    bytes.extend(crc.to_le_bytes());
    bytes
}

/// COMMAND_LONG, or with its last bytes COMMAND_INT.
fn command(number: u16, component: u8, param: [f32; 7]) -> Vec<u8> {
    let mut payload: Vec<u8> = param.iter().flat_map(|p| p.to_le_bytes()).collect();
    payload.extend(number.to_le_bytes());
    payload.extend([SYSTEM, component, 0]);
    payload
}

/// A vehicle in calm air that has taken off and holds its place.
struct Flight {
    vehicle: SimVehicle,
    out: Outbox,
}

impl Flight {
    fn begin() -> Self {
        let settings = SimSettings {
            wind: WindSettings::CALM,
            noise: NoiseSettings::NONE,
            payloads: PayloadPlan::all(),
            ..SimSettings::default()
        };
        let identity = VehicleIdentity {
            system_id: SYSTEM,
            position: PositionNed::default(),
            yaw_rad: 0.3,
            number: 0,
            ground_link: false,
            started_s: 0.0,
            airframe: skein_sim::Airframe::default(),
            battery: None,
            utc_at_zero_us: 0,
        };
        let mut flight = Self {
            vehicle: SimVehicle::new(identity, &settings),
            out: Outbox::default(),
        };
        flight.run(5.0);
        flight.send(76, &command(400, 1, [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]));
        flight.run(0.2);
        let nan = f32::NAN;
        flight.send(76, &command(22, 1, [0.0, 0.0, 0.0, nan, nan, nan, nan]));
        flight.run(12.0);
        // The gimbal's owner is whoever sends here: its commands are not merely ignored.
        flight.send(76, &command(1001, 1, [245.0, 190.0, 0.0, 0.0, 0.0, 0.0, 0.0]));
        flight.run(0.2);
        assert_eq!(flight.vehicle.truth().mode, FlightMode::Hold);
        flight
    }

    fn send(&mut self, id: u32, payload: &[u8]) {
        self.vehicle
            .receive(LinkKind::Onboard, &frame(id, payload), &mut self.out);
    }

    fn run(&mut self, seconds: f64) {
        for _ in 0..(seconds / STEP_S).round() as usize {
            self.vehicle.step(STEP_S, &Vector3::zeros(), &mut self.out);
            self.out.clear();
        }
    }

    /// What there is to see of the flight, without the payloads.
    fn end(mut self) -> VehicleTruth {
        self.run(1.0);
        VehicleTruth {
            gimbal: None,
            camera: None,
            radio: None,
            ..self.vehicle.truth()
        }
    }
}

fn gate() -> Gate {
    let limits = Limits {
        max_speed_m_s: 10.0,
        max_climb_m_s: 3.0,
        max_descent_m_s: 2.0,
        min_separation_m: 2.0,
        separation_horizon_s: 0.8,
    };
    Gate::new(limits, None)
}

fn number() -> impl Strategy<Value = f32> {
    prop_oneof![
        any::<f32>(),
        Just(0.0),
        Just(1.0),
        Just(f32::NAN),
        -180_f32..180.0,
        prop::sample::select(vec![32.0, 33.0, 259.0, 262.0, 280.0, 285.0, 20_000.0]),
    ]
}

fn sent() -> impl Strategy<Value = (u32, Vec<u8>)> {
    let numbers = prop_oneof![
        any::<u16>(),
        prop::sample::select(vec![
            16_u16, 20, 21, 22, 176, 178, 179, 192, 195, 196, 197, 198, 246, 300, 400, 511, 512, 521, 525, 526, 530,
            531, 1000, 1001, 2000, 2001, 2003, 2500, 2501, 2502
        ]),
    ];
    let components = prop::sample::select(vec![0_u8, 1, 100, 154]);
    let commands = (
        prop::sample::select(vec![75_u32, 76]),
        numbers,
        components,
        prop::array::uniform7(number()),
    )
        .prop_map(|(id, number, component, param)| (id, command(number, component, param)));
    let messages = (
        prop::sample::select(vec![
            282_u32, 284, 287, 288, 320, 321, 323, 11, 23, 44, 70, 81, 82, 84, 86,
        ]),
        prop::collection::vec(prop_oneof![any::<u8>(), Just(SYSTEM)], 0..60),
    );
    prop_oneof![commands, messages]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, ..ProptestConfig::default() })]

    #[test]
    fn what_payloads_may_send_never_flies_a_vehicle(messages in prop::collection::vec(sent(), 1..40)) {
        let (gate, mut disturbed, mut alone) = (gate(), Flight::begin(), Flight::begin());
        for (id, payload) in messages {
            let message = MavlinkMessage { message_id: id, payload, ..MavlinkMessage::default() };
            let kinds = [PayloadKind::Gimbal, PayloadKind::Camera, PayloadKind::Radio, PayloadKind::Detector];
            if kinds.iter().any(|kind| gate.payload_message(*kind, SystemId(SYSTEM), &message).is_ok()) {
                disturbed.send(id, &message.payload);
                disturbed.run(0.1);
                alone.run(0.1);
            }
        }
        prop_assert_eq!(disturbed.end(), alone.end());
    }
}

#[test]
fn a_flight_that_is_disturbed_is_told_from_one_that_is_not() {
    let (mut disturbed, alone) = (Flight::begin(), Flight::begin());
    disturbed.send(76, &command(21, 1, [0.0; 7]));
    assert_ne!(disturbed.end(), alone.end(), "the comparison sees a landing");
}
