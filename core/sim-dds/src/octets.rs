//! Samples made from a message's table of fields: what is known by name, the rest zero; plain CDR, least significant octet first.
//!
//! Must never do: use the code that reads samples. That is what is to be tested with them.

use serde::ser::{Serialize, SerializeTuple, Serializer};
use skein_link_dds::messages::{Field, Kind};

/// Most elements of an array that anything is known of.
const ELEMENTS: usize = 4;

/// What is known of a message: values by the names of its fields. Whole numbers fit, up to 2⁵³: stamps until the year 2255.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Record(Vec<(&'static str, [f64; ELEMENTS])>);

impl Record {
    /// A field, or the elements of one that is an array.
    pub fn with<const N: usize>(mut self, name: &'static str, values: [f64; N]) -> Self {
        let mut all = [0.0; ELEMENTS];
        all.iter_mut().zip(values).for_each(|(to, from)| *to = from);
        self.0.push((name, all));
        self
    }

    /// Several fields.
    pub fn and<const N: usize>(mut self, fields: [(&'static str, f64); N]) -> Self {
        self.0
            .extend(fields.map(|(name, value)| (name, [value, 0.0, 0.0, 0.0])));
        self
    }

    #[cfg(test)]
    pub fn names(&self) -> impl Iterator<Item = &'static str> {
        self.0.iter().map(|(name, _)| *name)
    }

    fn value(&self, name: &str, element: usize) -> f64 {
        let found = self.0.iter().find(|(known, _)| *known == name);
        found
            .and_then(|(_, values)| values.get(element))
            .copied()
            .unwrap_or(0.0)
    }
}

/// A sample, as it goes out.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Octets(pub Vec<u8>);

/// As they are, without a length before them: in CDR that is what a tuple of octets is.
impl Serialize for Octets {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut tuple = serializer.serialize_tuple(self.0.len())?;
        for octet in &self.0 {
            tuple.serialize_element(octet)?;
        }
        tuple.end()
    }
}

/// The sample of a message with these fields. What the record has beyond them is left out.
pub(crate) fn sample(fields: &[Field], record: &Record) -> Octets {
    let mut out = Vec::new();
    for field in fields {
        let size = field.kind.size_bytes();
        out.resize(out.len().div_ceil(size) * size, 0);
        for element in 0..field.elements.unwrap_or(1) {
            write(&mut out, field.kind, record.value(field.name, element));
        }
    }
    Octets(out)
}

fn write(out: &mut Vec<u8>, kind: Kind, value: f64) {
    match kind {
        Kind::Bool | Kind::U8 => out.push(value as u8),
        Kind::U16 => out.extend((value as u16).to_le_bytes()),
        Kind::U32 => out.extend((value as u32).to_le_bytes()),
        Kind::I32 => out.extend((value as i32).to_le_bytes()),
        Kind::U64 => out.extend((value as u64).to_le_bytes()),
        Kind::I64 => out.extend((value as i64).to_le_bytes()),
        Kind::F32 => out.extend((value as f32).to_le_bytes()),
        Kind::F64 => out.extend(value.to_le_bytes()),
    }
}
