//! What is wrong about DDS and links is named.

use crate::{LinkKind, NodeConfig};

fn problems(text: &str) -> Vec<String> {
    let config: NodeConfig = toml::from_str(text).expect("it parses");
    config.problems().iter().map(ToString::to_string).collect()
}

#[test]
fn values_that_cannot_be_are_named() {
    for (text, key) in [
        ("[dds]\ndomain_id = 102", "dds.domain_id"),
        ("[dds]\ninterfaces = []", "dds.interfaces"),
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
    assert!(!plain.flies_over_dds());
    let both = of("[[adopt]]\nlinks = [\"dds\", \"mavlink\"]");
    assert!(both.flies_over_dds());
    assert!(problems("[[adopt]]\nlinks = [\"dds\", \"mavlink\"]").is_empty());
}
