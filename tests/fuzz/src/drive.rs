//! Plays any bytes as the life of one link: messages, noise, requests, setpoints, time. Panics if the link does what it must
//! never do.

use mavlink::MavlinkVersion;
use skein_domain::link::StreamState;
use skein_domain::setpoint::LocalSetpoint;
use skein_domain::{
    AutopilotCommand, FlightMode, LocalPositionNed, NodeTime, ParameterValue, ReadingAction, RequestId, VelocityNed,
};
use skein_link_mavlink::EndpointCounters;
use skein_link_mavlink::decode::{Heartbeat, decode};
use skein_link_mavlink::frame::{Frame, FrameHeader, StreamBuffer, each_in_datagram};
use skein_link_mavlink::vehicle::VehicleCore;
use skein_px4::LinkSettings;
use std::sync::Arc;

/// Messages that a link reads, and some that it does not.
const MESSAGES: [u32; 20] = [
    0, 1, 22, 24, 30, 32, 33, 49, 77, 111, 147, 148, 242, 245, 253, 345, 4, 105, 12_901, 99_999,
];

struct Input<'a>(&'a [u8]);

impl<'a> Input<'a> {
    fn byte(&mut self) -> Option<u8> {
        let (first, rest) = self.0.split_first()?;
        self.0 = rest;
        Some(*first)
    }

    fn bytes(&mut self, len: usize) -> &'a [u8] {
        let (taken, rest) = self.0.split_at(len.min(self.0.len()));
        self.0 = rest;
        taken
    }

    fn number(&mut self) -> f64 {
        let mut bytes = [0; 4];
        let taken = self.bytes(4);
        bytes[..taken.len()].copy_from_slice(taken);
        f64::from(f32::from_le_bytes(bytes))
    }
}

/// Plays the bytes.
pub fn drive(data: &[u8]) {
    let mut input = Input(data);
    let first = Heartbeat {
        custom_mode: 3 << 24 | 4 << 16,
        vehicle_type: 2,
        autopilot: 12,
        base_mode: 0,
        system_status: 3,
    };
    let mut now = NodeTime::from_seconds(10.0);
    let mut core = VehicleCore::new(Arc::new(LinkSettings::default()), 1, &first, now);
    let mut stream = StreamBuffer::default();
    let mut requests = 0;
    while let Some(op) = input.byte() {
        now = now.plus_seconds(f64::from(op >> 3) * 0.01);
        match op & 7 {
            0..=2 => message(&mut core, now, &mut input),
            3 => {
                let len = usize::from(input.byte().unwrap_or(0));
                noise(&mut core, now, input.bytes(len), &mut stream);
            }
            4 => {
                requests += 1;
                core.request(now, RequestId(requests), command(&mut input));
            }
            5 => offer(&mut core, now, &mut input),
            6 => {
                let due = core.on_tick(now);
                assert!(due.seconds_since(now) <= 1.0, "the next tick is too far");
            }
            _ => service(&mut core, now, &mut input),
        }
        check(&mut core, now);
    }
}

fn message(core: &mut VehicleCore, now: NodeTime, input: &mut Input<'_>) {
    let which = usize::from(input.byte().unwrap_or(0));
    let (flags, sequence) = (input.byte().unwrap_or(0), input.byte().unwrap_or(0));
    let len = usize::from(input.byte().unwrap_or(0));
    let header = FrameHeader {
        version: if flags & 1 == 0 {
            MavlinkVersion::V2
        } else {
            MavlinkVersion::V1
        },
        system_id: 1,
        component_id: if flags & 0xE0 == 0xE0 { flags } else { 1 },
        sequence,
        message_id: MESSAGES[which % MESSAGES.len()],
    };
    let frame = Frame {
        header,
        payload: input.bytes(len),
        known: true,
    };
    core.on_frame(now, &header, decode(&frame).and_then(Result::ok));
}

fn noise(core: &mut VehicleCore, now: NodeTime, bytes: &[u8], stream: &mut StreamBuffer) {
    let mut counters = EndpointCounters::default();
    let mut take = |_: &mut EndpointCounters, frame: &Frame<'_>| {
        core.on_frame(now, &frame.header, decode(frame).and_then(Result::ok));
    };
    each_in_datagram(bytes, &mut counters, &mut take);
    let space = stream.space();
    assert!(space.len() >= bytes.len(), "a stream's buffer is never full");
    space[..bytes.len()].copy_from_slice(bytes);
    stream.advance(bytes.len(), &mut counters, take);
}

fn command(input: &mut Input<'_>) -> AutopilotCommand {
    match input.byte().unwrap_or(0) % 8 {
        0 => AutopilotCommand::Arm,
        1 => AutopilotCommand::Disarm,
        2 => AutopilotCommand::TakeOff {
            height_m: input.number(),
        },
        3 => AutopilotCommand::Land,
        4 => AutopilotCommand::ReturnToLaunch,
        5 => AutopilotCommand::EnterOffboard,
        _ => {
            let which = usize::from(input.byte().unwrap_or(0));
            AutopilotCommand::SetMode {
                mode: FlightMode::ALL[which % FlightMode::ALL.len()],
            }
        }
    }
}

fn offer(core: &mut VehicleCore, now: NodeTime, input: &mut Input<'_>) {
    let parts = input.byte().unwrap_or(0);
    let valid_s = f64::from(input.byte().unwrap_or(0)) * 0.01;
    let mut triple = || (input.number(), input.number(), input.number());
    let setpoint = LocalSetpoint {
        position: (parts & 1 != 0)
            .then(&mut triple)
            .map(|(n, e, d)| LocalPositionNed::new(n, e, d)),
        velocity: (parts & 2 != 0)
            .then(&mut triple)
            .map(|(n, e, d)| VelocityNed::new(n, e, d)),
        acceleration: None,
        yaw_rad: (parts & 4 != 0).then(|| triple().0),
        yaw_rate_rad_s: None,
    };
    core.stream(now, setpoint, now.plus_seconds(valid_s));
}

fn service(core: &mut VehicleCore, now: NodeTime, input: &mut Input<'_>) {
    match input.byte().unwrap_or(0) % 9 {
        0 => core.stop_stream(now),
        1 => core.set_duplicate(now, true),
        2 => core.set_duplicate(now, false),
        3 => drop(core.parameters().take_events()),
        8 => {
            let actions = [ReadingAction::Begin, ReadingAction::Anew, ReadingAction::Stop];
            // Refused while the link is lost.
            let _ = core.read_parameters(now, actions[usize::from(input.byte().unwrap_or(0)) % 3]);
            assert!(core.parameters().list(0).parameters.len() <= 4_096);
        }
        which => {
            let name = ["MPC_XY_VEL_MAX", "COM_OBL_RC_ACT", "x", ""][usize::from(which) % 4];
            let value = match which {
                4 => None,
                5 => Some(ParameterValue::Integer(input.number() as i32)),
                _ => Some(ParameterValue::Real(input.number() as f32)),
            };
            // Refusals are part of it.
            let _ = core.parameter(now, name, value);
        }
    }
}

/// What must hold after everything.
fn check(core: &mut VehicleCore, now: NodeTime) {
    let active = matches!(core.stream_state(), StreamState::Fresh | StreamState::HoldingExpired);
    let mut counters = EndpointCounters::default();
    let mut sent = 0;
    core.outbox().drain(|bytes| {
        sent += 1;
        each_in_datagram(bytes, &mut counters, |_, frame| {
            assert!(frame.known && frame.header.system_id == 245 && frame.header.component_id == 190);
            if frame.header.message_id == 84 {
                assert!(active, "a setpoint left a stream that is stopped");
            }
        });
    });
    assert_eq!((counters.frames_in, counters.stray_bytes), (sent, 0));
    let (telemetry, health) = core.read(now);
    assert!((0.0..=1.0).contains(&health.loss) && health.receive_rate_hz.is_finite());
    assert!(telemetry.local.is_none_or(|local| local.is_finite()));
    assert!(telemetry.velocity.is_none_or(|velocity| velocity.is_finite()));
    assert!(telemetry.global.is_none_or(|place| place.is_valid()));
    assert!(telemetry.local_frame.is_none_or(|frame| frame.origin.is_valid()));
    assert!(telemetry.position_time <= now);
    if now.0.is_multiple_of(7) {
        drop(core.take_events());
    }
}
