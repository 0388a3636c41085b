//! Sets of MAVLink system ids as people write them: `"1-20,25"`.

use serde::{Deserialize, Deserializer, Serialize, Serializer};
use skein_domain::SystemId;
use std::fmt;
use std::str::FromStr;

/// A set of system ids, written as single ids and ranges: `"1-20,25"`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SystemIdSet(Vec<(u8, u8)>);

impl SystemIdSet {
    /// Every id there is.
    #[must_use]
    pub fn all() -> Self {
        Self(vec![(1, 255)])
    }

    /// Only this one.
    #[must_use]
    pub fn one(id: SystemId) -> Self {
        Self(vec![(id.0, id.0)])
    }

    /// Whether the id is in the set.
    #[must_use]
    pub fn contains(&self, id: SystemId) -> bool {
        self.0.iter().any(|(low, high)| (*low..=*high).contains(&id.0))
    }
}

impl FromStr for SystemIdSet {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |part: &str| {
            part.trim().parse::<u8>().ok().filter(|id| *id > 0).ok_or_else(|| {
                format!(
                    "\"{}\" is not a system id (1 to 255) in \"{text}\"; write for example \"1-20,25\"",
                    part.trim()
                )
            })
        };
        text.split(',')
            .map(|part| {
                let (low, high) = match part.split_once('-') {
                    Some((low, high)) => (number(low)?, number(high)?),
                    None => (number(part)?, number(part)?),
                };
                if low <= high {
                    Ok((low, high))
                } else {
                    Err(format!("the range \"{part}\" runs backwards"))
                }
            })
            .collect::<Result<_, _>>()
            .map(Self)
    }
}

impl fmt::Display for SystemIdSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, (low, high)) in self.0.iter().enumerate() {
            let comma = if i > 0 { "," } else { "" };
            if low == high {
                write!(f, "{comma}{low}")?
            } else {
                write!(f, "{comma}{low}-{high}")?
            }
        }
        Ok(())
    }
}

impl<'de> Deserialize<'de> for SystemIdSet {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        String::deserialize(deserializer)?
            .parse()
            .map_err(serde::de::Error::custom)
    }
}

impl Serialize for SystemIdSet {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}
