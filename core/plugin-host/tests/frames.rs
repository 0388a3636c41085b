//! Frames through real instances, in both isolations: from the plugin's pen to a reader's eye, and back to the pool.

#[path = "host/orders.rs"]
mod orders;

use orders::{camera, create, events, runners, told, transmitted, ways};
use skein_domain::exchange::{Effect, Event};
use skein_domain::manifest::EffectKind;
use skein_plugin_host::{Instance, Isolation, PluginError, Runners};
use std::time::Duration;

const SIZE_BYTES: usize = 64 * 64;
/// Slots of an instance.
const SLOTS: usize = 4;

async fn started(runners: &Runners, isolation: Isolation) -> Instance {
    runners
        .create(camera(), isolation, create("{}", None))
        .await
        .expect("is created")
}

fn picture(brightness: u8) -> String {
    format!(r#"{{"do": "picture", "brightness": {brightness}}}"#)
}

#[tokio::test]
async fn what_one_instance_draws_another_reads() {
    let runners = runners(Duration::from_secs(10));
    for (from, to) in ways().into_iter().flat_map(|from| ways().map(|to| (from, to))) {
        let (draws, reads) = (started(&runners, from).await, started(&runners, to).await);
        let mut frames = Vec::new();
        for brightness in 1..=2 {
            let mut answer = told(&draws, &picture(brightness)).await.expect("answers");
            assert!(answer.effects.iter().all(|effect| effect.kind() != EffectKind::Frame));
            assert_eq!(answer.frames.len(), 1);
            frames.append(&mut answer.frames);
        }
        assert_ne!(frames[0].header.id, frames[1].header.id);
        for (brightness, frame) in (1..).zip(&frames) {
            assert_eq!(frame.bytes(), [brightness; SIZE_BYTES]);
            assert_eq!(frame.header.len, SIZE_BYTES as u64);
            let seen = Event::Frame(frame.header.clone());
            let answer = reads.call(events(vec![seen]), &frames).await.expect("answers");
            let sum = SIZE_BYTES * usize::from(brightness);
            assert_eq!(transmitted(&answer.effects), format!("Some({sum})").into_bytes());
        }
        // Not handed over with this call.
        let seen = Event::Frame(frames[0].header.clone());
        let answer = reads.call(events(vec![seen]), &[]).await.expect("answers");
        assert_eq!(transmitted(&answer.effects), b"None");
        // It can be read when its painter is long gone.
        drop(draws);
        assert_eq!(frames[1].bytes()[SIZE_BYTES - 1], 2);
    }
}

#[tokio::test]
async fn slots_come_back_when_the_last_reader_has_gone() {
    let runners = runners(Duration::from_secs(10));
    for isolation in ways() {
        let instance = started(&runners, isolation).await;
        let mut held = Vec::new();
        for brightness in 0..SLOTS as u8 {
            held.append(&mut told(&instance, &picture(brightness)).await.expect("answers").frames);
        }
        assert_eq!(held.len(), SLOTS);
        let answer = told(&instance, &picture(9)).await.expect("answers");
        assert!(answer.frames.is_empty());
        assert_eq!(transmitted(&answer.effects), b"none", "all are in use");
        for (brightness, frame) in (0..).zip(&held) {
            assert_eq!(frame.bytes(), [brightness; SIZE_BYTES], "nobody wrote over it");
        }
        let shared = held.remove(1);
        let again = std::sync::Arc::clone(&shared);
        drop(shared);
        assert!(told(&instance, &picture(9)).await.expect("answers").frames.is_empty());
        drop(again);
        assert_eq!(
            told(&instance, &picture(9)).await.expect("answers").frames[0].bytes()[0],
            9
        );
    }
}

#[tokio::test]
async fn buffers_that_are_kept_or_given_back_are_not_given_away() {
    let runners = runners(Duration::from_secs(10));
    for isolation in ways() {
        let instance = started(&runners, isolation).await;
        for _ in 0..SLOTS {
            told(&instance, r#"{"do": "keep"}"#).await.expect("answers");
        }
        let answer = told(&instance, r#"{"do": "keep"}"#).await.expect("answers");
        assert_eq!(transmitted(&answer.effects), b"none");
        told(&instance, r#"{"do": "give_back"}"#).await.expect("answers");
        assert_eq!(told(&instance, &picture(1)).await.expect("answers").frames.len(), 1);
    }
}

#[tokio::test]
async fn frames_that_are_not_right_are_refused_and_their_slots_saved() {
    let runners = runners(Duration::from_secs(10));
    for isolation in ways() {
        let instance = started(&runners, isolation).await;
        for id in [0, 1, 4, 77, u64::MAX] {
            let error = told(&instance, &format!(r#"{{"do": "false_frame", "id": {id}}}"#)).await;
            assert!(matches!(error, Err(PluginError::BadFrame { .. })), "{id}: {error:?}");
        }
        for _ in 0..2 * SLOTS {
            let error = told(&instance, r#"{"do": "wrong_header"}"#)
                .await
                .expect_err("does not fit");
            assert!(
                matches!(error, PluginError::BadFrame { .. }) && !error.needs_restart(),
                "{error}"
            );
        }
        assert_eq!(told(&instance, &picture(1)).await.expect("answers").frames.len(), 1);
    }
}

#[tokio::test]
async fn reports_and_events_are_held_against_the_schemas() {
    let runners = runners(Duration::from_secs(10));
    for isolation in ways() {
        let instance = started(&runners, isolation).await;
        let say = |what: &str, json: &str| serde_json::json!({"do": what, "json": json}).to_string();
        for what in ["report", "tell"] {
            for _ in 0..2 {
                let answer = told(&instance, &say(what, r#"{"count": 3}"#)).await.expect("is right");
                assert!(
                    matches!(&answer.effects[0], Effect::Report { state_json: json } | Effect::Occurrence { event_json: json } if json == r#"{"count": 3}"#)
                );
            }
            for (json, said) in [
                (r#"{"count": "three"}"#, "/count"),
                (r#"{"count": -1}"#, "/count"),
                ("{}", "count"),
                ("{", "not JSON"),
            ] {
                let error = told(&instance, &say(what, json)).await.expect_err("is not right");
                assert!(
                    matches!(error, PluginError::SchemaViolation { .. }) && !error.needs_restart(),
                    "{error}"
                );
                assert!(error.to_string().contains(said), "{error} does not say {said}");
            }
        }
        let error = told(&instance, r#"{"do": "forbidden"}"#)
            .await
            .expect_err("is not in the manifest");
        assert_eq!(
            error,
            PluginError::NotPermitted {
                effect: EffectKind::Notice
            }
        );
    }
}
