//! The hash that ROS 2 gives a type (RIHS01), from the fields of a message: writers of ROS 2 nodes carry it in discovery. PX4's agent does not.
//!
//! Must never do: be needed. Where there is no hash, size and content of the samples decide.

use crate::messages::{Field, Kind};
use sha2::{Digest, Sha256};
use std::fmt::Write;

/// What stands in front of the hash in the user data of a writer or reader.
const KEY: &str = "typehash=";

/// The hash of a message of `px4_msgs`.
#[must_use]
pub fn of_px4(name: &str, fields: &[Field]) -> String {
    of(&format!("px4_msgs/msg/{name}"), fields)
}

/// The hash of a message of any package, its name written with the package.
#[must_use]
pub fn of(name: &str, fields: &[Field]) -> String {
    let fields: Vec<String> = fields.iter().map(description).collect();
    let fields = fields.join(", ");
    let description = format!(
        "{{\"type_description\": {{\"type_name\": \"{name}\", \"fields\": [{fields}]}}, \"referenced_type_descriptions\": []}}"
    );
    let mut text = String::from("RIHS01_");
    for octet in Sha256::digest(description.as_bytes()) {
        // Writing to a string cannot fail.
        let _ = write!(text, "{octet:02x}");
    }
    text
}

/// The hash in the user data of a writer or reader, if there is one.
#[must_use]
pub fn announced(user_data: &[u8]) -> Option<String> {
    let text = String::from_utf8_lossy(user_data);
    let mut parts = text.split(';').filter_map(|part| part.trim().strip_prefix(KEY));
    // A writer that is not of ROS 2's own code may carry the mark for "not known".
    parts
        .next()
        .filter(|hash| hash.starts_with("RIHS01_"))
        .map(str::to_owned)
}

fn description(field: &Field) -> String {
    let number = match field.kind {
        Kind::U8 => 3,
        Kind::U16 => 5,
        Kind::I32 => 6,
        Kind::U32 => 7,
        Kind::I64 => 8,
        Kind::U64 => 9,
        Kind::F32 => 10,
        Kind::F64 => 11,
        Kind::Bool => 15,
    };
    // Arrays of fixed size are numbered 48 above their elements.
    let (number, capacity) = match field.elements {
        None => (number, 0),
        Some(elements) => (number + 48, elements),
    };
    let name = field.name;
    format!(
        "{{\"name\": \"{name}\", \"type\": {{\"type_id\": {number}, \"capacity\": {capacity}, \"string_capacity\": 0, \"nested_type_name\": \"\"}}}}"
    )
}

#[cfg(test)]
mod tests {
    //! Against hashes that ROS 2 itself gives to messages of its own.

    use super::*;

    #[test]
    fn the_hashes_are_those_of_ros_2() {
        let field = |name, kind, elements| Field { name, kind, elements };
        let axes = [
            field("x", Kind::F64, None),
            field("y", Kind::F64, None),
            field("z", Kind::F64, None),
        ];
        assert_eq!(
            of("geometry_msgs/msg/Vector3", &axes),
            "RIHS01_cc12fe83e4c02719f1ce8070bfd14aecd40f75a96696a67a2a1f37f7dbb0765d"
        );
        assert_eq!(
            of("unique_identifier_msgs/msg/UUID", &[field("uuid", Kind::U8, Some(16))]),
            "RIHS01_1b8e8aca958cbea28fe6ef60bf6c19b683c97a9ef60bb34752067d0f2f7ab437"
        );
    }

    #[test]
    fn only_a_hash_is_taken_for_one() {
        let hash = "RIHS01_cc12";
        assert_eq!(
            announced(format!("enclave=/;typehash={hash};").as_bytes()),
            Some(hash.to_owned())
        );
        assert_eq!(announced(b"typehash=INVALID;"), None);
        assert_eq!(announced(b""), None);
        assert_eq!(announced(&[0xFF, 0, 0x3B]), None);
    }
}
