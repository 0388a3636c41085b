//! What can be wrong with how vehicles are reached over DDS.
//!
//! Must never do: open a socket to find out.

use crate::problem::Problem;
use crate::settings::NodeConfig;
use std::net::IpAddr;

impl NodeConfig {
    pub(super) fn dds_problems(&self, problems: &mut Vec<Problem>) {
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
        let here_alone = self.dds.interfaces.iter().all(IpAddr::is_loopback);
        for (at, peer) in self.dds.peers.iter().enumerate() {
            if here_alone && !peer.address.is_loopback() {
                let message = "is another computer, which hears nothing while dds.interfaces names this one alone";
                wrong(format!("dds.peers[{at}]"), message);
            }
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
