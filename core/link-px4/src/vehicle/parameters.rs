//! Parameters by name: read before they are written so that the type is right, written until the echo agrees, and kept.
//!
//! PX4 sends integers byte by byte in the field of a float; other autopilots send the number. A write is echoed twice; an
//! integer written as a float is stored as nonsense, which is why no type is ever guessed here.

use mavlink::dialects::common::{
    MavParamType, PARAM_ERROR_DATA, PARAM_REQUEST_READ_DATA, PARAM_SET_DATA, PARAM_VALUE_DATA,
};
use mavlink::types::CharArray;
use skein_domain::NodeTime;
use std::collections::{BTreeMap, VecDeque};

/// How often a read or write is sent.
const ATTEMPTS: u8 = 4;
/// How long an answer is awaited, in seconds.
const TIMEOUT_S: f64 = 0.7;
/// Most operations waiting.
const QUEUE_MAX: usize = 64;
/// Longest name.
const NAME_MAX: usize = 16;
/// Largest whole number a float holds exactly.
const FLOAT_WHOLE_MAX: f64 = 16_777_216.0;

/// A parameter's value with its type.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ParameterValue {
    /// A whole number (PX4: INT32).
    Integer(i32),
    /// A number (PX4: FLOAT).
    Real(f32),
}

impl std::fmt::Display for ParameterValue {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Integer(value) => write!(f, "{value}"),
            Self::Real(value) => write!(f, "{value}"),
        }
    }
}

/// Why a parameter was not read or written.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ParameterError {
    /// The name cannot be a parameter's.
    #[error("`{name}` is no parameter name: 1 to 16 ASCII characters")]
    InvalidName {
        /// The name.
        name: String,
    },
    /// The autopilot has none of that name.
    #[error("the autopilot has no parameter `{name}`")]
    Unknown {
        /// The name.
        name: String,
    },
    /// No answer; PX4 also keeps silent about names it does not have.
    #[error("no answer about parameter `{name}` within {after_s:.1} s; the autopilot may not have it")]
    NoAnswer {
        /// The name.
        name: String,
        /// How long was waited, in seconds.
        after_s: f64,
    },
    /// The value does not fit the parameter's type.
    #[error("parameter `{name}` is {actual}, the value {value} does not fit")]
    WrongType {
        /// The name.
        name: String,
        /// What type it has, in words.
        actual: &'static str,
        /// The value.
        value: ParameterValue,
    },
    /// The autopilot kept another value.
    #[error("the autopilot keeps `{name}` at {kept} instead of {asked}: {reason}")]
    NotTaken {
        /// The name.
        name: String,
        /// What was asked for.
        asked: ParameterValue,
        /// What it kept.
        kept: ParameterValue,
        /// Its reason, or that it gave none.
        reason: String,
    },
    /// Too many operations are waiting.
    #[error("{QUEUE_MAX} parameter operations are waiting already")]
    Busy,
    /// The link was lost, the autopilot restarted, or two vehicles use the system id.
    #[error("broken off: {reason}")]
    BrokenOff {
        /// Which of them.
        reason: String,
    },
}

/// How a read or write ended.
#[derive(Debug, Clone, PartialEq)]
pub struct ParameterEvent {
    /// The parameter.
    pub name: String,
    /// Its value now, or why not.
    pub outcome: Result<ParameterValue, ParameterError>,
}

/// To be sent.
#[derive(Debug, Clone, PartialEq)]
pub enum ParameterMessage {
    /// PARAM_REQUEST_READ.
    Read(PARAM_REQUEST_READ_DATA),
    /// PARAM_SET.
    Set(PARAM_SET_DATA),
}

#[derive(Debug)]
struct Operation {
    name: String,
    /// To be written; `None` for a read.
    value: Option<ParameterValue>,
    /// Whether the write (and not the read before it) is under way.
    writing: bool,
    attempts: u8,
    first: NodeTime,
    deadline: NodeTime,
    /// What another value than ours was echoed; decided when no better echo comes.
    echoed: Option<ParameterValue>,
}

/// Parameters of one vehicle.
#[derive(Debug, Default)]
pub struct Parameters {
    known: BTreeMap<String, ParameterValue>,
    queue: VecDeque<Operation>,
    events: Vec<ParameterEvent>,
    /// The autopilot sends integers as numbers and not byte by byte.
    by_number: bool,
}

impl Parameters {
    /// Integers as numbers, as other autopilots than PX4 send them.
    pub fn set_by_number(&mut self, by_number: bool) {
        self.by_number = by_number;
    }

    /// A value that is known already.
    #[must_use]
    pub fn known(&self, name: &str) -> Option<ParameterValue> {
        self.known.get(name).copied()
    }

    /// How operations ended since the last call.
    pub fn take_events(&mut self) -> Vec<ParameterEvent> {
        std::mem::take(&mut self.events)
    }

    /// Reads one anew (`value` none) or writes one.
    ///
    /// # Errors
    /// If it can be said at once that it will not work.
    pub fn start(&mut self, now: NodeTime, name: &str, value: Option<ParameterValue>) -> Result<(), ParameterError> {
        if name.is_empty() || name.len() > NAME_MAX || !name.bytes().all(|b| b.is_ascii_graphic()) {
            return Err(ParameterError::InvalidName { name: name.to_owned() });
        }
        if self.queue.len() >= QUEUE_MAX {
            return Err(ParameterError::Busy);
        }
        let name = name.to_owned();
        self.queue.push_back(Operation {
            name,
            value,
            writing: false,
            attempts: 0,
            first: now,
            deadline: now,
            echoed: None,
        });
        Ok(())
    }

    /// What is to be sent now.
    pub fn poll(&mut self, now: NodeTime, target: (u8, u8)) -> Option<ParameterMessage> {
        loop {
            let operation = self.queue.front_mut()?;
            if operation.attempts == 0 {
                operation.first = now;
            } else if now < operation.deadline {
                return None;
            }
            if operation.value.is_some() && !operation.writing && self.known.contains_key(&operation.name) {
                operation.writing = true;
            }
            if operation.attempts >= ATTEMPTS {
                let after_s = now.seconds_since(operation.first);
                let name = operation.name.clone();
                let error = match (operation.value, operation.echoed) {
                    (Some(asked), Some(kept)) => ParameterError::NotTaken {
                        name,
                        asked,
                        kept,
                        reason: "no reason was given".to_owned(),
                    },
                    _ => ParameterError::NoAnswer { name, after_s },
                };
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
            let have = self.known.get(&operation.name).copied();
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
        self.queue.front().map(|operation| operation.deadline)
    }

    /// Takes in a value: an answer, an echo, or news.
    pub fn on_value(&mut self, now: NodeTime, message: &PARAM_VALUE_DATA) {
        let Ok(name) = message.param_id.to_str() else { return };
        let Some(value) = decode(message.param_value, message.param_type, self.by_number) else {
            return;
        };
        if self.known.contains_key(name) || self.queue.iter().any(|operation| operation.name == name) {
            self.known.insert(name.to_owned(), value);
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
            }
            Some(asked) if agrees(asked, value) => self.end(Ok(value)),
            Some(_) => operation.echoed = Some(value),
        }
    }

    /// Takes in a refusal.
    pub fn on_error(&mut self, message: &PARAM_ERROR_DATA) {
        use mavlink::dialects::common::MavParamError::{MAV_PARAM_ERROR_DOES_NOT_EXIST, MAV_PARAM_ERROR_NO_ERROR};
        let Ok(name) = message.param_id.to_str() else { return };
        let Some(operation) = self
            .queue
            .front()
            .filter(|operation| operation.name == name && operation.attempts > 0)
        else {
            return;
        };
        let name = name.to_owned();
        match (message.error, operation.value, self.known.get(&name).copied()) {
            (MAV_PARAM_ERROR_NO_ERROR, ..) => {}
            (MAV_PARAM_ERROR_DOES_NOT_EXIST, ..) | (_, None, _) | (_, _, None) => {
                self.end(Err(ParameterError::Unknown { name }));
            }
            (error, Some(asked), Some(kept)) => {
                let reason = format!("{error:?}")
                    .trim_start_matches("MAV_PARAM_ERROR_")
                    .to_lowercase();
                self.end(Err(ParameterError::NotTaken {
                    name,
                    asked,
                    kept,
                    reason,
                }));
            }
        }
    }

    /// Ends all operations; after a restart of the autopilot nothing is known any more.
    pub fn break_off(&mut self, reason: &str, forget: bool) {
        while !self.queue.is_empty() {
            self.end(Err(ParameterError::BrokenOff {
                reason: reason.to_owned(),
            }));
        }
        if forget {
            self.known.clear();
        }
    }

    fn end(&mut self, outcome: Result<ParameterValue, ParameterError>) {
        if let Some(operation) = self.queue.pop_front() {
            if self.events.len() >= 2 * QUEUE_MAX {
                self.events.remove(0);
            }
            self.events.push(ParameterEvent {
                name: operation.name,
                outcome,
            });
        }
    }
}

/// Whether an echo is what was written.
fn agrees(asked: ParameterValue, echoed: ParameterValue) -> bool {
    match (asked, echoed) {
        (ParameterValue::Integer(asked), ParameterValue::Integer(echoed)) => asked == echoed,
        (ParameterValue::Real(asked), ParameterValue::Real(echoed)) => asked.to_bits() == echoed.to_bits(),
        (ParameterValue::Integer(asked), ParameterValue::Real(echoed)) => f64::from(asked) == f64::from(echoed),
        (ParameterValue::Real(asked), ParameterValue::Integer(echoed)) => f64::from(asked) == f64::from(echoed),
    }
}

/// The field's value and type on the wire for a parameter of the type of `have`.
fn encode(
    name: &str,
    value: ParameterValue,
    have: Option<ParameterValue>,
    by_number: bool,
) -> Result<(f32, MavParamType), ParameterError> {
    let wrong = |actual| ParameterError::WrongType {
        name: name.to_owned(),
        actual,
        value,
    };
    let fitting = match (have, value) {
        (Some(ParameterValue::Real(_)), ParameterValue::Integer(i)) if f64::from(i).abs() <= FLOAT_WHOLE_MAX => {
            ParameterValue::Real(i as f32)
        }
        (Some(ParameterValue::Real(_)), ParameterValue::Integer(_)) => return Err(wrong("a real number")),
        (Some(ParameterValue::Integer(_)), ParameterValue::Real(r)) => {
            if r.fract() != 0.0 || f64::from(r).abs() > FLOAT_WHOLE_MAX {
                return Err(wrong("a whole number"));
            }
            ParameterValue::Integer(r as i32)
        }
        (_, value) => value,
    };
    match fitting {
        ParameterValue::Real(r) if !r.is_finite() => Err(wrong("a finite number")),
        ParameterValue::Real(r) => Ok((r, MavParamType::MAV_PARAM_TYPE_REAL32)),
        ParameterValue::Integer(i) if by_number => Ok((i as f32, MavParamType::MAV_PARAM_TYPE_INT32)),
        ParameterValue::Integer(i) => Ok((f32::from_bits(i.cast_unsigned()), MavParamType::MAV_PARAM_TYPE_INT32)),
    }
}

/// The value in a field; `None` for types wider than the field.
fn decode(field: f32, kind: MavParamType, by_number: bool) -> Option<ParameterValue> {
    let bytes = field.to_bits().to_le_bytes();
    let [a, b, _, _] = bytes;
    Some(match kind {
        MavParamType::MAV_PARAM_TYPE_REAL32 => ParameterValue::Real(field),
        MavParamType::MAV_PARAM_TYPE_REAL64
        | MavParamType::MAV_PARAM_TYPE_INT64
        | MavParamType::MAV_PARAM_TYPE_UINT64 => return None,
        _ if by_number => ParameterValue::Integer(field as i32),
        MavParamType::MAV_PARAM_TYPE_UINT8 => ParameterValue::Integer(i32::from(a)),
        MavParamType::MAV_PARAM_TYPE_INT8 => ParameterValue::Integer(i32::from(a.cast_signed())),
        MavParamType::MAV_PARAM_TYPE_UINT16 => ParameterValue::Integer(i32::from(u16::from_le_bytes([a, b]))),
        MavParamType::MAV_PARAM_TYPE_INT16 => ParameterValue::Integer(i32::from(i16::from_le_bytes([a, b]))),
        MavParamType::MAV_PARAM_TYPE_UINT32 | MavParamType::MAV_PARAM_TYPE_INT32 => {
            ParameterValue::Integer(i32::from_le_bytes(bytes))
        }
    })
}

#[cfg(test)]
mod tests;
