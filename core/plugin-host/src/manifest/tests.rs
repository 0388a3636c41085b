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
fn the_schemas_are_compiled_and_used() {
    let manifest = PluginManifest {
        config_schema_json: r#"{"type": "object", "properties": {"speed": {"type": "number", "minimum": 0}}}"#
            .to_owned(),
        command_schema_json: Some(r#"{"enum": ["on", "off"]}"#.to_owned()),
        state_schema_json: Some(r##"{"$ref": "#/$defs/count", "$defs": {"count": {"type": "integer"}}}"##.to_owned()),
        ..good()
    };
    let manifest = decode(&manifest).expect("is right");
    assert!(manifest.check_config(r#"{"speed": 3}"#).is_ok());
    let error = manifest.check_config(r#"{"speed": -3}"#).expect_err("is not right");
    assert!(
        matches!(&error, SchemaError::Violated { path, .. } if path == "/speed"),
        "{error:?}"
    );
    assert_eq!(error.to_string(), "at /speed: -3 is less than the minimum of 0");
    assert!(
        manifest
            .check_config("3")
            .expect_err("is no object")
            .to_string()
            .starts_with("at the top: ")
    );
    assert!(matches!(manifest.check_config("{"), Err(SchemaError::NotJson { .. })));
    assert!(manifest.check_command("\"on\"").is_ok() && manifest.check_command("\"up\"").is_err());
    assert!(manifest.check_state("3").is_ok() && manifest.check_state("3.5").is_err());
    assert_eq!(manifest.check_event("3"), Err(SchemaError::NoSchema));
    let long = manifest
        .check_command(&format!("\"{}\"", "ä".repeat(5_000)))
        .expect_err("is none");
    assert!(long.to_string().len() < 500);
}

#[test]
fn effects_go_by_the_kind_of_plugin() {
    let taken = |kind, effect: EffectKind| {
        let manifest = PluginManifest {
            effects: vec![effect.code()],
            ..good()
        };
        Manifest::decode(kind, &minicbor::to_vec(manifest).expect("encodes"))
    };
    for effect in EffectKind::ALL.iter().copied() {
        for (kind, may) in [
            (PluginKind::UAV_MODEL, effect.is_for_uav_models()),
            (
                PluginKind::GIMBAL,
                effect.is_for_payloads() && effect != EffectKind::Frame,
            ),
            (
                PluginKind::DETECTOR,
                effect.is_for_payloads() && effect != EffectKind::Frame,
            ),
            (PluginKind::CAMERA, effect.is_for_payloads()),
        ] {
            match taken(kind, effect) {
                Ok(manifest) => assert!(may && manifest.effects.contains(&effect), "{kind} {effect}"),
                Err(error) => {
                    assert!(!may, "{kind} {effect}: {error}");
                    let said = format!("a {kind} plugin may not have the effect {effect}");
                    assert!(error.to_string().contains(&said), "{error}");
                }
            }
        }
    }
    assert!(
        taken(PluginKind::CAMERA, EffectKind::Setpoint).is_err(),
        "a camera cannot steer"
    );
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
        (|m| m.config_schema_json = r#"{"type": 3}"#.to_owned(), "is none"),
        (
            |m| m.config_schema_json = r#"{"$ref": "https://example.org/s.json"}"#.to_owned(),
            "is none",
        ),
        (
            |m| m.state_schema_json = Some("[]".to_owned()),
            "the schema of the state",
        ),
        (
            |m| m.command_schema_json = Some("x".to_owned()),
            "the schema of the commands",
        ),
        (|m| m.event_schema_json = Some("x".repeat(300_000)), "300000 bytes"),
        (|m| m.tick_rate_hz = Some(201), "201 calls per second"),
        (|m| m.mavlink_messages = Some(vec![1 << 24]), "16777216 is no id"),
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
