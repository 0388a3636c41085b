//! Many lives and deaths of children, alone in their process: its open files and threads can be counted.

#[path = "host/orders.rs"]
mod orders;

use orders::{camera, child, count_of, create, runners, told};
use skein_plugin_host::{Instance, Plugin, Runners};
use std::sync::Arc;
use std::time::{Duration, Instant};

#[tokio::test]
async fn two_hundred_lives_leave_nothing_behind() {
    let runners = runners(Duration::from_secs(10));
    let plugin = camera();
    // What is made once and kept.
    drop(one_life(&runners, &plugin, 0).await);
    wait_for_none(&runners).await;
    let before = (count_of("/proc/self/fd"), count_of("/proc/self/task"));
    for life in 0..200 {
        let instance = one_life(&runners, &plugin, life).await;
        match life % 3 {
            0 => assert!(instance.kill()),
            1 => assert!(told(&instance, r#"{"do": "die", "how": "exit"}"#).await.is_err()),
            _ => {}
        }
    }
    wait_for_none(&runners).await;
    // A thread that waited for work in the beginning may have ended since.
    let after = (count_of("/proc/self/fd"), count_of("/proc/self/task"));
    assert!(after.0 <= before.0 && after.1 <= before.1, "{before:?}, then {after:?}");
    assert_eq!(orders::children_of_this_process(), Vec::<String>::new());
}

async fn one_life(runners: &Runners, plugin: &Arc<Plugin>, life: u32) -> Instance {
    let instance = runners
        .create(Arc::clone(plugin), child(), create("{}", None))
        .await
        .expect("is created");
    let answer = told(&instance, &format!(r#"{{"do": "picture", "brightness": {life}}}"#))
        .await
        .expect("answers");
    assert_eq!(answer.frames.len(), 1);
    instance
}

/// Waits until the last thread of a child has ended.
async fn wait_for_none(runners: &Runners) {
    let began = Instant::now();
    while runners.health().children > 0 {
        assert!(began.elapsed() < Duration::from_secs(60), "children are left");
        tokio::time::sleep(Duration::from_millis(1)).await;
    }
    // The thread itself goes a moment after what it counted.
    while orders::has_thread("plugin-child") {
        assert!(began.elapsed() < Duration::from_secs(60), "a thread is left");
        tokio::time::sleep(Duration::from_millis(1)).await;
    }
}
