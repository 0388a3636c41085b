//! The child's side: one instance, served over standard input until it ends or this process is ended.
//!
//! Must never do: start anything heavy, or go on without the one who started it.

use super::logs::LogSocket;
use super::message::{FramePlace, Settings, encode_error};
use super::received::ReceivedFrame;
use super::wire::{Head, Message, Wire, kind, wait};
use crate::entry::{Entry, Handle, PluginBytes};
use crate::frames::{FrameMemory, Pool};
use crate::library::open;
use crate::services::{Readable, Services};
use crate::{LoadError, PluginError};
use rustix::event::PollFlags;
use rustix::io::FdFlags;
use rustix::process::{Resource, Rlimit, Signal};
use skein_plugin_abi::method;
use std::os::fd::{AsFd, AsRawFd, BorrowedFd, FromRawFd, OwnedFd, RawFd};
use std::path::PathBuf;
use std::sync::Arc;

/// No request is longer, in bytes: an event batch with many large messages, or a configuration and a snapshot.
const MAX_REQUEST_BYTES: usize = 64 << 20;

/// Why a host process could not serve.
#[derive(Debug, thiserror::Error)]
pub enum ServeError {
    /// It was not started by a node.
    #[error("this is started by a node for a plugin of its own, not by hand")]
    ByHand,
    /// A call of the system failed, or the node has gone.
    #[error("{what}: {source}")]
    System {
        /// What was tried.
        what: &'static str,
        /// Why it failed.
        source: std::io::Error,
    },
    /// What came makes no sense.
    #[error("the node sent {0}")]
    Protocol(&'static str),
}

fn system<E: Into<std::io::Error>>(what: &'static str) -> impl FnOnce(E) -> ServeError {
    move |source| ServeError::System {
        what,
        source: source.into(),
    }
}

/// Serves one instance over standard input until its end. The whole of the program `skein plugin-host`.
pub fn serve() -> Result<(), ServeError> {
    // Before anything else: whatever happens to the node, this process does not outlive it.
    rustix::process::set_parent_process_death_signal(Some(Signal::KILL)).map_err(system("be ended with the node"))?;
    let stdin = std::io::stdin();
    let kind = rustix::fs::fstat(&stdin)
        .map_err(system("look at standard input"))?
        .st_mode;
    if rustix::fs::FileType::from_raw_mode(kind) != rustix::fs::FileType::Socket {
        return Err(ServeError::ByHand);
    }
    close_inherited();
    let mut wire = Wire::new(stdin.as_fd(), true);
    let Some(start) = receive(&mut wire)? else {
        return Ok(());
    };
    if start.head.kind != kind::START {
        return Err(ServeError::Protocol("something else before the start"));
    }
    match Served::start(start)? {
        Ok(mut served) => {
            answer(
                &mut wire,
                Head {
                    kind: kind::DONE,
                    ..Head::default()
                },
                &[],
            )?;
            served.run(&mut wire)
        }
        Err(error) => fail(&mut wire, &error),
    }
}

/// The next request; none if the node has closed the socket.
fn receive<S: AsFd>(wire: &mut Wire<S>) -> Result<Option<Message>, ServeError> {
    let mut looked = wire.spin_receive(MAX_REQUEST_BYTES);
    loop {
        match looked {
            Ok(Some(message)) => return Ok(Some(message)),
            Ok(None) => wait(&[wire.socket()], PollFlags::IN, None).map_err(system("wait for the node"))?,
            Err(error) if error.kind() == std::io::ErrorKind::UnexpectedEof => return Ok(None),
            Err(error) => return Err(system("hear the node")(error)),
        }
        looked = wire.try_receive(MAX_REQUEST_BYTES);
    }
}

fn answer<S: AsFd>(wire: &mut Wire<S>, head: Head, body: &[&[u8]]) -> Result<(), ServeError> {
    wire.send(head, body, &[], None).map_err(system("answer the node"))
}

fn fail<S: AsFd>(wire: &mut Wire<S>, error: &PluginError) -> Result<(), ServeError> {
    let (head, body) = encode_error(error);
    answer(wire, head, &[&body])
}

/// The instance and what it needs.
struct Served {
    entry: Entry,
    /// Ended before the services go, which it may use until then.
    handle: Option<Handle>,
    /// At a place of their own: the instance knows where they are.
    services: Box<Services<LogSocket>>,
    settings: Settings,
}

impl Served {
    /// Loads the library and makes the instance. The outer error ends this process, the inner one is the node's to know.
    fn start(start: Message) -> Result<Result<Self, PluginError>, ServeError> {
        let settings_len = start.head.numbers[0] as usize;
        let (settings, create) = start
            .body
            .split_at_checked(settings_len)
            .ok_or(ServeError::Protocol("a start that is cut off"))?;
        let settings: Settings =
            minicbor::decode(settings).map_err(|_| ServeError::Protocol("settings that cannot be decoded"))?;
        let mut files = start.files.into_iter();
        let (Some(library), Some(logs)) = (files.next(), files.next()) else {
            return Err(ServeError::Protocol("a start without its files"));
        };
        let memory = if settings.lends_frames {
            let file = files.next().ok_or(ServeError::Protocol("a start without its files"))?;
            Some(FrameMemory::map(file).map_err(system("share the memory for frames"))?)
        } else {
            None
        };
        limit(&settings)?;
        let services = Box::new(Services::new(LogSocket(logs), Pool::shared(memory)));
        let made = load(&library).and_then(|entry| {
            let handle = entry.create(&services.for_plugin(), start.head.numbers[1], create)?;
            Ok((entry, handle))
        });
        Ok(made.map(|(entry, handle)| Self {
            entry,
            handle: Some(handle),
            services,
            settings,
        }))
    }

    fn run<S: AsFd>(&mut self, wire: &mut Wire<S>) -> Result<(), ServeError> {
        while let Some(request) = receive(wire)? {
            match request.head.kind {
                kind::INVOKE => self.invoke(wire, request)?,
                kind::DESTROY => {
                    let ended = self.handle.take().map_or(Ok(()), |handle| self.entry.destroy(handle));
                    return match ended {
                        Ok(()) => answer(
                            wire,
                            Head {
                                kind: kind::DONE,
                                ..Head::default()
                            },
                            &[],
                        ),
                        Err(error) => fail(wire, &error),
                    };
                }
                _ => return Err(ServeError::Protocol("a request that is not known")),
            }
        }
        Ok(())
    }

    fn invoke<S: AsFd>(&mut self, wire: &mut Wire<S>, request: Message) -> Result<(), ServeError> {
        let Message { head, body, files } = request;
        let [method, schema, then_snapshot, frames] = head.numbers;
        let (places, bytes) = body
            .split_at_checked(frames as usize * FramePlace::BYTES)
            .ok_or(ServeError::Protocol("a call that is cut off"))?;
        let (places, _) = places.as_chunks();
        let frames = places.iter().zip(files).map(|(place, file)| {
            let frame: Arc<dyn Readable> = Arc::new(ReceivedFrame::new(FramePlace::decode(place), file));
            frame
        });
        let call = || self.call(method, schema, bytes, then_snapshot != 0);
        match self.services.with_frames(frames.collect(), call) {
            Ok((schema, bytes, snapshot)) => {
                let (bytes, snapshot) = (bytes.bytes(), snapshot.as_ref().map(PluginBytes::bytes));
                let head = Head {
                    kind: kind::DONE,
                    numbers: [schema, bytes.len() as u32, u32::from(snapshot.is_some()), 0],
                };
                answer(wire, head, &[bytes, snapshot.unwrap_or_default()])
            }
            Err(error) => fail(wire, &error),
        }
    }

    fn call(
        &self,
        method: u32,
        schema: u32,
        bytes: &[u8],
        then_snapshot: bool,
    ) -> Result<(u32, PluginBytes, Option<PluginBytes>), PluginError> {
        let handle = self.handle.as_ref().ok_or(PluginError::Gone)?;
        let (schema, bytes) = self.entry.invoke(handle, method, schema, bytes)?;
        // A snapshot is what it is asked for alone, too.
        let limit = self.settings.max_answer_bytes.max(self.settings.max_snapshot_bytes);
        within(
            &bytes,
            if method == method::SNAPSHOT {
                limit
            } else {
                self.settings.max_answer_bytes
            },
        )?;
        if !then_snapshot {
            return Ok((schema, bytes, None));
        }
        let snapshot = self.entry.invoke(handle, method::SNAPSHOT, 0, &[])?.1;
        within(&snapshot, self.settings.max_snapshot_bytes)?;
        Ok((schema, bytes, Some(snapshot)))
    }
}

fn within(bytes: &PluginBytes, limit: u64) -> Result<(), PluginError> {
    let (len, limit) = (bytes.bytes().len(), usize::try_from(limit).unwrap_or(usize::MAX));
    if len > limit {
        return Err(PluginError::TooLarge { len, limit });
    }
    Ok(())
}

/// Closes what the node inherited itself and passed on without knowing. What this process opened is marked to be closed by the next
/// program, and so tells itself apart.
fn close_inherited() {
    let Ok(entries) = std::fs::read_dir("/proc/self/fd") else {
        return;
    };
    let numbers = entries
        .flatten()
        .filter_map(|entry| entry.file_name().to_str()?.parse::<RawFd>().ok());
    for number in numbers.filter(|number| *number > 2).collect::<Vec<_>>() {
        // SAFETY: it was open a moment ago; should it not be any more, the call fails.
        let file = unsafe { BorrowedFd::borrow_raw(number) };
        if rustix::io::fcntl_getfd(file).is_ok_and(|flags| !flags.contains(FdFlags::CLOEXEC)) {
            // SAFETY: nobody in this program opened it, so that nobody uses it.
            drop(unsafe { OwnedFd::from_raw_fd(number) });
        }
    }
}

/// From here on this process may use no more than it was given.
fn limit(settings: &Settings) -> Result<(), ServeError> {
    let set = |resource, limit| {
        let limit = Rlimit {
            current: Some(limit),
            maximum: Some(limit),
        };
        rustix::process::setrlimit(resource, limit)
    };
    rustix::thread::set_no_new_privs(true).map_err(system("give up privileges"))?;
    set(Resource::Core, 0).map_err(system("limit core files"))?;
    set(Resource::Nofile, settings.open_files).map_err(system("limit open files"))?;
    let statm = std::fs::read_to_string("/proc/self/statm").map_err(system("look at the memory used"))?;
    let pages: u64 = statm
        .split(' ')
        .next()
        .and_then(|pages| pages.parse().ok())
        .unwrap_or(0);
    let used = pages.saturating_mul(rustix::param::page_size() as u64);
    set(Resource::As, used.saturating_add(settings.memory_bytes)).map_err(system("limit memory"))
}

fn load(library: &OwnedFd) -> Result<Entry, PluginError> {
    let path = PathBuf::from(format!("/proc/self/fd/{}", library.as_raw_fd()));
    open(&path).map_err(|error: LoadError| PluginError::NotStarted {
        detail: error.to_string(),
    })
}
