//! The pool of threads on which plugins run. Each instance lives on one lane; a lane is a queue and a watched thread.

use crate::answer::{Judge, RawAnswer};
use crate::body::InstanceBody;
use crate::child::ChildCalls;
use crate::frames::Frame;
use crate::instance::Way;
use crate::lane::{Job, Lane, Task};
use crate::{Instance, Isolation, Plugin, PluginError, watchdog};
use parking_lot::Mutex;
use skein_domain::exchange::{CREATE_SCHEMA, Create};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;
use tokio::sync::oneshot;

/// Most requests are shorter, in bytes.
const USUAL_REQUEST_BYTES: usize = 512;

/// Bounds of everything that instances do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RunnerSettings {
    /// Threads that make calls, at least one. A handful serves hundreds of instances.
    pub threads: usize,
    /// A call that has not returned after this time is given up, with its instance and its thread. It is noticed up to a quarter
    /// later.
    pub call_deadline: Duration,
    /// The same for the creation and the end of an instance, which may have files to read.
    pub create_deadline: Duration,
    /// Longest answer to an event batch in bytes.
    pub max_answer_bytes: usize,
    /// Longest snapshot in bytes.
    pub max_snapshot_bytes: usize,
    /// Most effects of one batch.
    pub max_effects: u64,
    /// A plugin in which so many threads hang gets no more.
    pub max_hanging_threads: u32,
}

impl Default for RunnerSettings {
    fn default() -> Self {
        Self {
            threads: 2,
            call_deadline: Duration::from_millis(50),
            create_deadline: Duration::from_secs(1),
            max_answer_bytes: 64 << 10,
            max_snapshot_bytes: 256 << 10,
            max_effects: 200,
            max_hanging_threads: 8,
        }
    }
}

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
            Isolation::InProcess => Way::Here(Calls::create(self, plugin, name, CREATE_SCHEMA, bytes).await?),
            Isolation::Child(limits) => {
                Way::Child(ChildCalls::create(self, plugin, name, limits, CREATE_SCHEMA, bytes).await?)
            }
        };
        Ok(Instance::new(way, isolation, Judge::new(self.settings)))
    }

    /// The program to be started for a child.
    pub(crate) fn host_program(&self) -> PathBuf {
        // Not its path: its file may have been exchanged for a newer version since.
        let own = || PathBuf::from("/proc/self/exe");
        self.host_program.lock().clone().unwrap_or_else(own)
    }

    /// Counts a child for as long as the result is kept.
    pub(crate) fn count_child(&self) -> Arc<()> {
        Arc::clone(&self.children)
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
    pub(crate) body: Arc<InstanceBody>,
    lane: Arc<Lane>,
    pub(crate) settings: RunnerSettings,
}

impl Calls {
    async fn create(
        runners: &Runners,
        plugin: Arc<Plugin>,
        name: String,
        schema: u32,
        bytes: Vec<u8>,
    ) -> Result<Self, PluginError> {
        let hanging = plugin.hanging_threads();
        if hanging >= runners.settings.max_hanging_threads {
            return Err(PluginError::Quarantined { hanging });
        }
        runners.watch()?;
        let lane = runners
            .lanes
            .iter()
            .min_by_key(|lane| lane.instances.load(Ordering::Relaxed));
        let lane = Arc::clone(lane.ok_or(PluginError::Gone)?);
        lane.instances.fetch_add(1, Ordering::Relaxed);
        // From here on `drop` takes the instance off its lane again, whatever becomes of it.
        let calls = Self {
            body: Arc::new(InstanceBody::new(plugin, name)),
            lane,
            settings: runners.settings,
        };
        calls
            .ask(Task::Create { schema, bytes }, calls.settings.create_deadline)
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
            body: Arc::clone(&self.body),
            task,
            deadline,
            reply: Some(reply),
        };
        self.lane.push(job).map_err(|refused| refused.1)?;
        answer.await.unwrap_or(Err(PluginError::Gone))
    }
}

impl Drop for Calls {
    fn drop(&mut self) {
        self.lane.instances.fetch_sub(1, Ordering::Relaxed);
        let deadline = self.settings.create_deadline;
        let job = Job {
            body: Arc::clone(&self.body),
            task: Task::Destroy,
            deadline,
            reply: None,
        };
        if let Err(refused) = self.lane.push(job) {
            let (job, error) = *refused;
            tracing::error!(target: "plugin", instance = %job.body.name, "was not ended: {error}");
        }
    }
}
