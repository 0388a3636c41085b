//! Samples of any definition made from its table of fields, for tests: values by name, the rest zero.
//!
//! Must never do: be used outside of tests.
#![allow(dead_code, reason = "not every test needs all of it")]

use crate::definitions::{self, Definition, Release, Topic};
use crate::messages::{Field, Kind};
use crate::naming::{Direction, Namespace, TopicName};

/// The octets of a message.
pub fn bytes(fields: &[Field], values: &[(&str, &[f64])]) -> Vec<u8> {
    let mut out = Vec::new();
    for field in fields {
        let given = values
            .iter()
            .find(|(name, _)| *name == field.name)
            .map(|(_, value)| *value);
        let size = field.kind.size_bytes();
        out.resize(out.len().div_ceil(size) * size, 0);
        for i in 0..field.elements.unwrap_or(1) {
            let value = given.and_then(|value| value.get(i)).copied().unwrap_or(0.0);
            match field.kind {
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
    }
    out
}

/// The definition of a topic in a release.
pub fn definition(topic: Topic, release: Release) -> &'static Definition {
    let mut all = definitions::DEFINITIONS.iter();
    all.find(|d| d.topic == topic && d.releases.contains(&release))
        .expect("each release has each topic")
}

/// The name of a topic in a release, of the first instance.
pub fn name(topic: Topic, release: Release) -> TopicName {
    TopicName {
        namespace: Namespace::default(),
        direction: Direction::Out,
        base: topic.base().to_owned(),
        version: definition(topic, release).version,
    }
}

/// A good sample.
pub fn sample(topic: Topic, release: Release, stamp_us: u64) -> Vec<u8> {
    let stamp = [stamp_us as f64];
    let common: &[(&str, &[f64])] = &[("timestamp", &stamp), ("timestamp_sample", &stamp)];
    let own: &[(&str, &[f64])] = match topic {
        Topic::Status => &[
            ("system_id", &[7.0]),
            ("arming_state", &[1.0]),
            ("nav_state", &[4.0]),
            ("pre_flight_checks_pass", &[1.0]),
        ],
        Topic::LocalPosition => &[
            ("xy_valid", &[1.0]),
            ("z_valid", &[1.0]),
            ("v_xy_valid", &[1.0]),
            ("v_z_valid", &[1.0]),
            ("x", &[3.0]),
        ],
        Topic::Attitude => &[("q", &[1.0, 0.0, 0.0, 0.0])],
        Topic::LandDetected => &[("landed", &[1.0])],
        _ => &[],
    };
    let values: Vec<_> = common.iter().chain(own).copied().collect();
    bytes(definition(topic, release).fields, &values)
}
