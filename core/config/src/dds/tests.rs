//! What is wrong about DDS and links is named.

use crate::{DdsPeer, DdsPeerError, LinkKind, NodeConfig};
use proptest::prelude::{any, proptest};

fn problems(text: &str) -> Vec<String> {
    let config: NodeConfig = toml::from_str(text).expect("it parses");
    config.problems().iter().map(ToString::to_string).collect()
}

#[test]
fn values_that_cannot_be_are_named() {
    for (text, key) in [
        ("[dds]\ndomain_id = 102", "dds.domain_id"),
        ("[dds]\ninterfaces = []", "dds.interfaces"),
        ("[dds]\npeers = [\"127.0.0.1\", \"10.0.0.7\"]", "dds.peers[1]"),
        ("[[adopt]]\nlinks = []", "adopt[0].links"),
        ("[[adopt]]\n[[adopt]]\nlinks = [\"dds\", \"dds\"]", "adopt[1].links"),
    ] {
        let all = problems(text);
        assert!(all.iter().any(|line| line.starts_with(key)), "{text}: {all:?}");
    }
}

#[test]
fn a_vehicle_is_flown_over_mavlink_unless_its_rule_says_otherwise() {
    let of = |text: &str| toml::from_str::<NodeConfig>(text).expect("it parses");
    let plain = of("[[adopt]]");
    assert_eq!(
        plain.adopt.first().map(|rule| rule.links.clone()),
        Some(vec![LinkKind::Mavlink])
    );
    assert!(!plain.flies_over_dds() && plain.hears_nobody());
    let both = of("[[adopt]]\nlinks = [\"dds\", \"mavlink\"]");
    assert!(both.flies_over_dds() && !both.hears_nobody());
    assert!(problems("[[adopt]]\nlinks = [\"dds\", \"mavlink\"]").is_empty());
}

#[test]
fn peers_are_hosts_or_single_participants() {
    let text = "[dds]\ninterfaces = [\"10.0.0.5\"]\npeers = [\"10.0.0.7\", \"10.0.0.8:7412\", \"127.0.0.1\"]";
    assert_eq!(problems(text), Vec::<String>::new());
    let config: NodeConfig = toml::from_str(text).expect("it parses");
    let peer = |address: [u8; 4], port| DdsPeer {
        address: address.into(),
        port,
    };
    let expected = [
        peer([10, 0, 0, 7], None),
        peer([10, 0, 0, 8], Some(7412)),
        peer([127, 0, 0, 1], None),
    ];
    assert_eq!(config.dds.peers, expected);
}

#[test]
fn what_is_no_peer_is_refused_with_the_reason() {
    let refused = |text: &str| text.parse::<DdsPeer>().unwrap_err();
    for text in [
        "",
        "ground-station",
        "10.0.0",
        "10.0.0.7:",
        "10.0.0.7:x",
        "10.0.0.7:65536",
        ":7412",
    ] {
        assert_eq!(refused(text), DdsPeerError::NoAddress(text.into()));
    }
    for text in ["::1", "[fd00::7]", "[fd00::7]:7412", "fe80::1%wlan0"] {
        assert_eq!(refused(text), DdsPeerError::Ipv6(text.into()));
    }
    for text in ["0.0.0.0", "239.255.0.1", "255.255.255.255:7412"] {
        assert_eq!(refused(text), DdsPeerError::NotOneHost(text.into()));
    }
    assert_eq!(refused("10.0.0.7:0"), DdsPeerError::PortZero("10.0.0.7:0".into()));
    let told = toml::from_str::<NodeConfig>("[dds]\npeers = [\"fd00::7\"]").unwrap_err();
    assert!(told.to_string().contains("DDS speaks IPv4 here"), "{told}");
}

proptest! {
    #[test]
    fn a_peer_is_read_as_it_is_written(address in any::<[u8; 4]>(), port in any::<Option<u16>>()) {
        let peer = DdsPeer { address: address.into(), port };
        if let Ok(read) = peer.to_string().parse::<DdsPeer>() {
            assert_eq!(read, peer);
        }
    }

    #[test]
    fn whatever_is_written_there_does_no_harm(text in any::<String>()) {
        let _ = text.parse::<DdsPeer>();
    }
}
