//! What the host keeps of one instance, and what a worker's thread does with it.
//!
//! Must never do: give a handle to two threads at once. The handle is taken out of the hosted instance for the time of a call.

use crate::answer::{AnswerBytes, RawAnswer};
use crate::entry::Handle;
use crate::frames::{Frame, Pool};
use crate::services::{Readable, Services};
use crate::sink::LogSink;
use crate::statistics::CallTimes;
use crate::task::Task;
use crate::{Plugin, PluginError};
use parking_lot::Mutex;
use skein_domain::manifest::EffectKind;
use skein_plugin_abi::method;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// What is kept of an instance. Lives as long as anyone may call it, and as long as a thread hangs in it: its services are borrowed
/// by the plugin.
#[derive(Debug)]
pub(crate) struct HostedInstance {
    pub(crate) plugin: Arc<Plugin>,
    pub(crate) name: String,
    pub(crate) services: Services,
    pub(crate) times: CallTimes,
    state: Mutex<State>,
}

#[derive(Debug)]
enum State {
    /// Not made yet.
    Unborn,
    /// Can be called.
    Ready(Handle),
    /// A call is being made; the thread that makes it has the handle.
    Busy,
    /// It panicked and only waits for its end.
    Poisoned(Handle, String),
    /// It was given up in a call that did not return in time. The handle is here once the call has come back after all.
    Abandoned(Duration, Option<Handle>),
    /// It was ended, or never came to be.
    Ended,
}

impl HostedInstance {
    pub(crate) fn new(plugin: Arc<Plugin>, name: String) -> Self {
        let pool = Pool::new(plugin.manifest().effects.contains(&EffectKind::Frame));
        let sink = LogSink::new(plugin.manifest().name.clone(), name.clone());
        Self {
            plugin,
            name,
            services: Services::new(sink, pool),
            times: CallTimes::default(),
            state: Mutex::new(State::Unborn),
        }
    }

    /// Does what a job asks for. Only on a worker's thread.
    pub(crate) fn run(&self, task: &Task) -> Result<Option<RawAnswer>, PluginError> {
        match task {
            Task::Create { schema, bytes } => self.create(*schema, bytes).map(|()| None),
            Task::Invoke {
                method,
                schema,
                bytes,
                frames,
                then_snapshot,
            } => {
                let call = || self.invoke(*method, *schema, bytes, *then_snapshot);
                self.services.with_frames(readable(frames), call).map(Some)
            }
            Task::Destroy => self.destroy().map(|()| None),
        }
    }

    fn create(&self, schema: u32, bytes: &[u8]) -> Result<(), PluginError> {
        *self.state.lock() = State::Busy;
        match self.plugin.entry.create(&self.services.for_plugin(), schema, bytes) {
            Ok(handle) => {
                self.put_back(handle, None);
                Ok(())
            }
            Err(error) => {
                let mut state = self.state.lock();
                if matches!(*state, State::Busy) {
                    *state = State::Ended;
                }
                Err(error)
            }
        }
    }

    /// Calls a method and times it.
    fn invoke(&self, method: u32, schema: u32, bytes: &[u8], then_snapshot: bool) -> Result<RawAnswer, PluginError> {
        // One that was lost before does not come as far as the plugin, and is none of its calls.
        let handle = self.take()?;
        let started = Instant::now();
        let result = self.invoke_with(&handle, method, schema, bytes, then_snapshot);
        self.times.record(started.elapsed(), result.is_err());
        self.put_back(handle, poison_of(&result));
        result
    }

    /// Calls a method. The clock is a good part of what a short call costs.
    pub(crate) fn invoke_untimed(
        &self,
        method: u32,
        schema: u32,
        bytes: &[u8],
        then_snapshot: bool,
    ) -> Result<RawAnswer, PluginError> {
        let handle = self.take()?;
        let result = self.invoke_with(&handle, method, schema, bytes, then_snapshot);
        self.put_back(handle, poison_of(&result));
        result
    }

    fn invoke_with(
        &self,
        handle: &Handle,
        method: u32,
        schema: u32,
        bytes: &[u8],
        then_snapshot: bool,
    ) -> Result<RawAnswer, PluginError> {
        let entry = &self.plugin.entry;
        let (schema, bytes) = entry.invoke(handle, method, schema, bytes)?;
        let snapshot = if then_snapshot {
            Some(AnswerBytes::Plugin(entry.invoke(handle, method::SNAPSHOT, 0, &[])?.1))
        } else {
            None
        };
        Ok(RawAnswer {
            schema,
            bytes: AnswerBytes::Plugin(bytes),
            snapshot,
        })
    }

    fn destroy(&self) -> Result<(), PluginError> {
        let mut state = self.state.lock();
        let handle = match std::mem::replace(&mut *state, State::Busy) {
            State::Ready(handle) | State::Poisoned(handle, _) => handle,
            // The thread that hangs in it ends it, should it ever come back.
            abandoned @ State::Abandoned(..) => {
                *state = abandoned;
                return Ok(());
            }
            State::Unborn | State::Busy | State::Ended => {
                *state = State::Ended;
                return Ok(());
            }
        };
        drop(state);
        let result = self.plugin.entry.destroy(handle);
        let mut state = self.state.lock();
        if matches!(*state, State::Busy) {
            *state = State::Ended;
        }
        result
    }

    fn take(&self) -> Result<Handle, PluginError> {
        let mut state = self.state.lock();
        match std::mem::replace(&mut *state, State::Busy) {
            State::Ready(handle) => Ok(handle),
            other => {
                *state = other;
                Err(state.why_not())
            }
        }
    }

    /// After a call: the handle goes back, wherever it is wanted by now.
    fn put_back(&self, handle: Handle, poison: Option<String>) {
        let mut state = self.state.lock();
        *state = match (&*state, poison) {
            (State::Abandoned(after, _), _) => State::Abandoned(*after, Some(handle)),
            (_, Some(message)) => State::Poisoned(handle, message),
            (_, None) => State::Ready(handle),
        };
    }

    /// The call being made did not return in time: nobody will call the instance again.
    pub(crate) fn abandon(&self, after: Duration) {
        let mut state = self.state.lock();
        let handle = match std::mem::replace(&mut *state, State::Busy) {
            // It came back in this very moment.
            State::Ready(handle) | State::Poisoned(handle, _) => Some(handle),
            _ => None,
        };
        *state = State::Abandoned(after, handle);
        self.plugin.hanging.fetch_add(1, Ordering::Relaxed);
    }

    /// The call that was given up has come back after all. Its thread ends the instance; if that hangs too, nothing else is lost.
    pub(crate) fn end_late(&self) {
        let handle = match &mut *self.state.lock() {
            State::Abandoned(_, handle) => handle.take(),
            _ => None,
        };
        let ended = handle.map_or(Ok(()), |handle| self.plugin.entry.destroy(handle));
        self.plugin.hanging.fetch_sub(1, Ordering::Relaxed);
        tracing::warn!(
            target: "plugin", plugin = %self.plugin.manifest().name, instance = %self.name,
            "the call that was given up has come back; the instance is ended{}",
            ended.err().map_or(String::new(), |error| format!(", not well: {error}"))
        );
    }
}

/// With what message an instance panicked, if it did.
fn poison_of(result: &Result<RawAnswer, PluginError>) -> Option<String> {
    match result {
        Err(PluginError::Panicked { message }) => Some(message.clone()),
        _ => None,
    }
}

/// Frames as services show them.
fn readable(frames: &[Arc<Frame>]) -> Vec<Arc<dyn Readable>> {
    frames
        .iter()
        .map(|frame| Arc::clone(frame) as Arc<dyn Readable>)
        .collect()
}

impl State {
    fn why_not(&self) -> PluginError {
        match self {
            Self::Poisoned(_, message) => PluginError::Panicked {
                message: message.clone(),
            },
            Self::Abandoned(after, _) => PluginError::DeadlineExceeded { after: *after },
            Self::Unborn | Self::Busy | Self::Ready(_) | Self::Ended => PluginError::Gone,
        }
    }
}
