//! Parameters: all of them on request, or by name. Read before they are written so that the type is right, written until the echo agrees,
//! and kept.
//!
//! PX4 sends integers byte by byte in the field of a float; other autopilots send the number. A write is echoed twice; an
//! integer written as a float is stored as nonsense, which is why no type is ever guessed here.
//!
//! Must never do: write to an armed vehicle, or keep more names than an autopilot has.

mod listing;
mod wire;

use listing::{COUNT_MAX, Listing, Wanted};
use mavlink::dialects::common::{
    PARAM_ERROR_DATA, PARAM_REQUEST_LIST_DATA, PARAM_REQUEST_READ_DATA, PARAM_SET_DATA, PARAM_VALUE_DATA,
};
use mavlink::types::CharArray;
use skein_domain::parameter::check_parameter_name;
use skein_domain::{
    CommandId, NodeTime, Parameter, ParameterError, ParameterEvent, ParameterList, ParameterValue, ReadingAction,
};
use std::collections::{BTreeMap, VecDeque};
use wire::{agrees, decode, encode};

/// How often a read or write is sent.
const ATTEMPTS: u8 = 4;
/// How long an answer is awaited, in seconds.
const TIMEOUT_S: f64 = 0.7;
/// Most operations waiting.
const QUEUE_MAX: usize = 64;
/// A name under which PX4 sends a checksum of all, which is no parameter.
const CHECKSUM: &str = "_HASH_CHECK";

/// To be sent.
#[derive(Debug, Clone, PartialEq)]
pub enum ParameterMessage {
    /// PARAM_REQUEST_LIST.
    List(PARAM_REQUEST_LIST_DATA),
    /// PARAM_REQUEST_READ.
    Read(PARAM_REQUEST_READ_DATA),
    /// PARAM_SET.
    Set(PARAM_SET_DATA),
}

#[derive(Debug)]
struct Operation {
    /// Of a write that somebody waits for.
    id: Option<CommandId>,
    name: String,
    /// To be written; `None` for a read.
    value: Option<ParameterValue>,
    /// Whether the write (and not the read before it) is under way.
    writing: bool,
    attempts: u8,
    first: NodeTime,
    deadline: NodeTime,
    /// The value before the write.
    before: Option<ParameterValue>,
    /// What another value than ours was echoed; decided when no better echo comes.
    echoed: Option<ParameterValue>,
}

#[derive(Debug, Clone, Copy)]
struct Known {
    value: ParameterValue,
    /// With which change of the table it came.
    revision: u64,
}

/// Parameters of one vehicle.
#[derive(Debug, Default)]
pub struct Parameters {
    known: BTreeMap<String, Known>,
    /// Values before they were first written here. Kept over a restart of the autopilot.
    originals: BTreeMap<String, ParameterValue>,
    revision: u64,
    /// When everything was forgotten last.
    forgotten: u64,
    queue: VecDeque<Operation>,
    events: Vec<ParameterEvent>,
    listing: Listing,
    /// The autopilot sends integers as numbers and not byte by byte.
    by_number: bool,
    /// The motors are armed: nothing is written.
    armed: bool,
}

impl Parameters {
    /// Integers as numbers, as other autopilots than PX4 send them.
    pub fn set_by_number(&mut self, by_number: bool) {
        self.by_number = by_number;
    }

    /// Whether the motors are armed.
    pub fn set_armed(&mut self, armed: bool) {
        self.armed = armed;
    }

    /// A value that is known already.
    #[must_use]
    pub fn known(&self, name: &str) -> Option<ParameterValue> {
        self.known.get(name).map(|known| known.value)
    }

    /// How operations ended since the last call.
    pub fn take_events(&mut self) -> Vec<ParameterEvent> {
        std::mem::take(&mut self.events)
    }

    /// What has changed since a revision, or everything; and how the reading of all stands.
    #[must_use]
    pub fn list(&self, since: u64) -> ParameterList {
        let whole = since == 0 || since < self.forgotten || since > self.revision;
        let news = self.known.iter().filter(|(_, known)| whole || known.revision > since);
        ParameterList {
            reading: self.listing.state(),
            read: u32::try_from(self.listing.read()).unwrap_or(u32::MAX),
            total: self.listing.total().and_then(|total| u32::try_from(total).ok()),
            revision: self.revision,
            whole,
            parameters: news.map(|(name, known)| self.parameter(name, known.value)).collect(),
        }
    }

    fn parameter(&self, name: &str, value: ParameterValue) -> Parameter {
        let original = self.originals.get(name).copied();
        Parameter {
            name: name.to_owned(),
            value,
            changed_from: original.filter(|original| !original.is(value)),
        }
    }

    /// Begins to read all, or ends that.
    pub fn read_all(&mut self, now: NodeTime, action: ReadingAction) {
        match action {
            ReadingAction::Begin => self.listing.begin(now),
            ReadingAction::Anew => {
                self.forget();
                self.listing.begin(now);
            }
            ReadingAction::Stop => self.listing.stop("it was stopped"),
        }
    }

    fn forget(&mut self) {
        self.known.clear();
        self.listing.forget();
        self.revision += 1;
        self.forgotten = self.revision;
    }

    /// Reads one anew (`value` none) or writes one.
    ///
    /// # Errors
    /// If it can be said at once that it will not work.
    pub fn start(&mut self, now: NodeTime, name: &str, value: Option<ParameterValue>) -> Result<(), ParameterError> {
        self.queue_up(now, None, name, value)
    }

    /// Writes one. What can be said at once comes as an event, too.
    pub fn write(&mut self, now: NodeTime, id: CommandId, name: &str, value: ParameterValue) {
        if let Err(error) = self.queue_up(now, Some(id), name, Some(value)) {
            self.refuse(id, name, error);
        }
    }

    /// Says of a write that it is not done.
    pub fn refuse(&mut self, id: CommandId, name: &str, error: ParameterError) {
        self.push(ParameterEvent {
            id: Some(id),
            name: name.to_owned(),
            before: self.known(name),
            outcome: Err(error),
        });
    }

    fn queue_up(
        &mut self,
        now: NodeTime,
        id: Option<CommandId>,
        name: &str,
        value: Option<ParameterValue>,
    ) -> Result<(), ParameterError> {
        check_parameter_name(name)?;
        if self.armed && value.is_some() {
            return Err(ParameterError::Armed { name: name.to_owned() });
        }
        if self.queue.len() >= QUEUE_MAX {
            return Err(ParameterError::Busy);
        }
        self.queue.push_back(Operation {
            id,
            name: name.to_owned(),
            value,
            writing: false,
            attempts: 0,
            first: now,
            deadline: now,
            before: None,
            echoed: None,
        });
        Ok(())
    }

    /// What is to be sent now. Single parameters go before the reading of all.
    pub fn poll(&mut self, now: NodeTime, target: (u8, u8)) -> Option<ParameterMessage> {
        let (target_system, target_component) = target;
        let single = self.poll_queue(now, target);
        single.or_else(|| {
            Some(match self.listing.poll(now)? {
                Wanted::All => ParameterMessage::List(PARAM_REQUEST_LIST_DATA {
                    target_system,
                    target_component,
                }),
                Wanted::Number(number) => ParameterMessage::Read(PARAM_REQUEST_READ_DATA {
                    param_index: i16::try_from(number).unwrap_or(i16::MAX),
                    target_system,
                    target_component,
                    param_id: CharArray::from(""),
                }),
            })
        })
    }

    fn poll_queue(&mut self, now: NodeTime, target: (u8, u8)) -> Option<ParameterMessage> {
        loop {
            let operation = self.queue.front_mut()?;
            if operation.attempts == 0 {
                operation.first = now;
            } else if now < operation.deadline {
                return None;
            }
            let have = self.known.get(&operation.name).map(|known| known.value);
            if operation.value.is_some() && !operation.writing && have.is_some() {
                operation.writing = true;
                operation.before = have;
            }
            // It may have been armed while the write waited, or while its echo did.
            let armed = self.armed && operation.value.is_some();
            if operation.attempts >= ATTEMPTS || armed {
                let error = given_up(operation, now, armed);
                self.end(Err(error));
                continue;
            }
            operation.attempts += 1;
            operation.deadline = now.plus_seconds(TIMEOUT_S);
            let param_id = CharArray::from(operation.name.as_str());
            let (target_system, target_component) = target;
            let Some(value) = operation.value.filter(|_| operation.writing) else {
                let by_name = -1;
                return Some(ParameterMessage::Read(PARAM_REQUEST_READ_DATA {
                    param_index: by_name,
                    target_system,
                    target_component,
                    param_id,
                }));
            };
            match encode(&operation.name, value, have, self.by_number) {
                Ok((param_value, param_type)) => {
                    return Some(ParameterMessage::Set(PARAM_SET_DATA {
                        param_value,
                        target_system,
                        target_component,
                        param_id,
                        param_type,
                    }));
                }
                Err(error) => self.end(Err(error)),
            }
        }
    }

    /// When [`Self::poll`] has something to do next.
    #[must_use]
    pub fn due(&self) -> Option<NodeTime> {
        let single = self.queue.front().map(|operation| operation.deadline);
        single.into_iter().chain(self.listing.due()).min()
    }

    /// Takes in a value: an answer, an echo, one of all, or news.
    pub fn on_value(&mut self, now: NodeTime, message: &PARAM_VALUE_DATA) {
        let Ok(name) = message.param_id.to_str() else { return };
        if name == CHECKSUM || check_parameter_name(name).is_err() {
            return;
        }
        let listed = self.listing.is_running();
        self.listing.on_value(now, message.param_index, message.param_count);
        let Some(value) = decode(message.param_value, message.param_type, self.by_number) else {
            return;
        };
        if listed || self.known.contains_key(name) || self.queue.iter().any(|operation| operation.name == name) {
            self.keep(name, value);
        }
        let Some(operation) = self.queue.front_mut().filter(|operation| operation.name == name) else {
            return;
        };
        if operation.attempts == 0 {
            return;
        }
        match operation.value {
            None => self.end(Ok(value)),
            Some(_) if !operation.writing => {
                // The type is known now: write at once, with attempts of its own.
                (operation.writing, operation.attempts, operation.deadline) = (true, 0, now);
                operation.before = Some(value);
            }
            Some(asked) if agrees(asked, value) => self.end(Ok(value)),
            Some(_) => operation.echoed = Some(value),
        }
    }

    fn keep(&mut self, name: &str, value: ParameterValue) {
        let full = self.known.len() >= usize::from(COUNT_MAX);
        let is_news = match self.known(name) {
            Some(known) => !known.is(value),
            None => !full,
        };
        if is_news {
            self.revision += 1;
            let revision = self.revision;
            self.known.insert(name.to_owned(), Known { value, revision });
        }
    }

    /// Takes in a refusal.
    pub fn on_error(&mut self, message: &PARAM_ERROR_DATA) {
        use mavlink::dialects::common::MavParamError::{
            MAV_PARAM_ERROR_DOES_NOT_EXIST, MAV_PARAM_ERROR_NO_ERROR, MAV_PARAM_ERROR_VALUE_OUT_OF_RANGE,
        };
        let Ok(name) = message.param_id.to_str() else { return };
        let Some(operation) = self
            .queue
            .front()
            .filter(|operation| operation.name == name && operation.attempts > 0)
        else {
            return;
        };
        let (asked, name) = (operation.value, name.to_owned());
        match (message.error, asked, self.known(&name)) {
            (MAV_PARAM_ERROR_NO_ERROR, ..) => {}
            (MAV_PARAM_ERROR_DOES_NOT_EXIST, ..) | (_, None, _) | (_, _, None) => {
                self.end(Err(ParameterError::Unknown { name }));
            }
            (MAV_PARAM_ERROR_VALUE_OUT_OF_RANGE, Some(value), _) => {
                let detail = "the autopilot does not take it";
                self.end(Err(ParameterError::OutOfRange { name, value, detail }));
            }
            (error, Some(asked), Some(kept)) => {
                let why = format!("{error:?}")
                    .trim_start_matches("MAV_PARAM_ERROR_")
                    .to_lowercase();
                self.end(Err(ParameterError::NotTaken { name, asked, kept, why }));
            }
        }
    }

    /// Ends all operations; after a restart of the autopilot nothing is known any more.
    pub fn break_off(&mut self, why: &str, forget: bool) {
        while !self.queue.is_empty() {
            self.end(Err(ParameterError::BrokenOff { why: why.to_owned() }));
        }
        self.listing.stop(why);
        if forget {
            self.forget();
        }
    }

    fn end(&mut self, outcome: Result<ParameterValue, ParameterError>) {
        let Some(operation) = self.queue.pop_front() else {
            return;
        };
        if let (true, Some(before)) = (operation.writing, operation.before) {
            self.originals.entry(operation.name.clone()).or_insert(before);
            // What it differs from is news as well.
            if let Some(known) = self.known.get_mut(&operation.name) {
                self.revision += 1;
                known.revision = self.revision;
            }
        }
        self.push(ParameterEvent {
            id: operation.id,
            name: operation.name,
            before: operation.before,
            outcome,
        });
    }

    fn push(&mut self, event: ParameterEvent) {
        if self.events.len() >= 2 * QUEUE_MAX {
            self.events.remove(0);
        }
        self.events.push(event);
    }
}

/// Why an operation is not tried any longer.
fn given_up(operation: &Operation, now: NodeTime, armed: bool) -> ParameterError {
    let name = operation.name.clone();
    let sent = operation.writing && operation.attempts > 0;
    match (operation.value, operation.echoed) {
        (Some(asked), Some(kept)) => ParameterError::NotTaken {
            name,
            asked,
            kept,
            why: "no reason was given".to_owned(),
        },
        _ if armed && !sent => ParameterError::Armed { name },
        _ => ParameterError::NoAnswer {
            name,
            after_s: now.seconds_since(operation.first),
        },
    }
}

#[cfg(test)]
mod tests;
