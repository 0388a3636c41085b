//! One worker: a queue of calls and the one thread that makes them, in order. If a call does not return in time, the thread is given up
//! with the instance it is in, and a fresh thread goes on with the same queue.
//!
//! Must never do: hold the lock while a plugin runs, take more than one job off the queue at a time (what is taken is lost to a hang).

use crate::PluginError;
use crate::answer::RawAnswer;
use crate::call_clock::CallClock;
use crate::hosted::HostedInstance;
use crate::task::Task;
use crate::thread_time::ThreadTime;
use parking_lot::{Condvar, Mutex, MutexGuard};
use skein_realtime::Precedence;
use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::AtomicUsize;
use std::time::Duration;
use tokio::sync::oneshot;
use tokio::time::Instant;

/// How often a thread that found its queue empty lets others run and looks again before it sleeps. A period's calls arrive one by
/// one within microseconds; this makes them share one wake-up.
const LOOKS_BEFORE_SLEEP: u32 = 4;

/// To whom the result goes.
pub(crate) type Reply = oneshot::Sender<Result<Option<RawAnswer>, PluginError>>;

/// One job of a worker.
#[derive(Debug)]
pub(crate) struct Job {
    pub(crate) hosted: Arc<HostedInstance>,
    pub(crate) task: Task,
    pub(crate) deadline: Duration,
    /// None: nobody waits for the result.
    pub(crate) reply: Option<Reply>,
}

/// A worker as those see it who put jobs on it. Its thread ends when the last of these goes and the queue is empty.
#[derive(Debug)]
pub(crate) struct Worker {
    pub(crate) shared: Arc<WorkerShared>,
    /// How many instances live on it.
    pub(crate) instances: AtomicUsize,
}

#[derive(Debug)]
pub(crate) struct WorkerShared {
    index: usize,
    state: Mutex<WorkerState>,
    wake: Condvar,
}

#[derive(Debug, Default)]
struct WorkerState {
    queue: VecDeque<Job>,
    /// The call being made.
    running: Option<Running>,
    /// Counts the threads; a thread with another number has been given up.
    generation: u32,
    /// Whether the present thread was started.
    has_thread: bool,
    /// How to look at it from outside; there once it runs.
    thread_time: Option<ThreadTime>,
    /// Whether it sleeps.
    asleep: bool,
    closed: bool,
}

#[derive(Debug)]
struct Running {
    hosted: Arc<HostedInstance>,
    reply: Option<Reply>,
    started: Instant,
    clock: CallClock,
}

impl Worker {
    pub(crate) fn new(index: usize) -> Self {
        let shared = WorkerShared {
            index,
            state: Mutex::default(),
            wake: Condvar::new(),
        };
        Self {
            shared: Arc::new(shared),
            instances: AtomicUsize::new(0),
        }
    }

    /// Puts a job on the queue. Gives it back if there is no thread to do it and none can be started.
    pub(crate) fn push(&self, job: Job) -> Result<(), Box<(Job, PluginError)>> {
        let mut state = self.shared.state.lock();
        if let Err(error) = self.shared.ensure_thread(&mut state) {
            return Err(Box::new((job, error)));
        }
        state.queue.push_back(job);
        if std::mem::take(&mut state.asleep) {
            drop(state);
            self.shared.wake.notify_one();
        }
        Ok(())
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        self.shared.state.lock().closed = true;
        self.shared.wake.notify_all();
    }
}

impl WorkerShared {
    fn ensure_thread(self: &Arc<Self>, state: &mut WorkerState) -> Result<(), PluginError> {
        if state.has_thread {
            return Ok(());
        }
        let (shared, generation) = (Arc::clone(self), state.generation);
        std::thread::Builder::new()
            .name(format!("plugins-{}.{generation}", self.index))
            .spawn(move || shared.run(generation))
            .map_err(|e| PluginError::NoThread { detail: e.to_string() })?;
        state.has_thread = true;
        Ok(())
    }

    /// The thread's life.
    fn run(&self, generation: u32) {
        self.introduce(generation);
        while let Some((hosted, task)) = self.next(generation) {
            let result = hosted.run(&task);
            let mut state = self.state.lock();
            if state.generation != generation {
                drop(state);
                hosted.end_late();
                return;
            }
            let running = state.running.take();
            drop(state);
            if let (Task::Destroy, Err(error)) = (&task, &result) {
                tracing::warn!(target: "plugin", instance = %hosted.name, "did not end well: {error}");
            }
            if let Some(reply) = running.and_then(|running| running.reply) {
                // Nobody may be waiting any more.
                let _ = reply.send(result);
            }
        }
    }

    /// A thread's first act: says how it can be looked at, and asks to be ahead.
    fn introduce(&self, generation: u32) {
        skein_realtime::ask(Precedence::Plugin);
        let mut state = self.state.lock();
        if state.generation == generation {
            state.thread_time = Some(ThreadTime::of_this_thread());
        }
    }

    /// Waits for the next job and notes it as running. None: this thread's time is over.
    fn next(&self, generation: u32) -> Option<(Arc<HostedInstance>, Task)> {
        let mut looks = 0;
        let mut state = self.state.lock();
        loop {
            if state.generation != generation {
                return None;
            }
            if let Some(Job {
                hosted,
                task,
                deadline,
                reply,
            }) = state.queue.pop_front()
            {
                let started = Instant::now();
                let running = Running {
                    hosted: Arc::clone(&hosted),
                    reply,
                    started,
                    clock: CallClock::new(started, deadline),
                };
                state.running = Some(running);
                return Some((hosted, task));
            }
            if state.closed {
                return None;
            }
            if looks < LOOKS_BEFORE_SLEEP {
                looks += 1;
                drop(state);
                std::thread::yield_now();
                state = self.state.lock();
            } else {
                looks = 0;
                state.asleep = true;
                self.wake.wait(&mut state);
                state.asleep = false;
            }
        }
    }

    /// The watchdog looks in: gives the thread up if its call is over its deadline.
    pub(crate) fn inspect(self: &Arc<Self>, now: Instant) {
        let mut state = self.state.lock();
        let thread_time = state.thread_time;
        let Some(running) = state.running.as_mut() else { return };
        if running.clock.is_over(now, || thread_time?.starved()) {
            let after = now.duration_since(running.started);
            self.give_up(state, after);
        }
    }

    /// Gives up the thread and the instance it is in.
    fn give_up(self: &Arc<Self>, mut state: MutexGuard<'_, WorkerState>, after: Duration) {
        let Some(Running { hosted, reply, .. }) = state.running.take() else {
            return;
        };
        state.generation = state.generation.wrapping_add(1);
        state.has_thread = false;
        if let Some(time) = state.thread_time.take() {
            time.yield_to_all(); // It may be spinning.
        }
        hosted.abandon(after);
        // The others' calls go on with a fresh thread. If none can be started now, the next call tries again.
        if !state.queue.is_empty()
            && let Err(error) = self.ensure_thread(&mut state)
        {
            tracing::error!(target: "plugin", "{error}");
        }
        drop(state);
        tracing::error!(
            target: "plugin", plugin = %hosted.plugin.manifest().name, instance = %hosted.name,
            "a call did not return within {} ms: its thread and the instance are given up", after.as_millis()
        );
        if let Some(reply) = reply {
            let _ = reply.send(Err(PluginError::DeadlineExceeded { after }));
        }
    }

    /// Whether nothing will ever run here again.
    pub(crate) fn is_over(&self) -> bool {
        let state = self.state.lock();
        state.closed && state.queue.is_empty() && state.running.is_none()
    }
}
