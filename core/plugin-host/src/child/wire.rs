//! What is said over the socket between this process and a child: one message at a time in each direction, a head of fixed length and a
//! body whose length it gives, files beside it.
//!
//! Must never do: take a length from the other side for granted.

use rustix::event::{PollFd, PollFlags, Timespec};
use rustix::io::Errno;
use rustix::net::{
    RecvAncillaryBuffer, RecvAncillaryMessage, RecvFlags, SendAncillaryBuffer, SendAncillaryMessage, SendFlags,
};
use std::io::{Error, ErrorKind, IoSlice, IoSliceMut};
use std::mem::MaybeUninit;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::time::{Duration, Instant};

/// Files that go with one message at most.
pub(crate) const MAX_FILES: usize = 16;
/// Length of a head in bytes.
const HEAD_BYTES: usize = 24;
/// So much is read at once.
const CHUNK_BYTES: usize = 16 << 10;
/// How long the other side is looked for without letting go of the processor: most answers come within it, and to be woken takes longer.
/// Not yielded in between, since on a busy machine that can take milliseconds.
const SPIN: Duration = Duration::from_micros(20);

/// Kinds of messages. Requests are odd, answers even.
pub(crate) mod kind {
    /// Make the instance: settings and what it is created with.
    pub(crate) const START: u32 = 1;
    /// Call a method.
    pub(crate) const INVOKE: u32 = 3;
    /// End the instance, then the process.
    pub(crate) const DESTROY: u32 = 5;
    /// It is done; the answer.
    pub(crate) const DONE: u32 = 2;
    /// It was not done; why.
    pub(crate) const FAILED: u32 = 4;
}

/// The head of a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Head {
    /// One of [`kind`].
    pub(crate) kind: u32,
    /// What they are depends on the kind.
    pub(crate) numbers: [u32; 4],
}

/// A message as it came.
#[derive(Debug, Default)]
pub(crate) struct Message {
    pub(crate) head: Head,
    pub(crate) body: Vec<u8>,
    pub(crate) files: Vec<OwnedFd>,
}

/// One end of the socket.
#[derive(Debug)]
pub(crate) struct Wire<S> {
    socket: S,
    /// Kept for its room.
    out: Vec<u8>,
    chunk: Vec<u8>,
    /// What came and was not taken yet.
    received: Vec<u8>,
    files: Vec<OwnedFd>,
    takes_files: bool,
}

impl<S: AsFd> Wire<S> {
    /// An end that takes files only if it is told so; others are closed by the system.
    pub(crate) fn new(socket: S, takes_files: bool) -> Self {
        Self {
            socket,
            out: Vec::new(),
            chunk: vec![0; CHUNK_BYTES],
            received: Vec::new(),
            files: Vec::new(),
            takes_files,
        }
    }

    pub(crate) fn socket(&self) -> BorrowedFd<'_> {
        self.socket.as_fd()
    }

    /// Sends a message. With `until` a receiver that does not take it in time is an error of the kind [`ErrorKind::TimedOut`].
    pub(crate) fn send(
        &mut self,
        head: Head,
        body: &[&[u8]],
        files: &[BorrowedFd<'_>],
        until: Option<Instant>,
    ) -> std::io::Result<()> {
        let len: usize = body.iter().map(|part| part.len()).sum();
        let len = u32::try_from(len).map_err(|_| Error::other("a message of over 4 GiB"))?;
        self.out.clear();
        self.out.extend_from_slice(&len.to_ne_bytes());
        self.out.extend_from_slice(&head.kind.to_ne_bytes());
        head.numbers
            .iter()
            .for_each(|number| self.out.extend_from_slice(&number.to_ne_bytes()));
        body.iter().for_each(|part| self.out.extend_from_slice(part));
        let (mut rest, mut files) = (self.out.as_slice(), files);
        while !rest.is_empty() {
            match send_some(self.socket.as_fd(), rest, files) {
                Ok(sent) => {
                    rest = rest.get(sent..).unwrap_or_default();
                    files = &[];
                }
                Err(Errno::AGAIN) => wait(&[self.socket.as_fd()], PollFlags::OUT, until)?,
                Err(Errno::INTR) => {}
                Err(error) => return Err(error.into()),
            }
        }
        Ok(())
    }

    /// Looks for a message without sleeping: gives it once it is whole. A body over `limit` bytes is an error, and so is more than one
    /// message.
    pub(crate) fn try_receive(&mut self, limit: usize) -> std::io::Result<Option<Message>> {
        loop {
            if let Some(message) = self.take_message(limit)? {
                return Ok(Some(message));
            }
            match self.receive_some() {
                Ok(0) => return Err(ErrorKind::UnexpectedEof.into()),
                Ok(_) | Err(Errno::INTR) => {}
                Err(Errno::AGAIN) => return Ok(None),
                Err(error) => return Err(error.into()),
            }
        }
    }

    /// As [`Self::try_receive`], looking for some microseconds.
    pub(crate) fn spin_receive(&mut self, limit: usize) -> std::io::Result<Option<Message>> {
        let began = Instant::now();
        loop {
            if let Some(message) = self.try_receive(limit)? {
                return Ok(Some(message));
            }
            if began.elapsed() >= SPIN {
                return Ok(None);
            }
            std::hint::spin_loop();
        }
    }

    fn take_message(&mut self, limit: usize) -> std::io::Result<Option<Message>> {
        let Some((head, after)) = self.received.split_first_chunk::<HEAD_BYTES>() else {
            return Ok(None);
        };
        let mut numbers = head
            .chunks_exact(4)
            .map(|four| four.try_into().map_or(0, u32::from_ne_bytes));
        let mut number = || numbers.next().unwrap_or(0);
        let len = number() as usize;
        if len > limit {
            return Err(Error::other(format!("a message of {len} bytes, the limit is {limit}")));
        }
        let head = Head {
            kind: number(),
            numbers: [number(), number(), number(), number()],
        };
        if after.len() > len {
            return Err(Error::other("more than one message at a time"));
        }
        if after.len() < len {
            return Ok(None);
        }
        let body = after.to_vec();
        self.received.clear();
        let files = std::mem::take(&mut self.files);
        Ok(Some(Message { head, body, files }))
    }

    fn receive_some(&mut self) -> Result<usize, Errno> {
        let flags = RecvFlags::DONTWAIT | RecvFlags::CMSG_CLOEXEC;
        let len = if self.takes_files {
            let mut space = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(MAX_FILES))];
            let mut control = RecvAncillaryBuffer::new(&mut space);
            let parts = &mut [IoSliceMut::new(&mut self.chunk)];
            let received = rustix::net::recvmsg(&self.socket, parts, &mut control, flags)?;
            for message in control.drain() {
                if let RecvAncillaryMessage::ScmRights(files) = message {
                    self.files.extend(files);
                }
            }
            received.bytes
        } else {
            rustix::net::recv(&self.socket, &mut self.chunk[..], flags)?.1
        };
        self.received
            .extend_from_slice(self.chunk.get(..len).unwrap_or_default());
        Ok(len)
    }
}

fn send_some(socket: BorrowedFd<'_>, bytes: &[u8], files: &[BorrowedFd<'_>]) -> Result<usize, Errno> {
    let flags = SendFlags::NOSIGNAL | SendFlags::DONTWAIT;
    if files.is_empty() {
        return rustix::net::send(socket, bytes, flags);
    }
    let mut space = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(MAX_FILES))];
    let mut control = SendAncillaryBuffer::new(&mut space);
    if !control.push(SendAncillaryMessage::ScmRights(files)) {
        return Err(Errno::TOOBIG);
    }
    rustix::net::sendmsg(socket, &[IoSlice::new(bytes)], &mut control, flags)
}

/// Sleeps until one of the files has something, or can take something; or until then.
pub(crate) fn wait(files: &[BorrowedFd<'_>], flags: PollFlags, until: Option<Instant>) -> std::io::Result<()> {
    let left = until.map(|until| until.saturating_duration_since(Instant::now()));
    if left.is_some_and(|left| left.is_zero()) {
        return Err(ErrorKind::TimedOut.into());
    }
    let timeout = left.map(|left| Timespec {
        tv_sec: i64::try_from(left.as_secs()).unwrap_or(i64::MAX),
        tv_nsec: left.subsec_nanos().into(),
    });
    let mut polled: Vec<_> = files
        .iter()
        .map(|file| PollFd::from_borrowed_fd(*file, flags))
        .collect();
    match rustix::event::poll(&mut polled, timeout.as_ref()) {
        Ok(_) | Err(Errno::INTR) => Ok(()),
        Err(error) => Err(error.into()),
    }
}

#[cfg(test)]
mod tests;
