//! One instance of a plugin, as its actor holds it: event batches in, effect batches out.

use crate::answer::{Judge, PluginAnswer, RawAnswer};
use crate::calls::{Calls, encode};
use crate::child::{Call, ChildCalls};
use crate::frames::{Frame, Pool};
use crate::{CallStatistics, Isolation, Manifest, PluginError};
use skein_domain::exchange::{EVENT_BATCH_SCHEMA, EventBatch};
use skein_plugin_abi::method;
use std::sync::Arc;

/// An instance. Dropping it ends it on its thread, without waiting.
#[derive(Debug)]
pub struct Instance {
    way: Way,
    isolation: Isolation,
    judge: Judge,
}

/// How it is reached.
#[derive(Debug)]
pub(crate) enum Way {
    /// On a worker of this process.
    Here(Calls),
    /// In a process of its own.
    Child(ChildCalls),
}

impl Instance {
    pub(crate) fn new(way: Way, isolation: Isolation, judge: Judge) -> Self {
        Self { way, isolation, judge }
    }

    /// Hands a batch of events in; gives what the instance wants done and its snapshot after it, of the same visit. The bytes of `frames`
    /// can be read by the instance during the call, under the ids of their headers. Calls of one instance are made in the order they were
    /// begun. If the future is dropped the call is still made, and its effects are lost.
    pub async fn call(&self, batch: EventBatch, frames: &[Arc<Frame>]) -> Result<PluginAnswer, PluginError> {
        let bytes = encode(&batch)?;
        let answer = self
            .invoke(method::HANDLE_EVENTS, EVENT_BATCH_SCHEMA, bytes, frames.to_vec(), true)
            .await?;
        self.judge.answer(self.manifest(), self.pool(), &answer)
    }

    /// The state from which a new instance goes on after this one.
    pub async fn snapshot(&self) -> Result<Vec<u8>, PluginError> {
        let answer = self.invoke(method::SNAPSHOT, 0, Vec::new(), Vec::new(), false).await?;
        self.judge.snapshot(answer.bytes.bytes())
    }

    /// Ends a child process at once, as the system would: its call and all further ones fail. Tells whether there is one.
    pub fn kill(&self) -> bool {
        match &self.way {
            Way::Here(_) => false,
            Way::Child(child) => child.kill(),
        }
    }

    /// Where it runs.
    #[must_use]
    pub fn isolation(&self) -> Isolation {
        self.isolation
    }

    /// The id of its process, if that is one of its own and still there.
    #[must_use]
    pub fn pid(&self) -> Option<u32> {
        match &self.way {
            Way::Here(_) => None,
            Way::Child(child) => child.pid(),
        }
    }

    /// Its name in logs.
    #[must_use]
    pub fn name(&self) -> &str {
        match &self.way {
            Way::Here(calls) => &calls.hosted.name,
            Way::Child(child) => child.name(),
        }
    }

    /// What its plugin says of itself.
    #[must_use]
    pub fn manifest(&self) -> &Manifest {
        match &self.way {
            Way::Here(calls) => calls.hosted.plugin.manifest(),
            Way::Child(child) => child.manifest(),
        }
    }

    /// How long its calls take. Does not wait for a running call.
    #[must_use]
    pub fn statistics(&self) -> CallStatistics {
        match &self.way {
            Way::Here(calls) => calls.hosted.times.read(calls.hosted.services.log.dropped()),
            Way::Child(child) => child.statistics(),
        }
    }

    async fn invoke(
        &self,
        method: u32,
        schema: u32,
        bytes: Vec<u8>,
        frames: Vec<Arc<Frame>>,
        then_snapshot: bool,
    ) -> Result<RawAnswer, PluginError> {
        match &self.way {
            Way::Here(calls) => calls.invoke(method, schema, bytes, frames, then_snapshot).await,
            Way::Child(child) => {
                let call = Call {
                    method,
                    schema,
                    bytes,
                    frames,
                    then_snapshot,
                };
                child.invoke(call).await
            }
        }
    }

    fn pool(&self) -> &Pool {
        match &self.way {
            Way::Here(calls) => &calls.hosted.services.pool,
            Way::Child(child) => child.pool(),
        }
    }
}
