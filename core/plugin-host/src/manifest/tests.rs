//! Which manifests are taken.

use super::*;

fn good() -> PluginManifest {
    PluginManifest {
        name: "test-uav".to_owned(),
        version: "1.2.3".to_owned(),
        description: "For tests.".to_owned(),
        config_schema_json: "{}".to_owned(),
        effects: vec![EffectKind::Setpoint.code(), EffectKind::State.code()],
        ..PluginManifest::default()
    }
}

fn decode(manifest: &PluginManifest) -> Result<Manifest, LoadError> {
    Manifest::decode(PluginKind::UAV_MODEL, &minicbor::to_vec(manifest).expect("encodes"))
}

#[test]
fn a_good_manifest_is_taken() {
    let manifest = decode(&good()).expect("is right");
    assert_eq!(
        manifest.effects,
        BTreeSet::from([EffectKind::Setpoint, EffectKind::State])
    );
    let json = serde_json::to_value(&manifest).expect("serialises");
    assert_eq!(json["kind"], "uav_model");
    assert_eq!(json["effects"][0], "setpoint");
}

#[test]
fn a_bad_manifest_is_refused_with_what_is_wrong() {
    type Change = fn(&mut PluginManifest);
    let cases: &[(Change, &str)] = &[
        (|m| m.name.clear(), "the name"),
        (|m| m.name = "Upper Case".to_owned(), "the name"),
        (|m| m.name = "x".repeat(65), "the name"),
        (|m| m.version.clear(), "the version"),
        (|m| m.version = "1\n2".to_owned(), "the version"),
        (|m| m.description = " ".to_owned(), "description"),
        (|m| m.config_schema_json = "[]".to_owned(), "not a JSON object"),
        (|m| m.config_schema_json = "{".to_owned(), "not JSON"),
        (|m| m.effects.push(77), "effect 77"),
        (|m| m.description = "x".repeat(2 << 20), "bytes"),
    ];
    for (change, said) in cases {
        let mut manifest = good();
        change(&mut manifest);
        let error = decode(&manifest).expect_err("is not right").to_string();
        assert!(error.contains(said), "{error:?} does not say {said:?}");
    }
    assert!(matches!(
        Manifest::decode(PluginKind::UAV_MODEL, b"garbage"),
        Err(LoadError::BadManifest { .. })
    ));
}
