//! The files: one after the other, and what is done when the disk does not take them.
//!
//! Must never do: give up. Whatever was wrong with the disk, it is tried again.

use crate::disk::Room;
use crate::folder::{self, Keep};
use skein_domain::NodeTime;
use skein_recording::{AuditChain, AuditRecord, Encoded, Header, Recording, Topic, WriteError, Writer};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// A file that could not be written is followed by another one after so long, in seconds.
const AGAIN_AFTER_S: f64 = 1.0;

/// What there is to tell an operator.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Told {
    /// Nothing is recorded any more: why.
    Interrupted(String),
    /// It goes on; so many messages were lost.
    GoesOn(u64),
}

/// The files of one recorder.
pub struct Tapes {
    folder: PathBuf,
    keep: Keep,
    state: State,
    /// Files of the flight under way.
    spared: Vec<PathBuf>,
    /// While it is interrupted, how many messages were lost.
    interrupted: Option<u64>,
}

enum State {
    Closed { not_before: NodeTime },
    Open { writer: Box<Writer>, path: PathBuf },
}

impl Tapes {
    /// In this folder.
    pub fn new(folder: PathBuf, keep: Keep) -> Self {
        Self {
            folder,
            keep,
            state: State::Closed {
                not_before: NodeTime(0),
            },
            spared: Vec::new(),
            interrupted: None,
        }
    }

    /// The chain of the audit of this node's newest file, which the next one goes on with.
    pub fn last_chain(&self, node: &str) -> AuditChain {
        let mut files = folder::all(&self.folder).unwrap_or_default();
        files.sort();
        let of_node = |path: &PathBuf| Recording::open(path).ok().filter(|of| of.header().name == node);
        let last = files.iter().rev().find_map(of_node);
        let record = last.and_then(|recording| recording.last(&Topic::Audit)?.json::<AuditRecord>().ok());
        record.map_or_else(AuditChain::default, |record| AuditChain::after(&record.hash))
    }

    /// Whether a file is to be begun now.
    pub fn wants_file(&self, now: NodeTime) -> bool {
        matches!(self.state, State::Closed { not_before } if now >= not_before)
    }

    /// Begins a file. Room is made for it by deleting older ones.
    pub fn begin(&mut self, header: Header, now: NodeTime) -> Option<Told> {
        let begun = self.begun(header);
        match begun {
            Ok((writer, path)) => {
                self.spared.push(path.clone());
                let writer = Box::new(writer);
                self.state = State::Open { writer, path };
                None
            }
            Err(error) => self.close(&error, now),
        }
    }

    fn begun(&self, header: Header) -> Result<(Writer, PathBuf), WriteError> {
        fs::create_dir_all(&self.folder)?;
        folder::prune(&self.folder, self.keep, 0, &self.spared)?;
        if !Room::of(&self.folder)?.is_enough_to_begin() {
            folder::prune(
                &self.folder,
                self.keep,
                Room::of(&self.folder)?.floor_bytes,
                &self.spared,
            )?;
            if !Room::of(&self.folder)?.is_enough_to_begin() {
                return Err(io::Error::from(io::ErrorKind::StorageFull).into());
            }
        }
        let name = folder::name(header.base.unix_ns, &header.name);
        let path = folder::free_path(&self.folder, &name);
        let writer = Writer::create(&path, header)?;
        Ok((writer, path))
    }

    /// Adds messages. While there is no file they are counted as lost.
    pub fn write(&mut self, messages: &[Encoded], now: NodeTime) -> Option<Told> {
        let State::Open { writer, .. } = &mut self.state else {
            if let Some(lost) = &mut self.interrupted {
                *lost += messages.len() as u64;
            }
            return None;
        };
        let written = messages.iter().try_for_each(|message| writer.write(message, now));
        written.err().and_then(|error| self.close(&error, now))
    }

    /// What was added until now goes to the file; with `sync` also to the disk, and room is looked at.
    pub fn flush(&mut self, sync: bool, now: NodeTime) -> Option<Told> {
        let State::Open { writer, .. } = &mut self.state else {
            return None;
        };
        let written = writer.flush().and_then(|()| if sync { writer.sync() } else { Ok(()) });
        let flushed = written.and_then(|()| if sync { self.make_room() } else { Ok(()) });
        match flushed {
            Err(error) => self.close(&error, now),
            // Only what was written says that the disk takes it again.
            Ok(()) => self.interrupted.take().map(Told::GoesOn),
        }
    }

    fn make_room(&self) -> Result<(), WriteError> {
        let room = Room::of(&self.folder)?;
        if room.is_enough() {
            return Ok(());
        }
        folder::prune(&self.folder, self.keep, room.floor_bytes, &self.spared)?;
        if Room::of(&self.folder)?.is_enough() {
            Ok(())
        } else {
            Err(io::Error::from(io::ErrorKind::StorageFull).into())
        }
    }

    /// How large the present file is, in bytes.
    pub fn bytes(&self) -> u64 {
        match &self.state {
            State::Open { writer, .. } => writer.bytes().unwrap_or_default(),
            State::Closed { .. } => 0,
        }
    }

    /// Name of the present file.
    pub fn file(&self) -> Option<String> {
        match &self.state {
            State::Open { path, .. } => Some(path.file_name()?.to_string_lossy().into_owned()),
            State::Closed { .. } => None,
        }
    }

    /// Ends the file: the flight is over, or nobody has flown for long. The next is begun by whoever asks for it.
    pub fn end(&mut self, has_flown: bool) -> Result<(), WriteError> {
        let closed = State::Closed {
            not_before: NodeTime(0),
        };
        let State::Open { writer, path } = std::mem::replace(&mut self.state, closed) else {
            return Ok(());
        };
        self.spared.clear();
        writer.finish()?;
        if !has_flown {
            folder::mark_as_ground(&path)?;
        }
        folder::prune(&self.folder, self.keep, 0, &[])?;
        Ok(())
    }

    fn close(&mut self, error: &WriteError, now: NodeTime) -> Option<Told> {
        self.state = State::Closed {
            not_before: now.plus_seconds(AGAIN_AFTER_S),
        };
        if self.interrupted.is_some() {
            return None;
        }
        self.interrupted = Some(0);
        Some(Told::Interrupted(why(error, &self.folder)))
    }
}

fn why(error: &WriteError, folder: &Path) -> String {
    let folder = folder.display();
    if error.is_full() {
        return format!("the disk of {folder} is full");
    }
    format!("{folder} cannot be written: {error}")
}
