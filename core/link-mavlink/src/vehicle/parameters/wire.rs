//! Values in the field of a float: byte by byte as PX4 has integers, or as numbers.
//!
//! Must never do: guess a type.

use mavlink::dialects::common::MavParamType;
use skein_domain::{ParameterError, ParameterValue};

/// Whether an echo is what was written.
pub(super) fn agrees(asked: ParameterValue, echoed: ParameterValue) -> bool {
    match (asked, echoed) {
        (ParameterValue::Integer(asked), ParameterValue::Integer(echoed)) => asked == echoed,
        (ParameterValue::Real(asked), ParameterValue::Real(echoed)) => asked.to_bits() == echoed.to_bits(),
        (ParameterValue::Integer(asked), ParameterValue::Real(echoed)) => f64::from(asked) == f64::from(echoed),
        (ParameterValue::Real(asked), ParameterValue::Integer(echoed)) => f64::from(asked) == f64::from(echoed),
    }
}

/// A value as one of the type of `have`.
fn fitting(name: &str, value: ParameterValue, have: Option<ParameterValue>) -> Result<ParameterValue, ParameterError> {
    let wrong = |actual| ParameterError::WrongType {
        name: name.to_owned(),
        actual,
        value,
    };
    let beyond = |detail| ParameterError::OutOfRange {
        name: name.to_owned(),
        value,
        detail,
    };
    match (have, value) {
        (_, ParameterValue::Real(real)) if real.is_nan() => Err(wrong("a number")),
        (_, ParameterValue::Real(real)) if !real.is_finite() => Err(beyond("32 bits cannot hold it")),
        (Some(ParameterValue::Real(_)), ParameterValue::Integer(whole)) => {
            let real = whole as f32;
            // Not the nearest one: what was asked for would be another value than what is kept.
            if f64::from(real) != f64::from(whole) {
                return Err(beyond("a real number of 32 bits does not hold it exactly"));
            }
            Ok(ParameterValue::Real(real))
        }
        (Some(ParameterValue::Integer(_)), ParameterValue::Real(real)) => {
            let number = f64::from(real);
            if number.fract() != 0.0 {
                return Err(wrong("a whole number"));
            }
            if !(f64::from(i32::MIN)..=f64::from(i32::MAX)).contains(&number) {
                return Err(beyond("a whole number of 32 bits"));
            }
            Ok(ParameterValue::Integer(number as i32))
        }
        (_, value) => Ok(value),
    }
}

/// The field's value and type on the wire for a parameter of the type of `have`.
pub(super) fn encode(
    name: &str,
    value: ParameterValue,
    have: Option<ParameterValue>,
    by_number: bool,
) -> Result<(f32, MavParamType), ParameterError> {
    Ok(match fitting(name, value, have)? {
        ParameterValue::Real(real) => (real, MavParamType::MAV_PARAM_TYPE_REAL32),
        ParameterValue::Integer(whole) if by_number => (whole as f32, MavParamType::MAV_PARAM_TYPE_INT32),
        ParameterValue::Integer(whole) => {
            let field = f32::from_bits(whole.cast_unsigned());
            (field, MavParamType::MAV_PARAM_TYPE_INT32)
        }
    })
}

/// The value in a field; `None` for types wider than the field.
pub(super) fn decode(field: f32, kind: MavParamType, by_number: bool) -> Option<ParameterValue> {
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
