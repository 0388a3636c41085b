//! One link of a vehicle as PX4 keeps it: which messages go out how often, sequence numbers, and whether a ground station
//! listens.

use crate::topics::Published;
use crate::wire::{self, Sender};
use mavlink::{MavHeader, MessageData};
use skein_sim_payloads::{RADIO_COMPONENT, RADIO_SYSTEM};

/// The two links of a vehicle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum LinkKind {
    /// To a companion computer.
    Onboard,
    /// To ground stations.
    GroundStation,
}

/// Frames a vehicle wants to send, each for one of its links, and what it publishes. Reused from step to step.
#[derive(Debug, Default)]
pub struct Outbox {
    bytes: Vec<u8>,
    marks: Vec<(LinkKind, usize)>,
    pub(super) published: Vec<Published>,
}

impl Outbox {
    /// The frames in the order they are to be sent.
    pub fn frames(&self) -> impl Iterator<Item = (LinkKind, &[u8])> {
        let mut start = 0;
        self.marks.iter().map(move |(link, end)| {
            let frame = self.bytes.get(start..*end).unwrap_or_default();
            start = *end;
            (*link, frame)
        })
    }

    /// What is published, in order.
    #[must_use]
    pub fn published(&self) -> &[Published] {
        &self.published
    }

    /// How many frames there are to send now.
    pub(crate) fn mark(&self) -> usize {
        self.marks.len()
    }

    /// Forgets all frames since a mark.
    pub(crate) fn back_to(&mut self, mark: usize) {
        self.marks.truncate(mark);
        self.bytes.truncate(self.marks.last().map_or(0, |(_, end)| *end));
    }

    /// Whether there is nothing to send or to publish.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.marks.is_empty() && self.published.is_empty()
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        self.bytes.clear();
        self.marks.clear();
        self.published.clear();
    }
}

/// A message of one component.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Stream {
    /// Component id.
    pub component: u8,
    /// Message id.
    pub message_id: u32,
}

impl Stream {
    /// One of the autopilot's.
    pub(crate) fn of_autopilot(message_id: u32) -> Self {
        Self {
            component: AUTOPILOT_COMPONENT,
            message_id,
        }
    }
}

/// One message sent at a rate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Schedule {
    stream: Stream,
    default_us: u64,
    /// 0 = off.
    interval_us: u64,
    due_us: u64,
}

/// Message, default rate on the onboard link, default rate on the ground-station link, in hertz; 0 = only when asked for.
const STREAMS: &[(u32, f64, f64)] = &[
    (0, 1.0, 1.0),
    (1, 5.0, 1.0),
    (2, 1.0, 0.0),
    (24, 8.0, 5.0),
    (30, 100.0, 50.0),
    (31, 50.0, 50.0),
    (32, 30.0, 50.0),
    (33, 50.0, 50.0),
    (36, 10.0, 50.0),
    (42, 1.0, 1.0),
    (49, 0.0, 0.0),
    (74, 10.0, 4.0),
    (83, 10.0, 50.0),
    (85, 10.0, 50.0),
    (105, 50.0, 0.0),
    (111, 10.0, 0.0),
    (124, 1.0, 1.0),
    (141, 10.0, 1.0),
    (147, 0.5, 0.5),
    (148, 0.0, 0.0),
    (230, 1.0, 0.5),
    (231, 0.0, 0.0),
    (241, 0.5, 0.1),
    (242, 0.5, 0.5),
    (245, 5.0, 1.0),
    (331, 30.0, 0.0),
];
/// PX4's links do not run faster than their own loop, in microseconds.
const SHORTEST_INTERVAL_US: u64 = 4_000;
/// An interval fits the autopilot's own number of 32 bits, in microseconds.
const LONGEST_INTERVAL_US: u64 = i32::MAX as u64;
/// A ground station counts as listening this long after its last heartbeat, in seconds.
const GROUND_STATION_TIMEOUT_S: f64 = 2.5;

/// One link.
#[derive(Debug, Clone)]
pub(crate) struct Channel {
    pub kind: LinkKind,
    system_id: u8,
    /// Each component counts for itself, as behind an autopilot that passes on what its payloads say.
    sequences: [u8; 256],
    streams: Vec<Schedule>,
    next_due_us: u64,
    ground_station_s: Option<f64>,
    text_id: u16,
    /// Next parameter of a list being sent.
    pub list_next: Option<usize>,
    /// What of a log is sent.
    pub log: super::logs::Sending,
}

impl Channel {
    /// With the default rates, and those of the payloads (component, message, rate); `phase` in 0..1 spreads the vehicles'
    /// messages over time.
    pub(crate) fn new(kind: LinkKind, system_id: u8, phase: f64, now_us: u64, of_payloads: &[(u8, u32, f64)]) -> Self {
        let streams = STREAMS
            .iter()
            .map(|(message_id, onboard, ground)| {
                let rate_hz = if kind == LinkKind::Onboard { *onboard } else { *ground };
                (AUTOPILOT_COMPONENT, *message_id, rate_hz)
            })
            .chain(of_payloads.iter().copied())
            .enumerate()
            .map(|(i, (component, message_id, rate_hz))| {
                let default_us = if rate_hz > 0.0 { (1e6 / rate_hz) as u64 } else { 0 };
                let share = (phase + i as f64 * 0.618_034).fract();
                // Nothing rarer than once a second is first seen later than that.
                let due_us = now_us + (share * default_us.min(1_000_000) as f64) as u64;
                Schedule {
                    stream: Stream { component, message_id },
                    default_us,
                    interval_us: default_us,
                    due_us,
                }
            })
            .collect();
        Self {
            kind,
            system_id,
            sequences: [0; 256],
            streams,
            next_due_us: 0,
            ground_station_s: None,
            text_id: 0,
            list_next: None,
            log: super::logs::Sending::default(),
        }
    }

    /// Calls `send` for every message that is due.
    pub(crate) fn due(&mut self, now_us: u64, mut send: impl FnMut(&mut Self, Stream)) {
        if now_us < self.next_due_us {
            return;
        }
        let mut next = u64::MAX;
        for index in 0..self.streams.len() {
            let Some(stream) = self.streams.get_mut(index) else {
                break;
            };
            if stream.interval_us == 0 {
                continue;
            }
            let which = stream.stream;
            let due = now_us >= stream.due_us;
            if due {
                stream.due_us += stream.interval_us;
                if stream.due_us <= now_us {
                    // Fell behind by more than one: do not make up for it.
                    stream.due_us = now_us + stream.interval_us;
                }
            }
            next = next.min(stream.due_us);
            if due {
                send(self, which);
            }
        }
        self.next_due_us = next;
    }

    /// SET_MESSAGE_INTERVAL: microseconds, 0 = default, negative = off. False for a message it does not have.
    pub(crate) fn set_interval(&mut self, which: Stream, interval_us: f64, now_us: u64) -> bool {
        let Some(stream) = self.streams.iter_mut().find(|s| s.stream == which) else {
            return false;
        };
        stream.interval_us = if interval_us < 0.0 {
            0
        } else if interval_us == 0.0 {
            stream.default_us
        } else {
            (interval_us as u64).clamp(SHORTEST_INTERVAL_US, LONGEST_INTERVAL_US)
        };
        stream.due_us = stream.due_us.min(now_us + stream.interval_us);
        self.next_due_us = 0;
        true
    }

    /// The interval of a message in microseconds, -1 = off; `None` if it does not have it.
    pub(crate) fn interval_us(&self, which: Stream) -> Option<i32> {
        let stream = self.streams.iter().find(|s| s.stream == which)?;
        Some(if stream.interval_us == 0 {
            -1
        } else {
            i32::try_from(stream.interval_us).unwrap_or(i32::MAX)
        })
    }

    /// A heartbeat of a ground station came.
    pub(crate) fn heard_ground_station(&mut self, now_s: f64) {
        self.ground_station_s = Some(now_s);
    }

    /// Whether texts are sent on this link.
    pub(crate) fn has_ground_station(&self, now_s: f64) -> bool {
        self.ground_station_s
            .is_some_and(|heard| now_s - heard < GROUND_STATION_TIMEOUT_S)
    }

    /// The number of the next text.
    pub(crate) fn next_text_id(&mut self) -> u16 {
        let id = self.text_id;
        self.text_id = self.text_id.wrapping_add(1);
        id
    }

    /// Writes one message of the autopilot.
    pub(crate) fn send<M: MessageData>(&mut self, out: &mut Outbox, message: &M) {
        self.send_as(AUTOPILOT_COMPONENT, out, message);
    }

    /// Writes one message of a component.
    pub(crate) fn send_as<M: MessageData>(&mut self, component: u8, out: &mut Outbox, message: &M) {
        self.write((self.system_id, component), out, message);
    }

    /// Writes one message of the radio, which speaks for itself.
    pub(crate) fn send_as_radio<M: MessageData>(&mut self, out: &mut Outbox, message: &M) {
        self.write((RADIO_SYSTEM, RADIO_COMPONENT), out, message);
    }

    fn write<M: MessageData>(&mut self, (system_id, component_id): (u8, u8), out: &mut Outbox, message: &M) {
        let mut header = MavHeader {
            system_id: u32::from(system_id),
            component_id,
            sequence: 0,
        };
        if let Some(sequence) = self.sequences.get_mut(usize::from(component_id)) {
            header.sequence = *sequence;
            *sequence = sequence.wrapping_add(1);
        }
        wire::write_frame(&mut out.bytes, header, message);
        out.marks.push((self.kind, out.bytes.len()));
    }

    /// Writes a component's acknowledgement.
    pub(crate) fn acknowledge(&mut self, component: u8, out: &mut Outbox, command: u16, result: u8, to: Sender) {
        self.send_as(component, out, &wire::Acknowledgement { command, result, to });
    }
}

/// Component id of an autopilot.
pub(crate) const AUTOPILOT_COMPONENT: u8 = 1;
