//! The plugins of a node: those found, the threads that their calls run on, their restarts.
//!
//! Bound: the newest restarts are kept. Must never do: call an instance.

use crate::plugin::PluginRecord;
use parking_lot::Mutex;
use skein_config::PluginSettings;
use skein_plugin_host::{Catalog, Runners};
use skein_view::RestartRecord;
use std::collections::VecDeque;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

/// Restarts that are kept for reports.
const KEPT_RESTARTS: usize = 4_096;

/// What the instances of a node have in common.
pub struct Plugins {
    /// Plugins found.
    pub catalog: Catalog,
    /// Held while the instances of a plugin are exchanged for another version. There is nothing in it to be changed.
    pub exchanging: tokio::sync::Mutex<()>,
    runners: Arc<Runners>,
    /// Threads of their own: a camera that draws a picture must keep no vehicle waiting.
    payload_runners: Arc<Runners>,
    /// The newest last.
    restarts: Mutex<VecDeque<RestartRecord>>,
}

impl Plugins {
    /// Those of the catalog, none of them running.
    pub(crate) fn new(catalog: Catalog, settings: &PluginSettings) -> Self {
        let deadline = Duration::from_secs_f64(settings.call_deadline_s);
        let runners = || Runners::new(settings.runner_threads, deadline);
        Self {
            catalog,
            exchanging: tokio::sync::Mutex::default(),
            runners: runners(),
            payload_runners: runners(),
            restarts: Mutex::default(),
        }
    }

    /// The threads that an instance's calls run on.
    pub fn runners_of(&self, instance: &PluginRecord) -> &Arc<Runners> {
        match instance.payload {
            None => &self.runners,
            Some(_) => &self.payload_runners,
        }
    }

    /// The program that is started for an instance in a child process.
    pub fn set_host_program(&self, program: PathBuf) {
        self.runners.set_host_program(program.clone());
        self.payload_runners.set_host_program(program);
    }

    /// An instance was started again by its owner.
    pub fn note_restart(&self, restart: RestartRecord) {
        let mut restarts = self.restarts.lock();
        if restarts.len() == KEPT_RESTARTS {
            restarts.pop_front();
        }
        restarts.push_back(restart);
    }

    /// The restarts that are kept, oldest first.
    pub fn restarts(&self) -> Vec<RestartRecord> {
        self.restarts.lock().iter().cloned().collect()
    }
}
