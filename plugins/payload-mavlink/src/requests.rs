//! Commands to a component: one after the other, each asked again until it is acknowledged or patience ends.
//!
//! An acknowledgement names only the command, so that two of one kind under way at once could not be told apart.

use crate::{decode, send};
use mavlink::dialects::common::{COMMAND_ACK_DATA, COMMAND_LONG_DATA, MavResult};
use mavlink::{MavlinkVersion, MessageData};
use minicbor::{Decode, Encode};
use skein_domain::payload::MavlinkMessage;
use skein_domain::{NodeTime, Refusal};
use skein_plugin_sdk::Effects;
use std::collections::VecDeque;

/// How many commands may wait. More than a handful means that the device does not answer.
const QUEUE_LEN: usize = 16;
/// How many times the ordinary wait a command may take that the device says is in progress.
const PROGRESS_FACTOR: f64 = 10.0;

/// How long and how often a command is asked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Patience {
    /// How long an acknowledgement is waited for, in seconds, before the command is sent again.
    pub wait_s: f64,
    /// How often it is sent.
    pub attempts: u32,
}

impl Default for Patience {
    fn default() -> Self {
        // A telemetry radio takes up to 0.3 s there and back; three losses in a row are rare on a link that works.
        Self {
            wait_s: 0.7,
            attempts: 4,
        }
    }
}

/// How a command ended: its tag, and why it was not done.
pub type Outcome<T> = (T, Result<(), Refusal>);

/// Commands that wait for their acknowledgement. `T` says what each is for.
#[derive(Debug, Clone, PartialEq, Encode, Decode)]
pub struct Requests<T> {
    #[n(0)]
    queue: VecDeque<Request<T>>,
    /// What the device calls us, as its acknowledgements say.
    #[n(1)]
    own: Option<(u8, u8)>,
}

#[derive(Debug, Clone, PartialEq, Encode, Decode)]
struct Request<T> {
    #[n(0)]
    tag: T,
    /// A COMMAND_LONG.
    #[n(1)]
    #[cbor(with = "minicbor::bytes")]
    payload: Vec<u8>,
    #[n(2)]
    sent: u32,
    #[n(3)]
    last_sent: NodeTime,
    #[n(4)]
    first_sent: NodeTime,
    #[n(5)]
    in_progress: bool,
}

impl<T> Default for Requests<T> {
    fn default() -> Self {
        Self {
            queue: VecDeque::new(),
            own: None,
        }
    }
}

impl<T: Clone + PartialEq> Requests<T> {
    /// Puts a command behind those that wait. False if too many do. It is sent by [`Self::work`].
    pub fn ask(&mut self, tag: T, command: &COMMAND_LONG_DATA) -> bool {
        if self.queue.len() >= QUEUE_LEN {
            return false;
        }
        self.queue.push_back(Request {
            tag,
            payload: crate::encode(command),
            sent: 0,
            last_sent: NodeTime::default(),
            first_sent: NodeTime::default(),
            in_progress: false,
        });
        true
    }

    /// Whether a command with this tag waits or is under way.
    #[must_use]
    pub fn contains(&self, tag: &T) -> bool {
        self.queue.iter().any(|request| request.tag == *tag)
    }

    /// Forgets the commands with this tag. What was sent already may still happen.
    pub fn forget(&mut self, tag: &T) {
        self.queue.retain(|request| request.tag != *tag);
    }

    /// Our system and component id, once an acknowledgement named them.
    #[must_use]
    pub fn own(&self) -> Option<(u8, u8)> {
        self.own
    }

    /// Sends what is due; returns what was given up. To be called in every tick and after [`Self::ask`].
    #[must_use]
    pub fn work(&mut self, now: NodeTime, patience: Patience, effects: &mut Effects) -> Vec<Outcome<T>> {
        let mut given_up = Vec::new();
        while let Some(first) = self.queue.front_mut() {
            let wait_s = if first.in_progress {
                patience.wait_s * PROGRESS_FACTOR
            } else {
                patience.wait_s
            };
            if first.sent > 0 && now.seconds_since(first.last_sent) < wait_s {
                break;
            }
            let command = COMMAND_LONG_DATA::deser(MavlinkVersion::V2, &first.payload);
            if let Ok(command) = &command
                && first.sent < patience.attempts.max(1)
                && !first.in_progress
            {
                first.send(now, command.clone(), effects);
                break;
            }
            let after_s = now.seconds_since(first.first_sent);
            let refusal = Refusal::timed_out(command.map_or_else(|_| "a command".to_owned(), |c| name(&c)), after_s);
            given_up.extend(self.queue.pop_front().map(|request| (request.tag, Err(refusal))));
            // Perhaps it does answer, but calls us otherwise than before.
            self.own = None;
        }
        given_up
    }

    /// Takes an acknowledgement. `None` if it is none, answers somebody else, or says no more than that work goes on.
    #[must_use]
    pub fn heard(&mut self, now: NodeTime, message: &MavlinkMessage) -> Option<Outcome<T>> {
        let ack: COMMAND_ACK_DATA = decode(message)?;
        let first = self.queue.front_mut().filter(|request| request.sent > 0)?;
        let command = COMMAND_LONG_DATA::deser(MavlinkVersion::V2, &first.payload).ok()?;
        let from_target = command.target_component == 0 || command.target_component == message.component_id;
        if ack.command != command.command || !from_target {
            return None;
        }
        let named = (ack.target_system, ack.target_component);
        if named.0 != 0 {
            if self.own.is_some_and(|own| own != named) {
                return None;
            }
            self.own = Some(named);
        }
        if ack.result == MavResult::MAV_RESULT_IN_PROGRESS {
            first.in_progress = true;
            first.last_sent = now;
            return None;
        }
        let outcome = match ack.result {
            MavResult::MAV_RESULT_ACCEPTED => Ok(()),
            result => Err(refusal(result, &command)),
        };
        self.queue.pop_front().map(|request| (request.tag, outcome))
    }
}

impl<T> Request<T> {
    fn send(&mut self, now: NodeTime, mut command: COMMAND_LONG_DATA, effects: &mut Effects) {
        command.confirmation = u8::try_from(self.sent).unwrap_or(u8::MAX);
        if self.sent == 0 {
            self.first_sent = now;
        }
        self.sent += 1;
        self.last_sent = now;
        send(&command, effects);
    }
}

fn name(command: &COMMAND_LONG_DATA) -> String {
    format!("{:?}", command.command)
}

fn refusal(result: MavResult, command: &COMMAND_LONG_DATA) -> Refusal {
    let word = format!("{result:?}");
    let word = word.strip_prefix("MAV_RESULT_").unwrap_or(&word).to_lowercase();
    match result {
        MavResult::MAV_RESULT_UNSUPPORTED => Refusal::not_supported(format!("{} by this device", name(command))),
        MavResult::MAV_RESULT_NOT_IN_CONTROL => Refusal::not_permitted("somebody else is in control of the device"),
        _ => Refusal::Autopilot {
            result: word,
            text: name(command),
        },
    }
}
