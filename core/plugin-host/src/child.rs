//! Instances in a process of their own.

use crate::answer::RawAnswer;
use crate::frames::{Frame, Pool};
use crate::{CallStatistics, ChildLimits, Manifest, Plugin, PluginError, Runners};
use std::sync::Arc;

/// Why a host process could not serve.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct ServeError(String);

/// Serves one instance over standard input until its end. The whole of the program `skein plugin-host`.
pub fn serve() -> Result<(), ServeError> {
    Err(ServeError("not there yet".to_owned()))
}

#[derive(Debug)]
pub(crate) struct ChildCalls {
    plugin: Arc<Plugin>,
    name: String,
    pool: Pool,
}

impl ChildCalls {
    pub(crate) async fn create(
        _: &Runners,
        _: Arc<Plugin>,
        _: String,
        _: ChildLimits,
        _: u32,
        _: Vec<u8>,
    ) -> Result<Self, PluginError> {
        Err(PluginError::NotStarted {
            detail: "not there yet".to_owned(),
        })
    }

    pub(crate) async fn invoke(
        &self,
        _: u32,
        _: u32,
        _: Vec<u8>,
        _: Vec<Arc<Frame>>,
        _: bool,
    ) -> Result<RawAnswer, PluginError> {
        Err(PluginError::Gone)
    }

    pub(crate) fn kill(&self) -> bool {
        false
    }

    pub(crate) fn pid(&self) -> Option<u32> {
        None
    }

    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    pub(crate) fn manifest(&self) -> &Manifest {
        self.plugin.manifest()
    }

    pub(crate) fn statistics(&self) -> CallStatistics {
        CallStatistics::default()
    }

    pub(crate) fn pool(&self) -> &Pool {
        &self.pool
    }
}
