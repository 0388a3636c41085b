//! The pool of threads on which plugins run. Each instance lives on one worker; a worker is a queue and a watched thread.

use crate::answer::Judge;
use crate::calls::{Calls, encode};
use crate::child::ChildCalls;
use crate::hosted::HostedInstance;
use crate::instance::Way;
use crate::runner_settings::RunnerSettings;
use crate::worker::Worker;
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
    /// Workers, each with one thread.
    pub workers: usize,
    /// Living instances in this process.
    pub instances: usize,
    /// Child processes.
    pub children: usize,
}

/// The pool. Its threads end when it and all its instances are gone.
#[derive(Debug)]
pub struct Runners {
    settings: RunnerSettings,
    workers: Vec<Arc<Worker>>,
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
        let workers = (0..settings.threads.max(1))
            .map(|index| Arc::new(Worker::new(index)))
            .collect();
        Arc::new(Self {
            settings,
            workers,
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
            .workers
            .iter()
            .map(|worker| worker.instances.load(Ordering::Relaxed))
            .sum();
        RunnersHealth {
            workers: self.workers.len(),
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

    /// On the worker with the fewest instances.
    async fn create_here(&self, plugin: Arc<Plugin>, name: String, bytes: Vec<u8>) -> Result<Calls, PluginError> {
        let hanging = plugin.hanging_threads();
        if hanging >= self.settings.max_hanging_threads {
            return Err(PluginError::Quarantined { hanging });
        }
        self.watch()?;
        let workers = self.workers.iter();
        let worker = workers.min_by_key(|worker| worker.instances.load(Ordering::Relaxed));
        let worker = Arc::clone(worker.ok_or(PluginError::Gone)?);
        let hosted = HostedInstance::new(plugin, name);
        Calls::create(worker, self.settings, hosted, CREATE_SCHEMA, bytes).await
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
        let workers = self.workers.iter().map(|worker| Arc::clone(&worker.shared)).collect();
        watchdog::watch(workers, self.settings.call_deadline).map_err(|e| {
            self.watched.store(false, Ordering::Relaxed);
            PluginError::NoThread { detail: e.to_string() }
        })
    }
}
