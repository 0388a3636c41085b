//! The documented default is the default; unknown keys and senseless values are refused by name.

use super::*;
use proptest::prelude::*;

#[test]
fn the_documented_default_is_the_default() {
    assert_eq!(NodeConfig::parse(DEFAULT_TOML).expect("parses"), NodeConfig::default());
}

#[test]
fn every_key_is_documented() {
    let table = toml::Table::try_from(NodeConfig::default()).expect("serialises");
    for (section, value) in &table {
        let Some(keys) = value.as_table() else {
            assert!(
                DEFAULT_TOML.contains(&format!("[[{section}]]")),
                "[[{section}]] is not documented"
            );
            continue;
        };
        assert_documented(section, keys);
    }
}

fn assert_documented(section: &str, keys: &toml::Table) {
    for (key, value) in keys {
        let nested = format!("{section}.{key}");
        if let Some(keys) = value.as_table() {
            assert!(
                DEFAULT_TOML.contains(&format!("[{nested}]")),
                "[{nested}] is not documented"
            );
            assert_documented(&nested, keys);
        } else {
            assert!(DEFAULT_TOML.contains(&format!("{key} =")), "{nested} is not documented");
        }
    }
}

#[test]
fn the_commented_examples_parse_too() {
    let uncommented: String = DEFAULT_TOML
        .lines()
        .map(|line| {
            let bare = line.strip_prefix("# ").unwrap_or(line);
            let is_example = bare.starts_with('[') || bare.split_once(" = ").is_some_and(|(k, _)| !k.contains(' '));
            format!("{}\n", if is_example { bare } else { line })
        })
        .collect();
    let config = NodeConfig::parse(&uncommented).expect("parses");
    assert_eq!(config.endpoints.len(), 1);
    assert_eq!(config.adopt.len(), 1);
    assert!(config.safety.fence.is_some() && config.swarm.origin.is_some() && config.swarm.id.is_some());
    assert_eq!(config.safety.zones.len(), 1);
}

#[test]
fn an_unknown_key_is_named() {
    let error = NodeConfig::parse("[node]\nnmae = \"x\"\n")
        .expect_err("refused")
        .to_string();
    assert!(error.contains("nmae"), "{error}");
    assert!(error.contains("line 2"), "{error}");
}

#[test]
fn a_key_that_has_another_name_now_is_refused_with_it() {
    let old = concat!("[safety.lad", "der.gnss_loss]\nmode = \"warn_only\"\n");
    let error = NodeConfig::parse(old).expect_err("refused").to_string();
    assert!(error.contains("is called safety.failsafe"), "{error}");
}

#[test]
fn all_senseless_values_are_listed() {
    let error = NodeConfig::parse(
        "[node]\ncontrol_rate_hz = nan\n[link]\nown_system_id = 0\n[[adopt]]\nendpoint = \"nowhere\"\n",
    )
    .expect_err("refused")
    .to_string();
    for part in ["node.control_rate_hz", "link.own_system_id", "adopt[0].endpoint"] {
        assert!(error.contains(part), "{part} missing in {error}");
    }
}

#[test]
fn system_ids_are_read_as_people_write_them() {
    let set: SystemIdSet = "1-3, 7".parse().expect("parses");
    let inside: Vec<u8> = (1..=10)
        .filter(|id| set.contains(skein_domain::SystemId(*id)))
        .collect();
    assert_eq!(inside, [1, 2, 3, 7]);
    for wrong in ["", "0", "5-2", "300", "a-b"] {
        assert!(wrong.parse::<SystemIdSet>().is_err(), "{wrong}");
    }
}

proptest! {
    #[test]
    fn no_text_makes_it_panic(text in "\\PC*") {
        let _ = NodeConfig::parse(&text);
    }
}
