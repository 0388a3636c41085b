//! Who is told of this node by name, and on which ports participants hear of others.
//!
//! Must never do: send anything.

use std::net::{Ipv4Addr, SocketAddrV4};

/// So many participants of a host are called if no port is named: those with the ids from zero on.
pub const CALLED_PER_HOST: u16 = 32;
/// So many of them are called often: most hosts have no more.
pub(crate) const CALLED_OFTEN: u16 = 4;

/// A host, or one participant on it, that is told of this node. DDS' unicast here is IPv4 alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Peer {
    /// Its address.
    pub address: Ipv4Addr,
    /// The port on which one participant hears of others; without it, those of the first [`CALLED_PER_HOST`] participants.
    pub port: Option<u16>,
}

impl Peer {
    /// Whether there can be such a one: an address of one host, and no port zero.
    #[must_use]
    pub fn can_be(&self) -> bool {
        let of_one = !self.address.is_unspecified() && !self.address.is_multicast() && !self.address.is_broadcast();
        of_one && self.port != Some(0)
    }

    /// Where it is called in a domain: so many participants at most.
    pub(crate) fn places(self, domain_id: u16, most: u16) -> impl Iterator<Item = SocketAddrV4> {
        let named = self.port.into_iter();
        let usual = (0..most)
            .filter(move |_| self.port.is_none())
            .map(move |id| discovery_port(domain_id, id));
        named
            .chain(usual)
            .map(move |port| SocketAddrV4::new(self.address, port))
    }
}

/// The port on which a participant hears of others, by the rule that all of RTPS has.
#[must_use]
pub(crate) fn discovery_port(domain_id: u16, participant_id: u16) -> u16 {
    multicast_ports(domain_id)[0] + 10 + 2 * participant_id
}

/// The ports of a domain's multicast: of discovery, and of everything else.
#[must_use]
pub(crate) fn multicast_ports(domain_id: u16) -> [u16; 2] {
    let first = 7400 + 250 * domain_id;
    [first, first + 1]
}

#[cfg(test)]
mod tests {
    use super::{CALLED_PER_HOST, Peer, discovery_port};
    use std::net::Ipv4Addr;

    #[test]
    fn ports_are_those_of_the_rule() {
        assert_eq!(discovery_port(0, 0), 7410);
        assert_eq!(discovery_port(7, 3), 7400 + 1750 + 10 + 6);
        // The last of them in the last domain is still a port.
        assert_eq!(discovery_port(crate::LAST_DOMAIN_ID, 119), 32_898);
    }

    #[test]
    fn a_host_has_many_places_and_a_named_port_is_one() {
        let address = Ipv4Addr::new(10, 0, 0, 7);
        let all = Peer { address, port: None };
        let all: Vec<String> = all.places(1, CALLED_PER_HOST).map(|at| at.to_string()).collect();
        assert_eq!(
            (all.len(), all[0].as_str(), all[31].as_str()),
            (32, "10.0.0.7:7660", "10.0.0.7:7722")
        );
        let one = Peer {
            address,
            port: Some(7412),
        };
        let one: Vec<String> = one.places(1, CALLED_PER_HOST).map(|at| at.to_string()).collect();
        assert_eq!(one, ["10.0.0.7:7412"]);
    }

    #[test]
    fn what_is_no_host_can_not_be() {
        let peer = |address: [u8; 4], port| Peer {
            address: address.into(),
            port,
        };
        assert!(peer([10, 0, 0, 7], None).can_be() && peer([127, 0, 0, 1], Some(1)).can_be());
        for none in [[0; 4], [239, 255, 0, 1], [255; 4]] {
            assert!(!peer(none, None).can_be(), "{none:?}");
        }
        assert!(!peer([10, 0, 0, 7], Some(0)).can_be());
    }
}
