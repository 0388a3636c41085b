//! The calls of one instance in a child process, made one after the other by a thread of their own, so that a slow child keeps nobody
//! else waiting.
//!
//! Must never do: wait for a child without a deadline, or let a child go on after it broke one.

use super::logs;
use super::message::{FramePlace, Settings, decode_error};
use super::process::{ChildProcess, ErrorTail, Started, socket_pair};
use super::share::{LOOK_EVERY, ShareWatch};
use super::wire::{Head, MAX_FILES, Message, Wire, kind, wait};
use crate::answer::{AnswerBytes, RawAnswer};
use crate::call_clock::{CallClock, LOOKS_PER_DEADLINE};
use crate::frames::{Frame, Pool};
use crate::sink::{LogSink, TakeLog};
use crate::statistics::CallTimes;
use crate::{ChildLimits, Plugin, PluginError, RunnerSettings};
use rustix::event::PollFlags;
use rustix::net::SocketType;
use skein_domain::manifest::EffectKind;
use skein_plugin_abi::LogLevel;
use std::io::ErrorKind;
use std::os::fd::{AsFd, OwnedFd};
use std::path::Path;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};
use tokio::sync::oneshot;

/// What an answer may have beside answer and snapshot, in bytes.
const ANSWER_EXTRA_BYTES: usize = 16 << 10;

/// A call to be made.
#[derive(Debug)]
pub(crate) struct Call {
    pub(crate) method: u32,
    pub(crate) schema: u32,
    pub(crate) bytes: Vec<u8>,
    pub(crate) frames: Vec<Arc<Frame>>,
    pub(crate) then_snapshot: bool,
}

/// A call and to whom its answer goes.
pub(crate) type Job = (Call, oneshot::Sender<Result<RawAnswer, PluginError>>);

/// What the thread shares with those who call.
#[derive(Debug)]
pub(crate) struct Shared {
    pub(crate) plugin: Arc<Plugin>,
    pub(crate) name: String,
    pub(crate) settings: RunnerSettings,
    pub(crate) limits: ChildLimits,
    pub(crate) times: CallTimes,
    pub(crate) sink: LogSink,
    pub(crate) pool: Pool,
    /// There once it was started.
    pub(crate) process: OnceLock<Arc<ChildProcess>>,
}

impl Shared {
    pub(crate) fn new(plugin: Arc<Plugin>, name: String, settings: RunnerSettings, limits: ChildLimits) -> Self {
        let manifest = plugin.manifest();
        Self {
            sink: LogSink::new(manifest.name.clone(), name.clone()),
            pool: Pool::new(manifest.effects.contains(&EffectKind::Frame)),
            plugin,
            name,
            settings,
            limits,
            times: CallTimes::default(),
            process: OnceLock::new(),
        }
    }
}

/// The thread's side of a child.
#[derive(Debug)]
pub(crate) struct Caller {
    shared: Arc<Shared>,
    process: Arc<ChildProcess>,
    wire: Wire<OwnedFd>,
    errors: ErrorTail,
    /// Whether the child can still write to its standard error.
    errors_open: bool,
    logs: OwnedFd,
    share: ShareWatch,
    /// Why it can not be called any more.
    lost: Option<PluginError>,
}

impl Caller {
    /// Starts the child and makes the instance. The calling thread must live as long as the child is to.
    pub(crate) fn start(shared: Arc<Shared>, program: &Path, schema: u32, create: &[u8]) -> Result<Self, PluginError> {
        let not_started = |e: std::io::Error| PluginError::NotStarted { detail: e.to_string() };
        let (logs, their_logs) = socket_pair(SocketType::SEQPACKET).map_err(|e| not_started(e.into()))?;
        let Started {
            process,
            socket,
            errors,
        } = ChildProcess::start(program).map_err(|e| PluginError::NotStarted {
            detail: format!("{}: {e}", program.display()),
        })?;
        let process = Arc::new(process);
        process.ask_to_be_ahead();
        let _ = shared.process.set(Arc::clone(&process));
        let share = ShareWatch::new(shared.limits.cpu_share);
        let mut caller = Self {
            wire: Wire::new(socket, false),
            process,
            errors,
            errors_open: true,
            logs,
            share,
            lost: None,
            shared,
        };
        let memory = caller.shared.pool.memory_or_new();
        let settings = caller.settings(memory.is_some());
        let settings = minicbor::to_vec(settings).map_err(|e| PluginError::NotStarted { detail: e.to_string() })?;
        let head = Head {
            kind: kind::START,
            numbers: [settings.len() as u32, schema, 0, 0],
        };
        let mut files = vec![caller.shared.plugin.library_file(), their_logs.as_fd()];
        files.extend(memory.as_ref().map(|memory| memory.file()));
        let deadline = caller.shared.settings.create_deadline;
        let sent = caller
            .wire
            .send(head, &[&settings, create], &files, Some(Instant::now() + deadline));
        drop(their_logs);
        let made = match sent {
            Ok(()) => caller.hear(deadline),
            Err(error) => Err(caller.broken(&error, deadline)),
        };
        if let Err(error) = made {
            // What it said of why it did not come to be.
            logs::fetch(&caller.logs, &caller.shared.sink);
            caller.take_errors();
            let _ = caller.process.end(&mut caller.errors);
            return Err(error);
        }
        Ok(caller)
    }

    fn settings(&self, lends_frames: bool) -> Settings {
        let Shared { settings, limits, .. } = &*self.shared;
        Settings {
            memory_bytes: limits.memory_mib.saturating_mul(1 << 20),
            open_files: limits.open_files,
            max_answer_bytes: settings.max_answer_bytes as u64,
            max_snapshot_bytes: settings.max_snapshot_bytes as u64,
            lends_frames,
        }
    }

    /// Makes calls until nobody wants any more; then ends the instance and its process.
    pub(crate) fn run(mut self, jobs: &Receiver<Job>) {
        loop {
            match jobs.recv_timeout(LOOK_EVERY) {
                Ok((call, reply)) => {
                    let answer = match self.lost.clone() {
                        Some(lost) => Err(lost),
                        None => self.call(&call),
                    };
                    drop(call); // The frames go before anyone hears that the call is over.
                    // Nobody may be waiting any more.
                    let _ = reply.send(answer);
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
            self.look_after();
        }
        self.end();
    }

    /// Makes a call.
    pub(crate) fn call(&mut self, call: &Call) -> Result<RawAnswer, PluginError> {
        let began = Instant::now();
        let result = self.exchange(call);
        self.shared.times.record(began.elapsed(), result.is_err());
        if let Err(error) = &result
            && error.needs_restart()
        {
            self.lost = Some(error.clone());
        }
        result
    }

    fn exchange(&mut self, call: &Call) -> Result<RawAnswer, PluginError> {
        let frames = call.frames.get(..MAX_FILES).unwrap_or(&call.frames);
        let head = Head {
            kind: kind::INVOKE,
            numbers: [
                call.method,
                call.schema,
                u32::from(call.then_snapshot),
                frames.len() as u32,
            ],
        };
        let deadline = self.shared.settings.call_deadline;
        // The socket is empty and takes a call at once. Where it does not, the child is stuck, or the machine stood still: hence the longer time.
        let until = Some(Instant::now() + self.shared.settings.create_deadline);
        let sent = if frames.is_empty() {
            self.wire.send(head, &[&call.bytes], &[], until)
        } else {
            let (files, places): (Vec<_>, Vec<_>) = frames.iter().map(|frame| place(frame)).unzip();
            self.wire
                .send(head, &[places.as_flattened(), &call.bytes], &files, until)
        };
        if let Err(error) = sent {
            return Err(self.broken(&error, deadline));
        }
        let Message { head, mut body, .. } = self.hear(deadline)?;
        let [schema, answer_len, has_snapshot, _] = head.numbers;
        let answer_len = answer_len as usize;
        if answer_len > body.len() {
            return Err(self.protocol("an answer that is cut off".to_owned()));
        }
        let snapshot = (has_snapshot != 0).then(|| AnswerBytes::Received(body.split_off(answer_len)));
        Ok(RawAnswer {
            schema,
            bytes: AnswerBytes::Received(body),
            snapshot,
        })
    }

    /// Waits for the answer to the last message. A child that gives none in time is ended.
    fn hear(&mut self, deadline: Duration) -> Result<Message, PluginError> {
        let began = Instant::now();
        let mut clock = CallClock::new(began.into(), deadline);
        let limits = &self.shared.settings;
        let limit =
            limits.max_answer_bytes.max(limits.max_snapshot_bytes) + limits.max_snapshot_bytes + ANSWER_EXTRA_BYTES;
        let mut looked = self.wire.spin_receive(limit);
        let mut is_over = false;
        let heard = loop {
            match looked {
                Ok(Some(message)) => break Ok(message),
                Ok(None) if is_over => break Err(ErrorKind::TimedOut.into()),
                Ok(None) => {}
                Err(error) => break Err(error),
            }
            self.sleep(deadline / LOOKS_PER_DEADLINE);
            // Before it is looked whether it has answered: what came while this thread could not run came in time.
            is_over = clock.is_over(Instant::now().into(), || self.process.starved());
            looked = self.wire.try_receive(limit);
        };
        match heard {
            Ok(message) if message.head.kind == kind::DONE => Ok(message),
            Ok(message) if message.head.kind == kind::FAILED => Err(decode_error(message.head, &message.body)),
            Ok(message) => Err(self.protocol(format!("a message of kind {}", message.head.kind))),
            Err(error) => Err(self.broken(&error, began.elapsed())),
        }
    }

    /// Sleeps until the child says something, taking what it writes to its standard error meanwhile.
    fn sleep(&mut self, time: Duration) {
        let files = [self.wire.socket(), self.errors.file()];
        let watched = if self.errors_open { &files[..] } else { &files[..1] };
        // What goes wrong with it shows when the socket is read.
        let _ = wait(watched, PollFlags::IN, Some(Instant::now() + time));
        self.take_errors();
    }

    /// The exchange failed: ends the child and says why.
    fn broken(&mut self, error: &std::io::Error, after: Duration) -> PluginError {
        let lost = match error.kind() {
            ErrorKind::TimedOut => {
                self.process.kill();
                let _ = self.process.end(&mut self.errors);
                PluginError::DeadlineExceeded { after }
            }
            ErrorKind::UnexpectedEof | ErrorKind::BrokenPipe | ErrorKind::ConnectionReset => {
                self.process.end(&mut self.errors)
            }
            _ => return self.protocol(error.to_string()),
        };
        logs::fetch(&self.logs, &self.shared.sink);
        self.note(&lost);
        lost
    }

    fn protocol(&mut self, detail: String) -> PluginError {
        self.process.kill();
        let _ = self.process.end(&mut self.errors);
        let lost = PluginError::Protocol { detail };
        self.note(&lost);
        lost
    }

    fn note(&self, lost: &PluginError) {
        tracing::error!(
            target: "plugin", plugin = %self.shared.plugin.manifest().name, instance = %self.shared.name,
            "the instance is lost: {lost}"
        );
    }

    /// What is to be done beside the calls: log lines, the share of processor time, the end of an idle child.
    fn look_after(&mut self) {
        logs::fetch(&self.logs, &self.shared.sink);
        let now = Instant::now();
        if self.lost.is_some() || !self.share.is_due(now) {
            return;
        }
        self.take_errors();
        let share = self
            .process
            .processor_s()
            .and_then(|used_s| self.share.look(now, used_s));
        let lost = if let Some(share) = share {
            self.process.kill();
            let ended = self.process.end(&mut self.errors);
            let PluginError::ProcessEnded { said, .. } = ended else {
                return;
            };
            let limit = self.shared.limits.cpu_share;
            let how = format!(
                "it took {:.0} % of a core over 10 s, the limit is {:.0} %",
                100.0 * share,
                100.0 * limit
            );
            PluginError::ProcessEnded { how, said }
        } else if self.process.has_ended().is_some() {
            self.process.end(&mut self.errors)
        } else {
            return;
        };
        self.note(&lost);
        self.lost = Some(lost);
    }

    fn take_errors(&mut self) {
        if self.errors_open {
            let sink = &self.shared.sink;
            let see = |bytes: &[u8]| bytes.split(|b| *b == b'\n').for_each(|line| show(sink, line));
            self.errors_open = self.errors.drain(see);
        }
    }

    /// Ends the instance, then its process.
    pub(crate) fn end(mut self) {
        if self.lost.is_some() {
            return;
        }
        let deadline = self.shared.settings.create_deadline;
        let head = Head {
            kind: kind::DESTROY,
            ..Head::default()
        };
        let ended = match self.wire.send(head, &[], &[], Some(Instant::now() + deadline)) {
            Ok(()) => self.hear(deadline).map(drop),
            Err(error) => Err(self.broken(&error, deadline)),
        };
        logs::fetch(&self.logs, &self.shared.sink);
        self.take_errors();
        if let Err(error) = ended {
            tracing::warn!(target: "plugin", instance = %self.shared.name, "did not end well: {error}");
        }
        // Threads of the plugin's own do not keep the process.
        if let Err(error) = self.process.bury(Duration::ZERO) {
            tracing::error!(target: "plugin", instance = %self.shared.name, "its process was not ended: {error}");
        }
    }
}

/// A line of a child's standard error.
fn show(sink: &LogSink, line: &[u8]) {
    if !line.is_empty() {
        sink.take(LogLevel::WARN, line);
    }
}

fn place(frame: &Frame) -> (std::os::fd::BorrowedFd<'_>, [u8; FramePlace::BYTES]) {
    let (file, offset) = frame.place();
    let place = FramePlace {
        id: frame.header.id,
        offset,
        len: frame.bytes().len() as u64,
    };
    (file, place.encode())
}
