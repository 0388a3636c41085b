//! The messages and services of ROS 2 that are spoken here, as data: names, types and order of their fields. From one declaration come the
//! struct that serde writes as CDR and the list of fields, which a test holds against the definitions that others read.
//!
//! Must never do: differ from the published definition. Another order of fields is another message.

pub mod diagnostic;
pub mod geometry;
pub mod nav;
pub mod rcl;
pub mod sensor;
pub mod skein;
pub mod standard;
pub mod vision;

use serde::de::{DeserializeOwned, Error, SeqAccess, Visitor};
use serde::ser::SerializeTuple;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;

/// A type that can stand in a definition.
pub trait Field {
    /// The word for it there.
    fn word() -> String;

    /// Adds the definition of the message that it is, and of those that stand in it.
    fn define(_: &mut Definitions) {}
}

/// What stands between two definitions in the schema of a bag.
const RULE: &str = "================================================================================";

/// Definitions of messages as text, for readers that do not have them: names, types and order of the fields, without comments and constants.
#[derive(Debug, Default)]
pub struct Definitions {
    told: Vec<String>,
    text: String,
}

impl Definitions {
    /// That of a message, with those of all that stands in it.
    #[must_use]
    pub fn of<M: Interface + Field>() -> String {
        let mut all = Self::default();
        M::define(&mut all);
        all.text
    }

    /// Adds one; whether it was not there yet.
    fn add<M: Interface + Field>(&mut self) -> bool {
        let word = M::word();
        if self.told.contains(&word) {
            return false;
        }
        if !self.told.is_empty() {
            self.text.push_str(&format!("{RULE}\nMSG: {word}\n"));
        }
        for (name, kind) in M::fields() {
            self.text.push_str(&format!("{kind} {name}\n"));
        }
        self.told.push(word);
        true
    }
}

macro_rules! words {
    ($($rust:ty => $word:literal),+ $(,)?) => {
        $(impl Field for $rust {
            fn word() -> String {
                $word.to_owned()
            }
        })+
    };
}
words!(bool => "bool", u8 => "uint8", u16 => "uint16", u32 => "uint32", u64 => "uint64", i8 => "int8", i32 => "int32", f32 => "float32", f64 => "float64", String => "string");

impl<T: Field> Field for Vec<T> {
    fn word() -> String {
        format!("{}[]", T::word())
    }

    fn define(all: &mut Definitions) {
        T::define(all);
    }
}

impl<const N: usize> Field for Fixed<N> {
    fn word() -> String {
        format!("float64[{N}]")
    }
}

/// An array of a fixed length: serde itself knows those of up to 32 only, and a covariance has 36.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fixed<const N: usize>(pub [f64; N]);

impl<const N: usize> Default for Fixed<N> {
    fn default() -> Self {
        Self([0.0; N])
    }
}

impl<const N: usize> Serialize for Fixed<N> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut tuple = serializer.serialize_tuple(N)?;
        for number in &self.0 {
            tuple.serialize_element(number)?;
        }
        tuple.end()
    }
}

impl<'de, const N: usize> Deserialize<'de> for Fixed<N> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Numbers<const N: usize>;
        impl<'de, const N: usize> Visitor<'de> for Numbers<N> {
            type Value = Fixed<N>;

            fn expecting(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(to, "{N} numbers")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut elements: A) -> Result<Self::Value, A::Error> {
                let mut array = [0.0; N];
                for (i, place) in array.iter_mut().enumerate() {
                    let number = elements.next_element()?;
                    *place = number.ok_or_else(|| A::Error::invalid_length(i, &self))?;
                }
                Ok(Fixed(array))
            }
        }
        deserializer.deserialize_tuple(N, Numbers::<N>)
    }
}

/// A message, or one half of a service.
pub trait Interface: Serialize + DeserializeOwned + Clone + Send + 'static {
    /// The package that defines it.
    const PACKAGE: &'static str;
    /// Its name there.
    const NAME: &'static str;

    /// Name and type of its fields, in order.
    fn fields() -> Vec<(&'static str, String)>;
}

/// A service: what is asked, and what is answered.
pub trait Service: Send + Sync + 'static {
    /// The package that defines it.
    const PACKAGE: &'static str;
    /// Its name there.
    const NAME: &'static str;
    /// What is asked.
    type Request: Interface + ros2_client::Message + Sync;
    /// What is answered.
    type Response: Interface + ros2_client::Message + Sync;
}

/// Declares messages of a package; what stands between them in a definition (comments, constants) is not part of them.
macro_rules! messages {
    ($package:literal: $($(#[$doc:meta])* $name:ident { $($(#[$of_field:meta])* $field:ident: $kind:ty),+ $(,)? })+) => {
        $(
            $(#[$doc])*
            #[derive(Debug, Clone, PartialEq, Default, serde::Serialize, serde::Deserialize)]
            #[allow(missing_docs, reason = "what the fields of standard messages mean stands in their definitions under these names")]
            pub struct $name { $($(#[$of_field])* pub $field: $kind),+ }

            impl $crate::interfaces::Field for $name {
                fn word() -> String {
                    concat!($package, "/", stringify!($name)).to_owned()
                }

                fn define(all: &mut $crate::interfaces::Definitions) {
                    if all.add::<Self>() {
                        $(<$kind as $crate::interfaces::Field>::define(all);)+
                    }
                }
            }

            impl $crate::interfaces::Interface for $name {
                const PACKAGE: &'static str = $package;
                const NAME: &'static str = stringify!($name);

                fn fields() -> Vec<(&'static str, String)> {
                    vec![$((stringify!($field), <$kind as $crate::interfaces::Field>::word())),+]
                }
            }

            impl ros2_client::Message for $name {}
        )+
    };
}
use messages;

/// Declares services of a package by the structs of their two halves.
macro_rules! services {
    ($package:literal: $($(#[$doc:meta])* $name:ident = $request:ty => $response:ty),+ $(,)?) => {
        $(
            $(#[$doc])*
            #[derive(Debug, Clone, Copy)]
            pub struct $name;

            impl $crate::interfaces::Service for $name {
                const PACKAGE: &'static str = $package;
                const NAME: &'static str = stringify!($name);
                type Request = $request;
                type Response = $response;
            }
        )+
    };
}
use services;

#[cfg(test)]
mod tests;
