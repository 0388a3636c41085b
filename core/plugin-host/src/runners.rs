//! The pool of threads on which plugins run. Each instance lives on one lane; a lane is a queue and a watched thread.

use crate::answer::Judge;
use crate::body::InstanceBody;
use crate::calls::{Calls, encode};
use crate::child::ChildCalls;
use crate::instance::Way;
use crate::lane::Lane;
use crate::runner_settings::RunnerSettings;
use crate::{Instance, Isolation, Plugin, PluginError, watchdog};
use parking_lot::Mutex;
use skein_domain::exchange::{CREATE_SCHEMA, Create};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// How the pool is doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RunnersHealth {
    /// Lanes, each with one thread.
    pub lanes: usize,
    /// Living instances in this process.
    pub instances: usize,
    /// Child processes.
    pub children: usize,
}

/// The pool. Its threads end when it and all its instances are gone.
#[derive(Debug)]
pub struct Runners {
    settings: RunnerSettings,
    lanes: Vec<Arc<Lane>>,
    watched: AtomicBool,
    host_program: Mutex<Option<PathBuf>>,
    /// Each child's thread has one.
    children: Arc<()>,
}

impl Runners {
    /// A pool of `threads` threads with a deadline per call.
    #[must_use]
    pub fn new(threads: usize, call_deadline: Duration) -> Arc<Self> {
        let defaults = RunnerSettings::default();
        let create_deadline = defaults.create_deadline.max(call_deadline);
        Self::with_settings(RunnerSettings {
            threads,
            call_deadline,
            create_deadline,
            ..defaults
        })
    }

    /// A pool with all bounds given. Threads start with the first instance that needs them.
    #[must_use]
    pub fn with_settings(settings: RunnerSettings) -> Arc<Self> {
        let lanes = (0..settings.threads.max(1))
            .map(|index| Arc::new(Lane::new(index)))
            .collect();
        Arc::new(Self {
            settings,
            lanes,
            watched: AtomicBool::new(false),
            host_program: Mutex::default(),
            children: Arc::default(),
        })
    }

    /// The bounds.
    #[must_use]
    pub fn settings(&self) -> &RunnerSettings {
        &self.settings
    }

    /// How the pool is doing.
    #[must_use]
    pub fn health(&self) -> RunnersHealth {
        let instances = self
            .lanes
            .iter()
            .map(|lane| lane.instances.load(Ordering::Relaxed))
            .sum();
        RunnersHealth {
            lanes: self.lanes.len(),
            instances,
            children: Arc::strong_count(&self.children) - 1,
        }
    }

    /// Which program is started with the argument `plugin-host` for an instance in a process of its own; it calls
    /// [`crate::child::serve`]. Without this: the running program itself.
    pub fn set_host_program(&self, program: PathBuf) {
        *self.host_program.lock() = Some(program);
    }

    /// Makes an instance. In logs it is called `vehicle-<id>`, a payload `vehicle-<id>/<payload>`.
    pub async fn create(
        &self,
        plugin: Arc<Plugin>,
        isolation: Isolation,
        create: Create,
    ) -> Result<Instance, PluginError> {
        let bytes = encode(&create)?;
        let name = match &create.payload {
            Some(payload) => format!("vehicle-{}/{payload}", create.vehicle),
            None => format!("vehicle-{}", create.vehicle),
        };
        let way = match isolation {
            Isolation::InProcess => Way::Here(self.create_here(plugin, name, bytes).await?),
            Isolation::Child(limits) => {
                let child = (self.host_program(), self.settings, Arc::clone(&self.children));
                Way::Child(ChildCalls::create(child, plugin, name, limits, CREATE_SCHEMA, bytes).await?)
            }
        };
        Ok(Instance::new(way, isolation, Judge::new(self.settings)))
    }

    /// On the lane with the fewest instances.
    async fn create_here(&self, plugin: Arc<Plugin>, name: String, bytes: Vec<u8>) -> Result<Calls, PluginError> {
        let hanging = plugin.hanging_threads();
        if hanging >= self.settings.max_hanging_threads {
            return Err(PluginError::Quarantined { hanging });
        }
        self.watch()?;
        let lanes = self.lanes.iter();
        let lane = lanes.min_by_key(|lane| lane.instances.load(Ordering::Relaxed));
        let lane = Arc::clone(lane.ok_or(PluginError::Gone)?);
        let body = InstanceBody::new(plugin, name);
        Calls::create(lane, self.settings, body, CREATE_SCHEMA, bytes).await
    }

    /// The program to be started for a child.
    fn host_program(&self) -> PathBuf {
        // Not its path: its file may have been exchanged for a newer version since.
        let own = || PathBuf::from("/proc/self/exe");
        self.host_program.lock().clone().unwrap_or_else(own)
    }

    fn watch(&self) -> Result<(), PluginError> {
        if self.watched.swap(true, Ordering::Relaxed) {
            return Ok(());
        }
        let lanes = self.lanes.iter().map(|lane| Arc::clone(&lane.shared)).collect();
        watchdog::watch(lanes, self.settings.call_deadline).map_err(|e| {
            self.watched.store(false, Ordering::Relaxed);
            PluginError::NoThread { detail: e.to_string() }
        })
    }
}
