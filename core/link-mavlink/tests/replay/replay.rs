//! Drives a link core with a recording: what the vehicle sent goes in as frames; what the ground station sent then is asked of
//! the link, so that the recorded answers are answers to it.

use crate::log::{self, Recorded};
use mavlink::dialects::common::{COMMAND_LONG_DATA, MavCmd, SET_POSITION_TARGET_LOCAL_NED_DATA};
use mavlink::{MavlinkVersion, MessageData};
use skein_domain::link::{LinkEvent, StreamState};
use skein_domain::setpoint::LocalSetpoint;
use skein_domain::{
    AutopilotCommand, FlightMode, LinkHealth, LocalPositionNed, NodeTime, Refusal, RequestId, Telemetry,
};
use skein_link_mavlink::EndpointCounters;
use skein_link_mavlink::decode::{decode, heartbeat};
use skein_link_mavlink::frame::each_in_datagram;
use skein_link_mavlink::vehicle::VehicleCore;
use skein_px4::LinkSettings;
use std::sync::Arc;

/// The recorded ground station.
const GROUND: u8 = 255;

/// What a replay found.
pub struct Flight {
    /// Events with the second they came at.
    pub events: Vec<(f64, LinkEvent)>,
    /// Requests with the second they were made at.
    pub requests: Vec<(f64, AutopilotCommand)>,
    /// Frames the link sent: second, message id, payload.
    pub sent: Vec<(f64, u32, Vec<u8>)>,
    /// Telemetry and health once per second.
    pub samples: Vec<(f64, Telemetry, LinkHealth, bool)>,
    /// The link at the end.
    pub core: VehicleCore,
}

impl Flight {
    /// The outcome of the request made at `time_s`, and when it came.
    pub fn outcome(&self, time_s: f64) -> (f64, Result<(), Refusal>) {
        let number = self.requests.iter().position(|(t, _)| (t - time_s).abs() < 0.002);
        let number = number.unwrap_or_else(|| panic!("nothing was asked at {time_s}: {:?}", self.requests));
        let found = self.events.iter().find_map(|(t, event)| match event {
            LinkEvent::Result { request, outcome } if request.0 as usize == number => Some((*t, outcome.clone())),
            _ => None,
        });
        found.unwrap_or_else(|| panic!("no outcome of what was asked at {time_s}"))
    }

    pub fn modes(&self) -> Vec<(f64, FlightMode, FlightMode, bool)> {
        let mode = |(t, event): &(f64, LinkEvent)| match event {
            LinkEvent::ModeChanged { from, to, commanded } => Some(((t * 10.0).round() / 10.0, *from, *to, *commanded)),
            _ => None,
        };
        self.events.iter().filter_map(mode).collect()
    }

    pub fn texts(&self) -> Vec<&str> {
        let mut texts = Vec::new();
        for (_, event) in &self.events {
            if let LinkEvent::StatusText { text, .. } = event {
                texts.push(text.as_str());
            }
        }
        texts
    }

    pub fn stream(&self) -> Vec<(f64, StreamState)> {
        let state = |(t, event): &(f64, LinkEvent)| match event {
            LinkEvent::Stream(state) => Some(((t * 10.0).round() / 10.0, *state)),
            _ => None,
        };
        self.events.iter().filter_map(state).collect()
    }

    pub fn armed(&self) -> Vec<(f64, bool)> {
        let armed = |(t, event): &(f64, LinkEvent)| match event {
            LinkEvent::ArmedChanged { armed } => Some(((t * 10.0).round() / 10.0, *armed)),
            _ => None,
        };
        self.events.iter().filter_map(armed).collect()
    }

    /// Telemetry in a second.
    pub fn at(&self, second: f64) -> (Telemetry, LinkHealth, bool) {
        let sample = self.samples.iter().find(|(t, ..)| *t >= second).unwrap();
        (sample.1, sample.2, sample.3)
    }
}

/// Replays the frames of one system. Requests at the times in `skip`, and frames of messages in `without`, are left out.
pub fn fly(name: &str, system_id: u8, skip: &[f64], without: &[u32]) -> Flight {
    fly_with(name, system_id, skip, without, |_| Vec::new())
}

/// The same, with a datagram made of each frame before it.
pub fn fly_with(
    name: &str,
    system_id: u8,
    skip: &[f64],
    without: &[u32],
    mut noise: impl FnMut(&[u8]) -> Vec<u8>,
) -> Flight {
    let settings = Arc::new(LinkSettings {
        own_system_id: GROUND,
        ..LinkSettings::default()
    });
    let mut flight: Option<Flight> = None;
    let mut due = NodeTime::default();
    for frame in log::read(name) {
        let now = frame.now();
        if frame.system_id() == GROUND {
            if let Some(flight) = &mut flight {
                ask(flight, now, &frame, skip);
                due = now;
            }
            continue;
        }
        if frame.system_id() != system_id || without.contains(&frame.message_id()) {
            continue;
        }
        while let Some(flight) = flight.as_mut().filter(|_| due <= now) {
            let tick = due;
            due = flight.core.on_tick(tick).max(tick.plus_seconds(0.01));
            collect(flight, tick);
        }
        if let Some(flight) = &mut flight {
            each_in_datagram(&noise(&frame.bytes), &mut EndpointCounters::default(), |_, got| {
                flight.core.on_frame(now, &got.header, decode(got).and_then(Result::ok));
            });
        }
        each_in_datagram(&frame.bytes, &mut EndpointCounters::default(), |_, got| {
            if flight.is_none() {
                let Some(first) = heartbeat(got) else { return };
                let core = VehicleCore::new(Arc::clone(&settings), system_id, &first, now);
                let (events, requests, sent, samples) = Default::default();
                flight = Some(Flight {
                    events,
                    requests,
                    sent,
                    samples,
                    core,
                });
                due = now;
            }
            let Some(flight) = &mut flight else { return };
            let read = decode(got).map(|read| read.unwrap());
            flight.core.on_frame(now, &got.header, read);
            collect(flight, now);
        });
    }
    flight.unwrap()
}

fn seconds(now: NodeTime) -> f64 {
    now.as_seconds() - 100.0
}

fn collect(flight: &mut Flight, now: NodeTime) {
    let time_s = seconds(now);
    flight
        .events
        .extend(flight.core.take_events().into_iter().map(|event| (time_s, event)));
    let sent = &mut flight.sent;
    flight.core.outbox().drain(|bytes| {
        each_in_datagram(bytes, &mut EndpointCounters::default(), |_, got| {
            sent.push((time_s, got.header.message_id, got.payload.to_vec()));
        });
    });
    if flight.samples.last().is_none_or(|(last, ..)| time_s - last >= 0.5) {
        let (telemetry, health) = flight.core.read(now);
        flight
            .samples
            .push((time_s, telemetry, health, flight.core.in_failsafe()));
    }
}

/// What the recorded ground station sent, asked of the link.
fn ask(flight: &mut Flight, now: NodeTime, frame: &Recorded, skip: &[f64]) {
    match frame.message_id() {
        SET_POSITION_TARGET_LOCAL_NED_DATA::ID => {
            let data = SET_POSITION_TARGET_LOCAL_NED_DATA::deser(MavlinkVersion::V2, frame.payload()).unwrap();
            let position = LocalPositionNed::new(f64::from(data.x), f64::from(data.y), f64::from(data.z));
            let yaw_rad = Some(f64::from(data.yaw));
            let setpoint = LocalSetpoint {
                position: Some(position),
                yaw_rad,
                ..LocalSetpoint::default()
            };
            flight.core.stream(now, setpoint, now.plus_seconds(0.5));
        }
        11 => request(
            flight,
            now,
            AutopilotCommand::SetMode {
                mode: FlightMode::Position,
            },
            skip,
        ),
        COMMAND_LONG_DATA::ID => {
            let Ok(data) = COMMAND_LONG_DATA::deser(MavlinkVersion::V2, frame.payload()) else {
                return;
            };
            if data.target_component > 1 {
                return;
            }
            let command = match (data.command, data.param1 as u8, data.param2 as u8, data.param3 as u8) {
                (MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 1, ..) => AutopilotCommand::Arm,
                (MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, 0, ..) => AutopilotCommand::Disarm,
                (MavCmd::MAV_CMD_NAV_TAKEOFF, ..) => AutopilotCommand::TakeOff {
                    height_m: if data.param7.is_nan() { 2.5 } else { 5.0 },
                },
                (MavCmd::MAV_CMD_NAV_LAND, ..) => AutopilotCommand::Land,
                (MavCmd::MAV_CMD_DO_SET_MODE, _, 4, 3) => AutopilotCommand::SetMode { mode: FlightMode::Hold },
                (MavCmd::MAV_CMD_DO_SET_MODE, _, 4, 4) => AutopilotCommand::SetMode {
                    mode: FlightMode::Mission,
                },
                (MavCmd::MAV_CMD_DO_SET_MODE, _, 6, _) => AutopilotCommand::EnterOffboard,
                _ => return,
            };
            request(flight, now, command, skip);
        }
        _ => {}
    }
    collect(flight, now);
}

fn request(flight: &mut Flight, now: NodeTime, command: AutopilotCommand, skip: &[f64]) {
    if skip.iter().any(|t| (t - seconds(now)).abs() < 0.002) {
        return;
    }
    let number = RequestId(flight.requests.len() as u32);
    flight.requests.push((seconds(now), command));
    flight.core.request(now, number, command);
}
