//! The calls of one instance on a worker of this process.
//!
//! Must never do: wait for a call of another instance's but in the worker's order.

use crate::PluginError;
use crate::answer::RawAnswer;
use crate::frames::Frame;
use crate::hosted::HostedInstance;
use crate::runner_settings::RunnerSettings;
use crate::task::Task;
use crate::worker::{Job, Worker};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;
use tokio::sync::oneshot;

/// Most requests are shorter, in bytes.
const USUAL_REQUEST_BYTES: usize = 512;

/// CBOR of a value, or that it could not be encoded (which only a custom encoder can cause).
pub(crate) fn encode<T: minicbor::Encode<()>>(value: &T) -> Result<Vec<u8>, PluginError> {
    // A period's events; growing step by step costs more than all the rest.
    let mut bytes = Vec::with_capacity(USUAL_REQUEST_BYTES);
    minicbor::encode(value, &mut bytes).map_err(|e| PluginError::NotUnderstood {
        detail: format!("cannot be encoded: {e}"),
    })?;
    Ok(bytes)
}

/// The untyped calls of one instance, of any kind of plugin.
#[derive(Debug)]
pub(crate) struct Calls {
    pub(crate) hosted: Arc<HostedInstance>,
    worker: Arc<Worker>,
    pub(crate) settings: RunnerSettings,
}

impl Calls {
    /// Makes an instance on this worker.
    pub(crate) async fn create(
        worker: Arc<Worker>,
        settings: RunnerSettings,
        hosted: HostedInstance,
        schema: u32,
        bytes: Vec<u8>,
    ) -> Result<Self, PluginError> {
        worker.instances.fetch_add(1, Ordering::Relaxed);
        // From here on `drop` takes the instance off its worker again, whatever becomes of it.
        let calls = Self {
            hosted: Arc::new(hosted),
            worker,
            settings,
        };
        calls
            .ask(Task::Create { schema, bytes }, settings.create_deadline)
            .await?;
        Ok(calls)
    }

    /// Calls a method; with `then_snapshot` the same visit also takes a snapshot.
    pub(crate) async fn invoke(
        &self,
        method: u32,
        schema: u32,
        bytes: Vec<u8>,
        frames: Vec<Arc<Frame>>,
        then_snapshot: bool,
    ) -> Result<RawAnswer, PluginError> {
        let task = Task::Invoke {
            method,
            schema,
            bytes,
            frames,
            then_snapshot,
        };
        self.ask(task, self.settings.call_deadline)
            .await?
            .ok_or(PluginError::Gone)
    }

    async fn ask(&self, task: Task, deadline: Duration) -> Result<Option<RawAnswer>, PluginError> {
        let (reply, answer) = oneshot::channel();
        let job = Job {
            hosted: Arc::clone(&self.hosted),
            task,
            deadline,
            reply: Some(reply),
        };
        self.worker.push(job).map_err(|refused| refused.1)?;
        answer.await.unwrap_or(Err(PluginError::Gone))
    }
}

impl Drop for Calls {
    fn drop(&mut self) {
        self.worker.instances.fetch_sub(1, Ordering::Relaxed);
        let deadline = self.settings.create_deadline;
        let job = Job {
            hosted: Arc::clone(&self.hosted),
            task: Task::Destroy,
            deadline,
            reply: None,
        };
        if let Err(refused) = self.worker.push(job) {
            let (job, error) = *refused;
            tracing::error!(target: "plugin", instance = %job.hosted.name, "was not ended: {error}");
        }
    }
}
