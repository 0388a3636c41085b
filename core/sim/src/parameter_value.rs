//! The value of a parameter of PX4, which puts a whole number bit by bit into a field declared as float.
//!
//! Must never do: convert between the two types.

/// Value of a parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ParameterValue {
    /// 32-bit integer.
    Int(i32),
    /// 32-bit float.
    Real(f32),
}

impl ParameterValue {
    /// The bytes of the value, seen as the float that the wire format declares.
    #[must_use]
    pub fn on_wire(self) -> f32 {
        match self {
            Self::Int(value) => f32::from_bits(value as u32),
            Self::Real(value) => value,
        }
    }

    /// The value with the type of this one whose bytes are those of a received float.
    #[must_use]
    pub fn with_wire(self, field: f32) -> Self {
        match self {
            Self::Int(_) => Self::Int(field.to_bits() as i32),
            Self::Real(_) => Self::Real(field),
        }
    }

    /// As a number.
    #[must_use]
    pub fn number(self) -> f64 {
        match self {
            Self::Int(value) => f64::from(value),
            Self::Real(value) => f64::from(value),
        }
    }
}
