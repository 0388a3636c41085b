//! Tasks that end with whom they belong to.
//!
//! Must never do: let one outlive its node of ROS 2.

use std::future::Future;
use tokio::runtime::Handle;
use tokio::task::AbortHandle;

/// Tasks. They end when this is dropped.
pub struct Tasks {
    runtime: Handle,
    running: Vec<AbortHandle>,
}

impl Tasks {
    /// None yet, for this runtime.
    #[must_use]
    pub fn new(runtime: Handle) -> Self {
        Self {
            runtime,
            running: Vec::new(),
        }
    }

    /// One more.
    pub fn add(&mut self, task: impl Future<Output = ()> + Send + 'static) {
        self.running.push(self.runtime.spawn(task).abort_handle());
    }
}

impl Drop for Tasks {
    fn drop(&mut self) {
        for task in &self.running {
            task.abort();
        }
    }
}
