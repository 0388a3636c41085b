//! A thousand lives: nothing is left of the ones that ended.

use skein_domain::NodeTime;
use skein_domain::exchange::{Effect, Event, EventBatch, FaultDrill};
use skein_plugin_host::{Isolation, Plugin, PluginAnswer, PluginError, Runners};
use skein_testkit::{eventually, patience};
use skein_tests_plugin_boundary::{create_uav, fixture, shipped, tick, wrong_instance};
use std::sync::Arc;
use std::time::Duration;

const LIVES: u32 = 1_000;

/// Open files and threads of this process.
fn handles() -> (usize, usize) {
    let count = |path: &str| std::fs::read_dir(path).expect("is there").count();
    (count("/proc/self/fd"), count("/proc/self/task"))
}

/// Resident memory of this process in MB.
fn resident_mb() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").expect("is there");
    let line = status.lines().find(|line| line.starts_with("VmRSS:")).expect("is told");
    let kilobytes: f64 = line
        .split_whitespace()
        .nth(1)
        .and_then(|n| n.parse().ok())
        .expect("is a number");
    kilobytes / 1024.0
}

#[tokio::test]
async fn a_thousand_restarts_leave_nothing_behind() {
    // Long deadlines: on a busy machine none of these calls is to be taken for a hang.
    let runners = Runners::new(2, Duration::from_secs(10));
    let plugin = Plugin::load(&fixture("failing_model")).expect("is taken");
    let watch = wrong_instance(&runners, &plugin, "fail", "never")
        .await
        .expect("is created");
    let mut after_warm_up = None;
    for life in 0..LIVES {
        let what = if life % 2 == 0 { "panic_in_handle" } else { "never" };
        let instance = wrong_instance(&runners, &plugin, "fail", what)
            .await
            .expect("is created");
        let answer = instance.call(tick(1), &[]).await;
        assert_eq!(
            matches!(answer, Err(PluginError::Panicked { .. })),
            life % 2 == 0,
            "{answer:?}"
        );
        drop(instance);
        if life == LIVES / 10 {
            after_warm_up = Some((handles(), resident_mb()));
        }
    }
    let ((files, threads), memory_mb) = after_warm_up.expect("was taken");
    eventually(patience(), "the end of all but one", async || {
        let alive = watch.snapshot().await.expect("answers");
        (alive == 1_u32.to_le_bytes()).then_some(())
    })
    .await;
    let ((files_now, threads_now), memory_now_mb) = (handles(), resident_mb());
    // The other test of this file may just be running.
    assert!(files_now <= files + 16, "{files} open files became {files_now}");
    assert!(threads_now <= threads + 8, "{threads} threads became {threads_now}");
    assert!(
        memory_now_mb < memory_mb + 20.0,
        "{memory_mb:.0} MB became {memory_now_mb:.0} MB"
    );
    assert_eq!(runners.health().instances, 1);
}

#[tokio::test]
async fn a_model_restarted_a_thousand_times_keeps_its_state() {
    let (runners, plugin) = (Runners::new(2, Duration::from_secs(10)), shipped("generic-uav"));
    let mut snapshot = None;
    for life in 0..u64::from(LIVES) {
        let create = create_uav(3, "{}", snapshot);
        let instance = runners
            .create(Arc::clone(&plugin), Isolation::InProcess, create)
            .await
            .expect("is created");
        let own = Event::Own(skein_domain::exchange::OwnState {
            link_connected: true,
            ..Default::default()
        });
        let batch = EventBatch {
            now: NodeTime(life * 20_000),
            events: vec![own, Event::Tick],
        };
        let PluginAnswer {
            effects,
            snapshot: taken,
            ..
        } = instance.call(batch, &[]).await.expect("answers");
        // It tells its state once in all its lives; what it can do, every instance tells.
        let states = effects.iter().filter(|e| matches!(e, Effect::State { .. }));
        assert_eq!(states.count(), usize::from(life == 0), "life {life}: {effects:?}");
        snapshot = Some(taken);
        let drill = EventBatch {
            now: NodeTime(0),
            events: vec![Event::FaultDrill(FaultDrill::Panic)],
        };
        assert!(instance.call(drill, &[]).await.is_err_and(|e| e.needs_restart()));
    }
}
