//! The plugin in C: compiled as its README says, and run through the host in both isolations.

use skein_domain::exchange::{CommandProgress, Effect, Event, EventBatch};
use skein_domain::{CommandId, NodeTime};
use skein_plugin_host::{ChildLimits, Isolation, Plugin, PluginKind, Runners};
use skein_tests_plugin_boundary::{create_uav, example_c, tick};
use std::sync::Arc;
use std::time::Duration;

fn report(effects: &[Effect]) -> Option<&str> {
    effects.iter().find_map(|effect| match effect {
        Effect::Report { state_json } => Some(state_json.as_str()),
        _ => None,
    })
}

#[tokio::test]
async fn it_counts_takes_commands_and_goes_on_after_a_restart() {
    let folder = tempfile::tempdir().expect("can be made");
    let plugin = Plugin::load(&example_c(folder.path())).expect("is taken");
    assert_eq!(plugin.manifest().kind, PluginKind::DETECTOR);
    assert!(plugin.manifest().check_command(r#"{"command": "reset"}"#).is_ok());
    assert!(plugin.manifest().check_command(r#"{"command": "explode"}"#).is_err());
    let runners = Runners::new(1, Duration::from_secs(10));
    runners.set_host_program(env!("CARGO_BIN_EXE_boundary-host").into());
    for isolation in [Isolation::InProcess, Isolation::Child(ChildLimits::default())] {
        let create = |snapshot| runners.create(Arc::clone(&plugin), isolation, create_uav(3, "{}", snapshot));
        let instance = create(None).await.expect("is created");
        let first = instance.call(tick(1), &[]).await.expect("answers");
        assert_eq!(report(&first.effects), Some(r#"{"ticks":1}"#));
        let second = instance.call(tick(2), &[]).await.expect("answers");
        let restored = create(Some(second.snapshot.clone())).await.expect("is created");
        assert_eq!(restored.snapshot().await.as_deref(), Ok(&second.snapshot[..]));
        // An event it does not know among those it does.
        let command_json = r#"{"command": "reset"}"#.to_owned();
        let reset = Event::PayloadCommand {
            id: CommandId(900),
            command_json,
        };
        let batch = EventBatch {
            now: NodeTime(3),
            events: vec![Event::Peers(Vec::new()), Event::Tick, reset, Event::Tick],
        };
        let third = restored.call(batch, &[]).await.expect("answers");
        assert_eq!(report(&third.effects), Some(r#"{"ticks":1}"#), "{isolation:?}");
        let done = Effect::CommandProgress {
            id: CommandId(900),
            progress: CommandProgress::Done,
        };
        assert!(third.effects.contains(&done), "{:?}", third.effects);
    }
}
