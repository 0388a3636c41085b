//! The words of an autopilot's parameters: values with their types, what is known of them, how far a reading has come, and why one was
//! not written.
//!
//! Must never do: decide whether a parameter may be written; the rule is `skein-safety`'s.

use crate::{CommandId, Refusal};
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Longest name of a parameter, in characters.
pub const LONGEST_PARAMETER_NAME: usize = 16;

/// A parameter's value with its type. What it counts (metres, seconds, choices) only the autopilot knows.
#[derive(Debug, Clone, Copy, PartialEq)]
#[derive(Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(tag = "type", content = "value", rename_all = "snake_case")]
pub enum ParameterValue {
    /// A whole number (PX4: INT32).
    Integer(i32),
    /// A number (PX4: FLOAT). Absent in JSON if it is none.
    Real(
        #[ts(type = "number | null")]
        #[schemars(with = "Option<f32>")]
        f32,
    ),
}

impl ParameterValue {
    /// A number as it is typed, before it is known what type the parameter has: whole numbers as such where they fit.
    #[must_use]
    pub fn of_number(number: f64) -> Self {
        let whole = number.fract() == 0.0 && (f64::from(i32::MIN)..=f64::from(i32::MAX)).contains(&number);
        if whole {
            Self::Integer(number as i32)
        } else {
            Self::Real(number as f32)
        }
    }

    /// Its type in words.
    #[must_use]
    pub fn kind(self) -> &'static str {
        match self {
            Self::Integer(_) => "a whole number",
            Self::Real(_) => "a real number",
        }
    }

    /// Whether it is the same, not-a-number included.
    #[must_use]
    pub fn is(self, other: Self) -> bool {
        match (self, other) {
            (Self::Integer(one), Self::Integer(other)) => one == other,
            (Self::Real(one), Self::Real(other)) => one.to_bits() == other.to_bits(),
            _ => false,
        }
    }
}

impl std::fmt::Display for ParameterValue {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Integer(value) => write!(f, "{value}"),
            Self::Real(value) => write!(f, "{value}"),
        }
    }
}

/// One parameter as it is known.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
pub struct Parameter {
    /// Its name.
    pub name: String,
    /// Its value, as the autopilot said last.
    pub value: ParameterValue,
    /// The value it had before it was first written here, if that is another one.
    pub changed_from: Option<ParameterValue>,
}

/// How the reading of all parameters stands.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
#[derive(Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(tag = "state", rename_all = "snake_case")]
pub enum ParameterReading {
    /// Nobody has asked for them since the autopilot's start.
    #[default]
    NotBegun,
    /// Under way.
    Reading,
    /// All that the autopilot says it has were read.
    Complete,
    /// It ended before that.
    Ended {
        /// Why.
        why: String,
    },
}

/// The parameters of a vehicle, as far as they are known.
#[derive(Debug, Clone, PartialEq, Default)]
#[derive(Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
pub struct ParameterList {
    /// How the reading of all stands.
    pub reading: ParameterReading,
    /// How many of them were read.
    pub read: u32,
    /// How many there are, once the autopilot has said so.
    pub total: Option<u32>,
    /// Grows with every change of a value. To be given with the next request, for what has changed since.
    pub revision: u64,
    /// All that is known is here, and nothing else is known any more; otherwise only what has changed.
    pub whole: bool,
    /// By ascending name.
    pub parameters: Vec<Parameter>,
}

/// What is wanted of the reading of all parameters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[derive(Serialize, Deserialize, ts_rs::TS, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ReadingAction {
    /// To begin it, if it is neither under way nor complete; what was read stays.
    Begin,
    /// To begin it from the start.
    Anew,
    /// To break it off; what was read stays.
    Stop,
}

/// How the reading or writing of one parameter ended.
#[derive(Debug, Clone, PartialEq)]
pub struct ParameterEvent {
    /// The write it belongs to; none for a read.
    pub id: Option<CommandId>,
    /// The parameter.
    pub name: String,
    /// Its value before, if it was known.
    pub before: Option<ParameterValue>,
    /// Its value now, or why not.
    pub outcome: Result<ParameterValue, ParameterError>,
}

/// Why a parameter was not read or written.
#[derive(Debug, Clone, PartialEq, Error, Serialize)]
#[serde(tag = "reason", rename_all = "snake_case")]
pub enum ParameterError {
    /// The name cannot be a parameter's.
    #[error("\"{name}\" is no parameter name: 1 to 16 ASCII characters")]
    InvalidName {
        /// The name.
        name: String,
    },
    /// The autopilot has none of that name.
    #[error("the autopilot has no parameter {name}")]
    Unknown {
        /// The name.
        name: String,
    },
    /// No answer; PX4 also keeps silent about names it does not have.
    #[error("no answer about parameter {name} within {after_s:.1} s; the autopilot may not have it")]
    NoAnswer {
        /// The name.
        name: String,
        /// How long was waited, in seconds.
        after_s: f64,
    },
    /// The value does not fit the parameter's type.
    #[error("{name} is {actual}, the value {value} does not fit")]
    WrongType {
        /// The name.
        name: String,
        /// What type it has, in words.
        actual: &'static str,
        /// The value.
        value: ParameterValue,
    },
    /// The value is beyond what the type can hold, or what the autopilot takes.
    #[error("{value} is out of the range of {name}: {detail}")]
    OutOfRange {
        /// The name.
        name: String,
        /// The value.
        value: ParameterValue,
        /// Whose range.
        detail: &'static str,
    },
    /// The autopilot kept another value.
    #[error("the autopilot keeps {name} at {kept} instead of {asked}: {why}")]
    NotTaken {
        /// The name.
        name: String,
        /// What was asked for.
        asked: ParameterValue,
        /// What it kept.
        kept: ParameterValue,
        /// Its reason, or that it gave none.
        why: String,
    },
    /// The vehicle is armed, or about to be.
    #[error("{name} is not written while the vehicle is armed: disarm it first")]
    Armed {
        /// The name.
        name: String,
    },
    /// Too many operations are waiting.
    #[error("too many parameter operations are waiting already")]
    Busy,
    /// The link was lost, the autopilot restarted, or two vehicles use the system id.
    #[error("broken off: {why}")]
    BrokenOff {
        /// Which of them.
        why: String,
    },
    /// Refused before it came to the parameter.
    #[error("{0}")]
    #[serde(untagged)]
    Refused(#[from] Refusal),
}

impl ParameterError {
    /// The machine-readable word for the reason.
    #[must_use]
    pub fn code(&self) -> &'static str {
        match self {
            Self::InvalidName { .. } => "invalid_name",
            Self::Unknown { .. } => "unknown_parameter",
            Self::NoAnswer { .. } => "no_answer",
            Self::WrongType { .. } => "wrong_type",
            Self::OutOfRange { .. } => "out_of_range",
            Self::NotTaken { .. } => "kept_at_other_value",
            Self::Armed { .. } => "armed",
            Self::Busy => "busy",
            Self::BrokenOff { .. } => "broken_off",
            Self::Refused(refusal) => refusal.code(),
        }
    }
}

/// Whether a parameter can be called so.
///
/// # Errors
/// If not.
pub fn check_parameter_name(name: &str) -> Result<(), ParameterError> {
    let fits = (1..=LONGEST_PARAMETER_NAME).contains(&name.len()) && name.bytes().all(|byte| byte.is_ascii_graphic());
    if fits {
        return Ok(());
    }
    // What somebody sends for a name is not said back at any length.
    let name = name.chars().take(2 * LONGEST_PARAMETER_NAME).collect();
    Err(ParameterError::InvalidName { name })
}

#[cfg(test)]
mod tests {
    //! What a number is before its type is known, and how reasons look in JSON.

    use super::*;

    #[test]
    fn a_typed_number_is_whole_where_it_can_be() {
        for (number, value) in [
            (5.0, ParameterValue::Integer(5)),
            (-2_147_483_648.0, ParameterValue::Integer(i32::MIN)),
            (2_147_483_648.0, ParameterValue::Real(2_147_483_648.0)),
            (0.15, ParameterValue::Real(0.15)),
        ] {
            assert_eq!(ParameterValue::of_number(number), value);
        }
        assert!(ParameterValue::of_number(1e300).is(ParameterValue::Real(f32::INFINITY)));
    }

    #[test]
    fn reasons_have_their_facts_beside_them() {
        let armed = ParameterError::Armed { name: "A".into() };
        assert_eq!(
            serde_json::to_value(&armed).unwrap(),
            serde_json::json!({ "reason": "armed", "name": "A" })
        );
        let refused = ParameterError::from(Refusal::PilotInControl);
        assert_eq!(
            serde_json::to_value(&refused).unwrap(),
            serde_json::json!({ "reason": "pilot_in_control" })
        );
        let real = ParameterValue::Real(0.15);
        assert_eq!(serde_json::to_string(&real).unwrap(), r#"{"type":"real","value":0.15}"#);
        assert_eq!(
            serde_json::to_string(&ParameterValue::Real(f32::NAN)).unwrap(),
            r#"{"type":"real","value":null}"#
        );
    }

    #[test]
    fn names_have_bounds() {
        assert!(check_parameter_name("SIXTEEN_LETTERS_").is_ok());
        for name in ["", "SEVENTEEN_LETTERS", "with space", "ümlaut"] {
            assert!(check_parameter_name(name).is_err(), "{name}");
        }
    }
}
