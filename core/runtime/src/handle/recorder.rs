//! What the recorder needs of a node.

use super::NodeHandle;
use skein_domain::SwarmFrame;
use skein_domain::exchange::Severity;
use skein_domain::fence::FencePlan;
use skein_state::Tape;
use skein_view::{Audit, EventKind, RecorderStatus};
use std::sync::Arc;

impl NodeHandle {
    /// Where the recorder is told what it cannot read by itself.
    #[must_use]
    pub fn tape(&self) -> &Arc<Tape> {
        &self.shared.tape
    }

    /// Records what somebody does, if anybody records.
    pub fn audit(&self, audit: impl FnOnce() -> Audit) {
        self.shared.tape.take(|| skein_state::Taken::Audit(audit()));
    }

    /// The fences as they were described.
    #[must_use]
    pub fn fence_plan(&self) -> FencePlan {
        self.shared.fence_plan()
    }

    /// The swarm's frame, once known.
    #[must_use]
    pub fn frame(&self) -> Option<SwarmFrame> {
        self.shared.frame()
    }

    /// Whether flights are recorded.
    #[must_use]
    pub fn recorder(&self) -> Arc<RecorderStatus> {
        self.shared.recorder.load_full()
    }

    /// The recorder says what it does.
    pub fn note_recorder(&self, status: RecorderStatus) {
        self.shared.recorder.store(Arc::new(status));
    }

    /// Tells operators how recording fares.
    pub fn tell_of_recorder(&self, severity: Severity, text: impl Into<String>) {
        let now = self.now();
        self.shared
            .events
            .record(now, None, severity, EventKind::Recorder, text);
    }
}
