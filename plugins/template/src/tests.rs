//! The plugin against a light made of a few lines, in simulated time.

use super::{Command, IndicatorLight, Settings};
use skein_plugin_sdk::domain::exchange::{CommandProgress, Create, Effect, Event};
use skein_plugin_sdk::domain::{CommandId, Incarnation, NodeTime, Refusal, VehicleId};
use skein_plugin_sdk::{Effects, Payload};

fn create(snapshot: Option<Vec<u8>>) -> IndicatorLight {
    let create = Create {
        vehicle: VehicleId(1),
        incarnation: Incarnation(1),
        config_json: "{}".to_owned(),
        snapshot,
        now: NodeTime(0),
        payload: Some("light".to_owned()),
        system_id: None,
    };
    IndicatorLight::create(create, Settings::default()).expect("is created")
}

fn seconds(seconds: f64) -> NodeTime {
    NodeTime::from_seconds(seconds)
}

/// What it does with one event.
fn give(light: &mut IndicatorLight, at_s: f64, event: Event) -> Vec<Effect> {
    let mut effects = Effects::default();
    light.handle(seconds(at_s), &[event], &mut effects);
    effects.take()
}

fn command(light: &mut IndicatorLight, at_s: f64, id: u64, json: &str) -> Vec<Effect> {
    let mut effects = Effects::default();
    let command: Command = serde_json::from_str(json).expect("is a command");
    light.command(seconds(at_s), CommandId(id), command, &mut effects);
    effects.take()
}

fn progress(effects: &[Effect]) -> Vec<(u64, CommandProgress)> {
    let of = |effect: &Effect| match effect {
        Effect::CommandProgress { id, progress } => Some((id.0, progress.clone())),
        _ => None,
    };
    effects.iter().filter_map(of).collect()
}

fn answer(text: &str) -> Event {
    Event::Received {
        bytes: text.as_bytes().to_vec(),
    }
}

#[test]
fn a_command_is_done_when_the_light_says_so() {
    let mut light = create(None);
    let begun = command(&mut light, 1.0, 7, r#"{"command": "on", "brightness": 0.8}"#);
    assert_eq!(progress(&begun), [(7, CommandProgress::Executing)]);
    assert!(begun.contains(&Effect::Transmit {
        bytes: b"SET 0.80\n".to_vec()
    }));
    // In two pieces, as a serial line may give it.
    assert!(progress(&give(&mut light, 1.1, answer("AT 0.8"))).is_empty());
    let ended = give(&mut light, 1.2, answer("0 31.5\n"));
    assert_eq!(progress(&ended), [(7, CommandProgress::Done)]);
    let state = r#"{"connected":true,"brightness":0.8,"temperature_c":31.5}"#;
    assert!(
        ended.contains(&Effect::Report {
            state_json: state.to_owned()
        }),
        "{ended:?}"
    );
}

#[test]
fn a_light_that_does_not_answer_times_out() {
    let mut light = create(None);
    command(&mut light, 1.0, 7, r#"{"command": "on"}"#);
    assert!(progress(&give(&mut light, 3.9, Event::Tick)).is_empty());
    let ended = progress(&give(&mut light, 4.0, Event::Tick));
    assert!(
        matches!(
            &ended[..],
            [(
                7,
                CommandProgress::Refused {
                    refusal: Refusal::TimedOut { .. }
                }
            )]
        ),
        "{ended:?}"
    );
}

#[test]
fn a_newer_command_replaces_the_one_that_waits() {
    let mut light = create(None);
    command(&mut light, 1.0, 7, r#"{"command": "on"}"#);
    let effects = progress(&command(&mut light, 1.1, 8, r#"{"command": "off"}"#));
    assert_eq!(
        effects[0],
        (
            7,
            CommandProgress::Refused {
                refusal: Refusal::Superseded
            }
        )
    );
}

#[test]
fn it_asks_every_second_and_notices_when_nobody_answers() {
    let mut light = create(None);
    let asks = |effects: &[Effect]| {
        effects.contains(&Effect::Transmit {
            bytes: b"ASK\n".to_vec(),
        })
    };
    assert!(asks(&give(&mut light, 0.1, Event::Tick)));
    assert!(!asks(&give(&mut light, 0.9, Event::Tick)));
    assert!(asks(&give(&mut light, 1.1, Event::Tick)));
    give(&mut light, 1.2, answer("AT 0.00 20\n"));
    let lost = give(&mut light, 4.3, Event::Tick);
    assert!(
        lost.iter().any(
            |effect| matches!(effect, Effect::Report { state_json } if state_json.contains(r#""connected":false"#))
        )
    );
}

#[test]
fn heat_is_told_once() {
    let mut light = create(None);
    let told = |effects: &[Effect]| effects.iter().any(|effect| matches!(effect, Effect::Occurrence { .. }));
    assert!(told(&give(&mut light, 1.0, answer("AT 1.00 75\n"))));
    assert!(!told(&give(&mut light, 1.1, answer("AT 1.00 76\n"))));
    assert!(!told(&give(&mut light, 1.2, answer("AT 1.00 50\n"))));
    assert!(told(&give(&mut light, 1.3, answer("AT 1.00 71\n"))));
}

#[test]
fn it_goes_on_after_a_restart() {
    let mut light = create(None);
    command(&mut light, 1.0, 7, r#"{"command": "on", "brightness": 0.25}"#);
    let snapshot = light.snapshot();
    let mut restored = create(Some(snapshot.clone()));
    assert_eq!(restored.snapshot(), snapshot, "nothing is lost or added");
    let ended = give(&mut restored, 1.2, answer("AT 0.25 20\n"));
    assert_eq!(progress(&ended), [(7, CommandProgress::Done)]);
    // A snapshot it does not understand does not keep it from starting.
    create(Some(b"garbage".to_vec()));
}

#[test]
fn garbage_from_the_line_is_no_answer() {
    let mut light = create(None);
    for text in [
        "\n\n",
        "AT\n",
        "AT x y\n",
        "AT 0.5\n",
        "AT inf 3\n",
        &"x".repeat(10_000),
        "\u{fffd}\n",
    ] {
        let effects = give(&mut light, 1.0, answer(text));
        assert!(
            !effects
                .iter()
                .any(|effect| matches!(effect, Effect::Report { state_json } if state_json.contains("true")))
        );
    }
}
