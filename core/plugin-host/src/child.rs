//! Instances in processes of their own. A node starts its own program as `skein plugin-host` for each, hands the library over as the
//! sealed bytes it has judged, and speaks to it over a socket; frames lie in memory that both share.
//!
//! Must never do: trust what a child sends, or let one outlive its instance or this process.

mod calls;
mod logs;
mod message;
mod process;
mod received;
mod serve;
mod share;
mod wire;

pub use serve::{ServeError, serve};

use crate::answer::RawAnswer;
use crate::frames::Pool;
use crate::{CallStatistics, ChildLimits, Manifest, Plugin, PluginError, RunnerSettings};
use calls::Job;
pub(crate) use calls::{Call, Caller, Shared};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{Sender, channel};
use tokio::sync::oneshot;

/// The untyped calls of one instance in a child.
#[derive(Debug)]
pub(crate) struct ChildCalls {
    shared: Arc<Shared>,
    /// When it goes, the thread ends the child and itself.
    jobs: Sender<Job>,
}

impl ChildCalls {
    pub(crate) async fn create(
        // which program is started, the bounds, and what is kept for as long as the child lives
        (program, settings, living): (PathBuf, RunnerSettings, Arc<()>),
        plugin: Arc<Plugin>,
        name: String,
        limits: ChildLimits,
        schema: u32,
        bytes: Vec<u8>,
    ) -> Result<Self, PluginError> {
        let shared = Arc::new(Shared::new(plugin, name, settings, limits));
        let (jobs, receiver) = channel::<Job>();
        let (reply, made) = oneshot::channel();
        let for_thread = Arc::clone(&shared);
        // The system ends a child with the thread that started it.
        let life = move || {
            let _living = living;
            match Caller::start(for_thread, &program, schema, &bytes) {
                Ok(caller) => {
                    let _ = reply.send(Ok(()));
                    caller.run(&receiver);
                }
                Err(error) => {
                    let _ = reply.send(Err(error));
                }
            }
        };
        std::thread::Builder::new()
            .name("plugin-child".to_owned())
            .spawn(life)
            .map_err(|e| PluginError::NoThread { detail: e.to_string() })?;
        made.await.unwrap_or(Err(PluginError::Gone))?;
        Ok(Self { shared, jobs })
    }

    pub(crate) async fn invoke(&self, call: Call) -> Result<RawAnswer, PluginError> {
        let (reply, answer) = oneshot::channel();
        self.jobs.send((call, reply)).map_err(|_| PluginError::Gone)?;
        answer.await.unwrap_or(Err(PluginError::Gone))
    }

    pub(crate) fn kill(&self) -> bool {
        self.shared.process.get().is_some_and(|process| process.kill())
    }

    pub(crate) fn pid(&self) -> Option<u32> {
        self.shared.process.get()?.pid()
    }

    pub(crate) fn name(&self) -> &str {
        &self.shared.name
    }

    pub(crate) fn manifest(&self) -> &Manifest {
        self.shared.plugin.manifest()
    }

    pub(crate) fn statistics(&self) -> CallStatistics {
        self.shared.times.read(self.shared.sink.dropped())
    }

    pub(crate) fn pool(&self) -> &Pool {
        &self.shared.pool
    }
}
