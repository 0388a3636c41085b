//! Log lines of plugins arrive in the node's log, with the instance's name, and not in floods.

use parking_lot::Mutex;
use skein_plugin_host::{Plugin, Runners};
use skein_tests_plugin_boundary::{fixture, tick, wrong_instance};
use std::io::Write;
use std::sync::Arc;
use std::time::Duration;

/// Keeps what is written.
#[derive(Clone, Default)]
struct Log(Arc<Mutex<Vec<u8>>>);

impl Write for Log {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.lock().write(bytes)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

#[tokio::test]
async fn lines_arrive_with_the_instances_name_and_a_flood_is_cut_off() {
    let log = Log::default();
    let writer = log.clone();
    let subscriber = tracing_subscriber::fmt()
        .with_ansi(false)
        .with_writer(move || writer.clone())
        .finish();
    tracing::subscriber::set_global_default(subscriber).expect("is the only one");

    let runners = Runners::new(1, Duration::from_secs(20));
    let plugin = Plugin::load(&fixture("failing_model")).expect("is taken");
    let instance = wrong_instance(&runners, &plugin, "fail", "flood_of_logs")
        .await
        .expect("is created");
    instance
        .call(tick(1), &[])
        .await
        .expect("a flood of logs is no failure");
    let text = String::from_utf8(log.0.lock().clone()).expect("is text");
    let first = text.lines().next().expect("is there");
    assert!(first.contains("failing: FloodOfLogs"), "{first}");
    assert!(
        first.contains("instance=vehicle-9") && first.contains("plugin=failing-model"),
        "{first}"
    );
    let lines = text.lines().filter(|line| line.contains("flood ")).count();
    let dropped = instance.statistics().dropped_log_lines;
    assert!(lines >= 90 && dropped > 0, "{lines} lines, {dropped} dropped");
    assert_eq!(lines as u64 + dropped + 1, 20_001, "every line is written or counted");
}
