//! An instance called on the caller's own thread: what the boundary itself costs, for benches and for tools that look at a plugin.
//!
//! Must never do: serve a node. In this process nobody watches these calls or takes their times: one that hangs, hangs the caller.

use crate::answer::{Judge, RawAnswer};
use crate::calls::encode;
use crate::child::{Call, Caller, Shared};
use crate::frames::{Frame, Pool};
use crate::hosted::HostedInstance;
use crate::task::Task;
use crate::{Isolation, Manifest, Plugin, PluginAnswer, PluginError, RunnerSettings};
use skein_domain::exchange::{CREATE_SCHEMA, Create, EVENT_BATCH_SCHEMA, Effect, EventBatch};
use skein_plugin_abi::method;
use std::path::Path;
use std::sync::Arc;

/// An instance without a worker. Dropping it ends it and waits for that.
#[derive(Debug)]
pub struct DirectInstance {
    way: Way,
    judge: Judge,
    buffer: Vec<u8>,
}

#[derive(Debug)]
enum Way {
    Here(Box<HostedInstance>),
    Child(Option<Box<Caller>>, Arc<Shared>),
}

impl DirectInstance {
    /// Makes an instance; `program` is the one a child runs ([`crate::child::serve`]).
    pub fn create(
        plugin: Arc<Plugin>,
        isolation: Isolation,
        program: &Path,
        settings: RunnerSettings,
        create: &Create,
    ) -> Result<Self, PluginError> {
        let bytes = encode(create)?;
        let name = "direct".to_owned();
        let way = match isolation {
            Isolation::InProcess => {
                let hosted = HostedInstance::new(plugin, name);
                let schema = CREATE_SCHEMA;
                hosted.run(&Task::Create { schema, bytes })?;
                Way::Here(Box::new(hosted))
            }
            Isolation::Child(limits) => {
                let shared = Arc::new(Shared::new(plugin, name, settings, limits));
                let caller = Caller::start(Arc::clone(&shared), program, CREATE_SCHEMA, &bytes)?;
                Way::Child(Some(Box::new(caller)), shared)
            }
        };
        Ok(Self {
            way,
            judge: Judge::new(settings),
            buffer: Vec::new(),
        })
    }

    /// Hands a batch in; gives the effects and frames, without a snapshot.
    pub fn handle(&mut self, batch: &EventBatch) -> Result<(Vec<Effect>, Vec<Arc<Frame>>), PluginError> {
        let answer = self.invoke(batch, false)?;
        self.judge
            .effects(self.manifest(), self.pool(), answer.schema, answer.bytes.bytes())
    }

    /// As [`crate::Instance::call`].
    pub fn call(&mut self, batch: &EventBatch) -> Result<PluginAnswer, PluginError> {
        let answer = self.invoke(batch, true)?;
        self.judge.answer(self.manifest(), self.pool(), &answer)
    }

    /// What its plugin says of itself.
    #[must_use]
    pub fn manifest(&self) -> &Manifest {
        match &self.way {
            Way::Here(hosted) => hosted.plugin.manifest(),
            Way::Child(_, shared) => shared.plugin.manifest(),
        }
    }

    fn invoke(&mut self, batch: &EventBatch, then_snapshot: bool) -> Result<RawAnswer, PluginError> {
        self.buffer.clear();
        minicbor::encode(batch, &mut self.buffer).map_err(|e| PluginError::NotUnderstood {
            detail: format!("cannot be encoded: {e}"),
        })?;
        let (method, schema) = (method::HANDLE_EVENTS, EVENT_BATCH_SCHEMA);
        match &mut self.way {
            Way::Here(hosted) => hosted.invoke_untimed(method, schema, &self.buffer, then_snapshot),
            Way::Child(caller, _) => {
                let call = Call {
                    method,
                    schema,
                    bytes: std::mem::take(&mut self.buffer),
                    frames: Vec::new(),
                    then_snapshot,
                };
                let answer = caller.as_mut().ok_or(PluginError::Gone)?.call(&call);
                self.buffer = call.bytes;
                answer
            }
        }
    }

    fn pool(&self) -> &Pool {
        match &self.way {
            Way::Here(hosted) => &hosted.services.pool,
            Way::Child(_, shared) => &shared.pool,
        }
    }
}

impl Drop for DirectInstance {
    fn drop(&mut self) {
        match &mut self.way {
            Way::Here(hosted) => {
                let _ = hosted.run(&Task::Destroy);
            }
            Way::Child(caller, _) => {
                if let Some(caller) = caller.take() {
                    caller.end();
                }
            }
        }
    }
}
