//! What the service manager (systemd, `Type=notify`) is told: that the node is up, that it goes on, that it stops. Without one nothing is said.
//!
//! Must never do: say that the node is alive while its picture of the fleet stands still; the watchdog is there for exactly that.

use sd_notify::{NotifyState, notify, watchdog_enabled};
use skein_runtime::NodeHandle;
use std::time::Duration;

/// How often the fleet is looked at where the service manager wants no sign of life.
const STATUS_EVERY: Duration = Duration::from_secs(1);

/// Says that the node is up, then that it is alive, as long as its picture of the fleet goes on. Does not end.
pub async fn tell_of(node: &NodeHandle) {
    say(&[NotifyState::Ready]);
    // A quarter of what is allowed: one sign may be late.
    let every = watchdog_enabled().map_or(STATUS_EVERY, |allowed| allowed / 4);
    let (mut told, mut seen) = (String::new(), None);
    loop {
        let fleet = node.next_snapshot().await;
        // What has not changed was not made anew: who makes it stands.
        if seen.replace(fleet.time) != Some(fleet.time) {
            say(&[NotifyState::Watchdog]);
        }
        let armed = fleet.vehicles.iter().filter(|vehicle| vehicle.armed).count();
        let status = format!("{} vehicles, {armed} armed", fleet.vehicles.len());
        if told != status {
            say(&[NotifyState::Status(&status)]);
            told = status;
        }
        tokio::time::sleep(every).await;
    }
}

/// Says that the node stops: what it still does is no longer watched.
pub fn tell_of_stop() {
    say(&[NotifyState::Stopping]);
}

/// A service manager that does not listen changes nothing.
fn say(states: &[NotifyState<'_>]) {
    if let Err(error) = notify(states) {
        tracing::debug!("the service manager was not told: {error}");
    }
}
