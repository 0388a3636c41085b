//! What instances do wrong, the typed error each gives, and that no other instance is disturbed.

use skein_domain::NodeTime;
use skein_domain::exchange::{Effect, Event, EventBatch, FaultDrill};
use skein_domain::manifest::EffectKind;
use skein_plugin_host::{Instance, Isolation, Plugin, PluginError, PluginKind, RunnerSettings, Runners};
use skein_testkit::{eventually, patience};
use skein_tests_plugin_boundary::{assert_alive, create_uav, fixture, shipped, tick, wrong_instance};
use std::sync::Arc;
use std::time::Duration;

/// Where a call is to be given up, and healthy ones come back in time on a busy machine too. Shorter than what `slow_in_handle` takes.
const CALL_DEADLINE: Duration = Duration::from_secs(1);
/// Where none is, however busy the machine.
const LONG: Duration = Duration::from_secs(20);

/// One thread, so that whatever hangs hangs the others too, were it not watched.
fn one_worker() -> Arc<Runners> {
    one_worker_with(CALL_DEADLINE)
}

fn one_worker_with(deadline: Duration) -> Arc<Runners> {
    Runners::with_settings(RunnerSettings {
        threads: 1,
        call_deadline: deadline,
        create_deadline: deadline,
        ..RunnerSettings::default()
    })
}

/// The fixture in which `what` can go wrong.
fn load(name: &str) -> Arc<Plugin> {
    Plugin::load(&fixture(name)).expect("is taken")
}

async fn healthy(runners: &Arc<Runners>) -> Instance {
    let instance = runners
        .create(shipped("generic-uav"), Isolation::InProcess, create_uav(1, "{}", None))
        .await
        .expect("is created");
    assert_alive(&instance).await;
    instance
}

fn alive_count(snapshot: &[u8]) -> u32 {
    u32::from_le_bytes(snapshot.try_into().expect("four bytes"))
}

type Expectation = fn(&PluginError) -> bool;

#[tokio::test]
async fn what_is_wrong_at_the_level_of_the_abi_is_told_apart() {
    let cases: [(&str, Expectation); 13] = [
        ("null_handle", |e| matches!(e, PluginError::Undecodable { .. })),
        (
            "create_status",
            |e| matches!(e, PluginError::NotUnderstood { detail } if detail.contains("77")),
        ),
        (
            "bad_utf8_reason",
            |e| matches!(e, PluginError::Refused { detail } if detail.starts_with("not ")),
        ),
        ("garbage_effects", |e| matches!(e, PluginError::Undecodable { .. })),
        ("truncated_effects", |e| matches!(e, PluginError::Undecodable { .. })),
        (
            "other_schema",
            |e| matches!(e, PluginError::Undecodable { detail } if detail.contains("schema 9")),
        ),
        ("null_with_length", |e| matches!(e, PluginError::Undecodable { .. })),
        ("impossible_length", |e| matches!(e, PluginError::Undecodable { .. })),
        (
            "unknown_status",
            |e| matches!(e, PluginError::NotUnderstood { detail } if detail.contains("1000")),
        ),
        ("huge_answer", |e| {
            matches!(e, PluginError::TooLarge { len: 52_428_800, .. })
        }),
        ("endless_list", |e| matches!(e, PluginError::Undecodable { .. })),
        ("announces_too_many", |e| {
            matches!(e, PluginError::TooManyEffects { .. })
        }),
        ("unknown_method", |e| matches!(e, PluginError::NotUnderstood { .. })),
    ];
    let (runners, plugin) = (one_worker_with(LONG), load("nothing_wrong"));
    let other = healthy(&runners).await;
    for (what, expected) in cases {
        let error = match wrong_instance(&runners, &plugin, "do", what).await {
            Err(error) => error,
            Ok(instance) => {
                let error = instance.call(tick(1), &[]).await.expect_err(what);
                assert!(!error.needs_restart(), "{what}: it can be called again");
                assert_eq!(
                    instance.snapshot().await.as_deref(),
                    Ok(b"a snapshot".as_slice()),
                    "{what}"
                );
                error
            }
        };
        assert!(expected(&error), "{what}: {error:?}");
        assert_alive(&other).await;
    }
    let good = wrong_instance(&runners, &plugin, "do", "nothing")
        .await
        .expect("is created");
    assert_eq!(
        good.call(tick(1), &[]).await.expect("answers").effects,
        [Effect::StopStream]
    );
}

#[tokio::test]
async fn what_a_model_does_wrong_is_told_apart() {
    let panicked = |error: &PluginError| matches!(error, PluginError::Panicked { message } if message.contains("on purpose") || message.contains("without a message"));
    let too_late = |error: &PluginError| matches!(error, PluginError::DeadlineExceeded { .. });
    let cases: [(&str, Expectation); 12] = [
        ("refuse_create", |e| {
            *e == PluginError::Refused {
                detail: "refused on purpose".to_owned(),
            }
        }),
        ("panic_in_create", panicked),
        ("hang_in_create", too_late),
        ("panic_in_handle", panicked),
        ("panic_with_strange_payload", panicked),
        ("hang_in_handle", too_late),
        ("panic_in_snapshot", panicked),
        ("hang_in_snapshot", too_late),
        ("huge_snapshot", |e| matches!(e, PluginError::TooLarge { .. })),
        ("effect_not_in_manifest", |e| {
            *e == PluginError::NotPermitted {
                effect: EffectKind::Setpoint,
            }
        }),
        ("flood_of_effects", |e| {
            matches!(e, PluginError::TooLarge { .. } | PluginError::TooManyEffects { .. })
        }),
        (
            "no_such_way_to_fail",
            |e| matches!(e, PluginError::Refused { detail } if detail.contains("unknown variant")),
        ),
    ];
    let (runners, plugin) = (one_worker(), load("failing_model"));
    let other = healthy(&runners).await;
    for (what, expected) in cases {
        let error = match wrong_instance(&runners, &plugin, "fail", what).await {
            Err(error) => error,
            Ok(instance) => {
                // Both at once, as a node does it.
                let error = instance.call(tick(1), &[]).await.expect_err(what);
                let again = instance.call(tick(2), &[]).await;
                assert_eq!(
                    again.is_err_and(|e| e.needs_restart()),
                    error.needs_restart(),
                    "{what}: {error:?}"
                );
                error
            }
        };
        assert!(expected(&error), "{what}: {error:?}");
        assert_alive(&other).await;
    }
}

#[tokio::test]
async fn a_hang_delays_the_others_by_no_more_than_the_deadline_and_costs_one_instance() {
    let (runners, plugin) = (one_worker(), load("failing_model"));
    let other = healthy(&runners).await;
    for what in ["hang_in_handle", "spin_in_handle"] {
        let hangs = wrong_instance(&runners, &plugin, "fail", what)
            .await
            .expect("is created");
        // Queued behind the hanging call, on the same thread.
        let (hung, ()) = tokio::join!(hangs.call(tick(1), &[]), assert_alive(&other));
        let PluginError::DeadlineExceeded { after } = hung.expect_err("hangs") else {
            panic!("another error")
        };
        assert!(after >= CALL_DEADLINE, "{after:?} is before the deadline");
        let again = hangs.call(tick(2), &[]).await.expect_err("is gone");
        assert!(again.needs_restart());
        drop(hangs);
        assert_alive(&other).await;
    }
    assert_eq!(plugin.hanging_threads(), 2);
    assert_eq!(runners.health().instances, 1);
}

#[tokio::test]
async fn a_call_that_comes_back_too_late_is_cleaned_up_after() {
    let (runners, plugin) = (one_worker(), load("failing_model"));
    let slow = wrong_instance(&runners, &plugin, "fail", "slow_in_handle")
        .await
        .expect("is created");
    let error = slow.call(tick(1), &[]).await.expect_err("is too slow");
    assert!(matches!(error, PluginError::DeadlineExceeded { .. }));
    assert_eq!(plugin.hanging_threads(), 1);
    let watch = wrong_instance(&runners, &plugin, "fail", "never")
        .await
        .expect("is created");
    eventually(patience(), "the late call's return", async || {
        let alive = alive_count(&watch.snapshot().await.expect("answers"));
        (plugin.hanging_threads() == 0 && alive == 1).then_some(())
    })
    .await;
    assert!(
        slow.call(tick(2), &[]).await.is_err_and(|e| e.needs_restart()),
        "it stays lost"
    );
}

#[tokio::test]
async fn a_plugin_in_which_too_many_threads_hang_gets_no_more() {
    let settings = RunnerSettings {
        threads: 1,
        call_deadline: CALL_DEADLINE,
        max_hanging_threads: 2,
        ..RunnerSettings::default()
    };
    let (runners, plugin) = (Runners::with_settings(settings), load("failing_model"));
    let other = healthy(&runners).await;
    for _ in 0..2 {
        let hangs = wrong_instance(&runners, &plugin, "fail", "hang_in_handle")
            .await
            .expect("is created");
        assert!(hangs.call(tick(1), &[]).await.is_err());
    }
    let refused = wrong_instance(&runners, &plugin, "fail", "never")
        .await
        .expect_err("is refused");
    assert_eq!(refused, PluginError::Quarantined { hanging: 2 });
    assert_alive(&other).await;
}

#[tokio::test]
async fn what_goes_wrong_at_an_instances_end_disturbs_nobody() {
    let (runners, plugin) = (one_worker(), load("failing_model"));
    let other = healthy(&runners).await;
    for what in ["panic_in_drop", "hang_in_drop"] {
        let instance = wrong_instance(&runners, &plugin, "fail", what)
            .await
            .expect("is created");
        assert!(instance.call(tick(1), &[]).await.is_ok());
        drop(instance);
        assert_alive(&other).await;
    }
    assert_eq!(plugin.hanging_threads(), 1);
}

#[tokio::test]
async fn drills_take_the_ways_of_faults() {
    let runners = one_worker();
    let (plugin, other) = (shipped("generic-uav"), healthy(&runners).await);
    let drill = |drill| EventBatch {
        now: NodeTime(1),
        events: vec![Event::FaultDrill(drill), Event::Tick],
    };
    let instance = runners
        .create(Arc::clone(&plugin), Isolation::InProcess, create_uav(2, "{}", None))
        .await
        .expect("is created");
    let error = instance.call(drill(FaultDrill::Panic), &[]).await.expect_err("panics");
    assert!(matches!(error, PluginError::Panicked { message } if message.contains("fault drill")));
    let instance = runners
        .create(plugin, Isolation::InProcess, create_uav(2, "{}", None))
        .await
        .expect("is created");
    let error = instance.call(drill(FaultDrill::Hang), &[]).await.expect_err("hangs");
    assert!(matches!(error, PluginError::DeadlineExceeded { .. }));
    assert_alive(&other).await;
}

#[tokio::test]
async fn a_plugin_of_any_kind_is_created_and_says_what_it_is() {
    let instance = one_worker_with(LONG)
        .create(load("other_kind"), Isolation::InProcess, create_uav(1, "{}", None))
        .await
        .expect("is created");
    assert_eq!(instance.manifest().kind, PluginKind::CAMERA);
}

#[tokio::test]
async fn a_configuration_that_is_not_right_is_refused_in_words() {
    let runners = one_worker_with(LONG);
    for (config, said) in [
        (r#"{"cruise_speed": 3}"#, "unknown field `cruise_speed`"),
        (
            r#"{"cruise_speed_m_s": -3}"#,
            "cruise_speed_m_s = -3: it must be above zero",
        ),
        ("{", "EOF"),
    ] {
        let created = runners
            .create(
                shipped("generic-uav"),
                Isolation::InProcess,
                create_uav(1, config, None),
            )
            .await;
        let Err(PluginError::Refused { detail }) = created else {
            panic!("{config} was taken")
        };
        assert!(detail.contains(said), "{detail:?} does not say {said:?}");
    }
}

#[tokio::test]
async fn two_loads_of_one_file_are_two_plugins_and_outlive_the_file() {
    let directory = tempfile::tempdir().expect("a directory");
    let path = directory.path().join("libmodel.so");
    std::fs::copy(fixture("failing_model"), &path).expect("copied");
    let (old, new) = (
        Plugin::load(&path).expect("is taken"),
        Plugin::load(&path).expect("is taken"),
    );
    // Exchanged in place and cut off, as a careless upgrade does.
    std::fs::write(&path, b"garbage").expect("written");
    let runners = one_worker_with(LONG);
    let mut instances = Vec::new();
    for _ in 0..3 {
        instances.push(
            wrong_instance(&runners, &old, "fail", "never")
                .await
                .expect("is created"),
        );
    }
    let other = wrong_instance(&runners, &new, "fail", "never")
        .await
        .expect("is created");
    assert_eq!(alive_count(&instances[0].snapshot().await.expect("answers")), 3);
    assert_eq!(
        alive_count(&other.snapshot().await.expect("answers")),
        1,
        "it has its own statics"
    );
    assert!(Plugin::load(&path).is_err());
    assert!(instances[0].call(tick(1), &[]).await.is_ok());
}

#[tokio::test]
async fn calls_are_counted_and_timed() {
    let runners = one_worker_with(LONG);
    let instance = healthy(&runners).await;
    for i in 0..100 {
        instance.call(tick(i), &[]).await.expect("answers");
    }
    let statistics = instance.statistics();
    assert_eq!((statistics.calls, statistics.failures), (101, 0));
    assert!(
        statistics.p50_us > 0.0 && statistics.p50_us <= statistics.p99_us && statistics.p99_us <= statistics.max_us
    );
    assert_eq!(
        (instance.name(), instance.manifest().name.as_str()),
        ("vehicle-1", "generic-uav")
    );
}

#[tokio::test]
async fn instances_outlive_the_pool_they_were_made_in() {
    let runners = one_worker_with(LONG);
    let instance = healthy(&runners).await;
    drop(runners);
    assert_alive(&instance).await;
}
