//! `[dds]`: where this node is in DDS, and over which links a vehicle is flown.
//!
//! Must never do: join DDS.

use crate::{NodeConfig, Problem};
use serde::{Deserialize, Serialize};
use std::net::{IpAddr, Ipv4Addr};

/// `[dds]`
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DdsSettings {
    /// DDS domain: what `ROS_DOMAIN_ID` is elsewhere.
    pub domain_id: u16,
    /// Addresses of this computer's interfaces whose networks are used.
    pub interfaces: Vec<IpAddr>,
}

impl Default for DdsSettings {
    fn default() -> Self {
        Self {
            domain_id: 0,
            interfaces: vec![IpAddr::V4(Ipv4Addr::LOCALHOST)],
        }
    }
}

/// What carries commands and setpoints to a vehicle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LinkKind {
    /// MAVLink over an endpoint.
    Mavlink,
    /// DDS, through PX4's uXRCE-DDS agent.
    Dds,
}

impl std::fmt::Display for LinkKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Mavlink => "MAVLink",
            Self::Dds => "DDS",
        })
    }
}

impl NodeConfig {
    /// Whether vehicles are looked for on DDS.
    #[must_use]
    pub fn flies_over_dds(&self) -> bool {
        self.adopt.iter().any(|rule| rule.links.contains(&LinkKind::Dds))
    }

    pub(crate) fn dds_problems(&self, problems: &mut Vec<Problem>) {
        let mut wrong = |key: String, message: &str| {
            problems.push(Problem {
                key,
                message: message.into(),
            });
        };
        if self.dds.domain_id > 101 {
            wrong("dds.domain_id".into(), "is not between 0 and 101");
        }
        if self.dds.interfaces.is_empty() {
            wrong(
                "dds.interfaces".into(),
                "name one at least: DDS would take none for all",
            );
        }
        for (at, rule) in self.adopt.iter().enumerate() {
            let twice = rule.links.first() == rule.links.get(1);
            if rule.links.is_empty() || rule.links.len() > 2 || twice {
                let message = "name one of \"mavlink\" and \"dds\", or both, the one that flies first";
                wrong(format!("adopt[{at}].links"), message);
            }
        }
    }
}

#[cfg(test)]
mod tests;
