//! What is judged without an instance: lengths, counts, and the memory of what was found right.

use super::*;
use skein_domain::exchange::{EffectBatch, Severity};
use skein_domain::manifest::{EffectKind, PluginManifest};
use skein_plugin_abi::PluginKind;

fn manifest() -> Manifest {
    let manifest = PluginManifest {
        name: "test".to_owned(),
        version: "1".to_owned(),
        description: "For tests.".to_owned(),
        config_schema_json: "{}".to_owned(),
        effects: [EffectKind::Report, EffectKind::Notice].map(EffectKind::code).to_vec(),
        state_schema_json: Some(r#"{"type": "integer"}"#.to_owned()),
        ..PluginManifest::default()
    };
    Manifest::decode(PluginKind::GIMBAL, &minicbor::to_vec(manifest).expect("encodes")).expect("is right")
}

fn judge(effects: Vec<Effect>) -> Result<Vec<Effect>, PluginError> {
    let judge = Judge::new(RunnerSettings::default());
    let bytes = minicbor::to_vec(EffectBatch { effects }).expect("encodes");
    judge
        .effects(&manifest(), &Pool::new(false), EFFECT_BATCH_SCHEMA, &bytes)
        .map(|(effects, _)| effects)
}

fn report(state_json: &str) -> Effect {
    Effect::Report {
        state_json: state_json.to_owned(),
    }
}

fn notice() -> Effect {
    Effect::Notice {
        severity: Severity::Info,
        text: "this".to_owned(),
    }
}

#[test]
fn a_batch_is_taken_as_a_whole_or_not_at_all() {
    let good = vec![notice(), report("3")];
    assert_eq!(judge(good.clone()), Ok(good));
    let error = judge(vec![notice(), report("\"three\"")]).expect_err("is not right");
    assert!(
        matches!(error, PluginError::SchemaViolation { what: "a state", .. }),
        "{error}"
    );
    assert!(error.to_string().contains("three"), "{error}");
    let error = judge(vec![notice(), Effect::StopStream]).expect_err("is not in the manifest");
    assert_eq!(
        error,
        PluginError::NotPermitted {
            effect: EffectKind::StopStream
        }
    );
    assert!(matches!(
        judge(vec![notice(); 201]),
        Err(PluginError::TooManyEffects { count: 201, limit: 200 })
    ));
}

#[test]
fn a_frame_that_the_manifest_does_not_name_is_not_taken() {
    let error = judge(vec![Effect::Frame(Default::default())]).expect_err("is not in the manifest");
    assert_eq!(
        error,
        PluginError::NotPermitted {
            effect: EffectKind::Frame
        }
    );
}

#[test]
fn what_was_found_right_is_not_looked_at_again() {
    let last = Mutex::default();
    let mut looks = 0;
    let mut look = |json: &str, right: bool| {
        once(&last, "a state", json, |_| {
            looks += 1;
            right.then_some(()).ok_or(SchemaError::NoSchema)
        })
    };
    assert!(look("1", true).is_ok());
    assert!(look("1", false).is_ok(), "it is the same text");
    assert!(look("2", false).is_err());
    assert!(look("2", false).is_err(), "what was wrong stays wrong");
    assert!(look("1", false).is_ok(), "and does not push out what was right");
    assert!(look("", false).is_err(), "nothing is no text that was found right");
    assert_eq!(looks, 4);
}

#[test]
fn too_long_is_said_with_the_lengths() {
    let judge = Judge::new(RunnerSettings {
        max_answer_bytes: 10,
        max_snapshot_bytes: 5,
        ..RunnerSettings::default()
    });
    let answer = judge.effects(&manifest(), &Pool::new(false), EFFECT_BATCH_SCHEMA, &[0; 11]);
    assert_eq!(answer.err(), Some(PluginError::TooLarge { len: 11, limit: 10 }));
    assert_eq!(judge.snapshot(&[1; 6]), Err(PluginError::TooLarge { len: 6, limit: 5 }));
    assert_eq!(judge.snapshot(&[1; 5]), Ok(vec![1; 5]));
    let other = judge.effects(&manifest(), &Pool::new(false), 9, &[]);
    assert!(matches!(other, Err(PluginError::Undecodable { .. })));
}
