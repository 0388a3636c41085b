//! The messages of PX4's interface, as data: names, types and order of their fields. From one declaration come the struct that serde reads,
//! the size on the wire and the hash that ROS 2 gives a type.
//!
//! Must never do: change a message. What another release of PX4 defines otherwise is another struct.
//!
//! All of them have a fixed size: there is neither a string nor a sequence in any message that Skein uses.

pub mod estimate;
pub mod incoming;
pub mod sensors;
pub mod state;

/// Type of a field, as messages of ROS 2 name it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Kind {
    /// `bool`.
    Bool,
    /// `uint8`.
    U8,
    /// `uint16`.
    U16,
    /// `uint32`.
    U32,
    /// `uint64`.
    U64,
    /// `int32`.
    I32,
    /// `int64`.
    I64,
    /// `float32`.
    F32,
    /// `float64`.
    F64,
}

impl Kind {
    /// Size in octets, which is also what it is aligned to.
    #[must_use]
    pub const fn size_bytes(self) -> usize {
        match self {
            Self::Bool | Self::U8 => 1,
            Self::U16 => 2,
            Self::U32 | Self::I32 | Self::F32 => 4,
            Self::U64 | Self::I64 | Self::F64 => 8,
        }
    }

    /// The word for it in a message definition.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Bool => "bool",
            Self::U8 => "uint8",
            Self::U16 => "uint16",
            Self::U32 => "uint32",
            Self::U64 => "uint64",
            Self::I32 => "int32",
            Self::I64 => "int64",
            Self::F32 => "float32",
            Self::F64 => "float64",
        }
    }
}

/// One field of a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Field {
    /// Its name.
    pub name: &'static str,
    /// The type of it, or of its elements.
    pub kind: Kind,
    /// How many elements, of an array; `None` if it is none.
    pub elements: Option<usize>,
}

/// Rust's type of a field.
pub trait Wire {
    /// Type of it, or of its elements.
    const KIND: Kind;
    /// How many elements, of an array.
    const ELEMENTS: Option<usize> = None;
}

macro_rules! wire {
    ($($rust:ty => $kind:ident),+) => {
        $(impl Wire for $rust {
            const KIND: Kind = Kind::$kind;
        })+
    };
}
wire!(bool => Bool, u8 => U8, u16 => U16, u32 => U32, u64 => U64, i32 => I32, i64 => I64, f32 => F32, f64 => F64);

impl<T: Wire, const N: usize> Wire for [T; N] {
    const KIND: Kind = T::KIND;
    const ELEMENTS: Option<usize> = Some(N);
}

/// A message.
pub trait Message: serde::Serialize + serde::de::DeserializeOwned {
    /// Its name in `px4_msgs`.
    const NAME: &'static str;
    /// Its fields, in order.
    const FIELDS: &'static [Field];
}

/// How many octets fields take in a sample, with what is between them for alignment.
#[must_use]
pub const fn size_bytes(fields: &[Field]) -> usize {
    let mut size: usize = 0;
    let mut i: usize = 0;
    while i < fields.len() {
        let field = &fields[i];
        let one = field.kind.size_bytes();
        size = size.div_ceil(one) * one;
        size += match field.elements {
            None => one,
            Some(elements) => one * elements,
        };
        i += 1;
    }
    size
}

/// Declares messages: the Rust name of this shape, the name that PX4 gives the message, and the fields.
macro_rules! messages {
    ($($(#[$doc:meta])* $name:ident = $px4:literal { $($field:ident: $kind:ty),+ $(,)? })+) => {
        $(
            $(#[$doc])*
            #[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
            #[allow(missing_docs, reason = "the fields are PX4's; what they mean stands in its documentation under these names")]
            pub struct $name { $(pub $field: $kind),+ }

            impl $crate::messages::Message for $name {
                const NAME: &'static str = $px4;
                const FIELDS: &'static [$crate::messages::Field] = &[$($crate::messages::Field {
                    name: stringify!($field),
                    kind: <$kind as $crate::messages::Wire>::KIND,
                    elements: <$kind as $crate::messages::Wire>::ELEMENTS,
                }),+];
            }
        )+
    };
}
use messages;

#[cfg(test)]
mod tests;
