//! The messages of PX4's interface: from one definition in `messages/` the build makes the struct that serde reads and the table of its fields, from
//! which come the size on the wire and the hash that ROS 2 gives a type. A module has what changed with a release of PX4; `incoming` has
//! what PX4 subscribes to under `/fmu/in/`, as far as Skein sends it.
//!
//! Must never do: change a message. What another release of PX4 defines otherwise is another struct.
//!
//! All of them have a fixed size: there is neither a string nor a sequence in any message that Skein uses.

mod kind;

pub use kind::Kind;

include!(concat!(env!("OUT_DIR"), "/messages.rs"));

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

#[cfg(test)]
mod tests;
