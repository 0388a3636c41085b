//! A node of which nothing runs, to show what a recording holds.
//!
//! Must never do: have an actor or a link, so that no command can leave it.

use super::NodeHandle;
use crate::parts::Parts;
use crate::wiring::{self, WiringError};
use skein_config::NodeConfig;
use skein_domain::Clock;
use skein_domain::fence::FencePlan;
use skein_safety::Gate;
use skein_view::{EventRecord, FleetSnapshot};
use std::sync::Arc;

impl NodeHandle {
    /// One that is called `name`, and shows what it is given by the clock it is given.
    ///
    /// # Errors
    /// Never yet: a configuration that says nothing makes sense.
    pub fn of_recording(name: &str, clock: Arc<dyn Clock>) -> Result<Self, WiringError> {
        let mut config = NodeConfig::default();
        name.clone_into(&mut config.node.name);
        config.plugins.directories.clear();
        let shared = wiring::shared(config, clock)?;
        Ok(Self::new(Arc::new(shared), Arc::new(Parts::default())))
    }

    /// Shows this from now on.
    pub fn show(&self, picture: FleetSnapshot) {
        self.shared.publish_picture(picture);
    }

    /// Shows that this gate with these fences was in force.
    pub fn show_gate(&self, gate: Gate, fences: FencePlan) {
        self.shared.hold_gate(gate, fences);
    }

    /// Shows these events instead of those before.
    pub fn show_events(&self, events: impl IntoIterator<Item = EventRecord>) {
        self.shared.events.hold(events);
    }

    /// Tells of one more event.
    pub fn show_event(&self, event: EventRecord) {
        self.shared.events.tell_again(event);
    }
}
