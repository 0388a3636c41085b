//! A pipeline of GStreamer that gives H.264: cameras on a computer's own ports, and its encoders. It runs as a program of its own, `gst-launch-1.0`,
//! which gives RTP over a socket of its own, with the length of each packet in front (RFC 4571).
//!
//! Must never do: wait for a pipeline without an end, or leave one that runs.

mod said;

use super::rtp::{Lack, Reception};
use super::{Coded, Outlet, StreamFault};
use rustix::process::{Pid, Signal};
use said::Said;
use std::io::{ErrorKind, Read};
use std::os::fd::OwnedFd;
use std::os::unix::net::UnixStream;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use thiserror::Error;

/// Data goes to descriptor 3, all that is printed to standard error. `setpriv` has it killed when the thread that started it ends. Without `trap` a closed socket would
/// kill it before it has given its camera back.
const SHELL: &str = r#"trap '' PIPE; exec setpriv --pdeathsig KILL gst-launch-1.0 -q -- "$@" 3>&1 >&2"#;
/// What makes packets of what the configured pipeline gives, with parameter sets before each key picture.
const BEHIND: &str = "! h264parse ! rtph264pay config-interval=-1 mtu=9000 ! rtpstreampay ! fdsink fd=3 sync=false";
/// A pipeline that gives nothing for so long is made anew.
const SILENT_AFTER: Duration = Duration::from_secs(5);
/// How often it is looked whether anybody still wants the stream.
const LOOK_EVERY: Duration = Duration::from_millis(100);
/// A pipeline has so long to give its camera back.
const END_WITHIN: Duration = Duration::from_secs(1);

/// Why a pipeline gives nothing.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub(crate) enum PipelineFault {
    #[error("gst-launch-1.0 does not start (Debian: apt install gstreamer1.0-tools): {0}")]
    NotInstalled(String),
    #[error("GStreamer has no element {0}: a package of its plugins is missing, or the name is wrong")]
    NoElement(String),
    #[error("the pipeline cannot be made: {0}")]
    Unmade(String),
    #[error("{element} of the pipeline: {reason}")]
    Element { element: String, reason: String },
    #[error("the pipeline gave no picture within {within_s} s: {lack}")]
    Silent { within_s: u64, lack: Lack },
    #[error("the pipeline has ended")]
    Ended,
}

/// The words of a pipeline as a shell has them; none if a quotation mark is left open.
pub(crate) fn words(description: &str) -> Option<Vec<String>> {
    shlex::split(description)
}

/// Reads until nobody wants it any more.
pub(super) fn read(description: &str, outlet: &Outlet) -> Result<(), StreamFault> {
    let mut running = Running::start(description)?;
    let began = Instant::now();
    let mut last_picture = began;
    let mut reception = Reception::new(Vec::new());
    while outlet.is_wanted() {
        running.read()?;
        while let Some(packet) = running.next_packet() {
            for picture in reception.take(began.elapsed(), &packet) {
                last_picture = Instant::now();
                if !outlet.give(Ok(Coded::at_once(picture.bytes))) {
                    return Ok(());
                }
            }
        }
        if last_picture.elapsed() >= SILENT_AFTER {
            let (within_s, lack) = (SILENT_AFTER.as_secs(), reception.take_lack());
            return Err(PipelineFault::Silent { within_s, lack }.into());
        }
    }
    Ok(())
}

/// A pipeline that ends with this value.
struct Running {
    program: Child,
    data: UnixStream,
    printed: UnixStream,
    said: Said,
    /// Of the data, what is no whole packet yet.
    received: Vec<u8>,
}

impl Running {
    fn start(description: &str) -> Result<Self, PipelineFault> {
        let words =
            words(description).ok_or_else(|| PipelineFault::Unmade("a quotation mark is left open".to_owned()))?;
        Self::spawn(&words).map_err(|error| PipelineFault::NotInstalled(error.to_string()))
    }

    fn spawn(words: &[String]) -> std::io::Result<Self> {
        let (data, its_data) = UnixStream::pair()?;
        let (printed, its_printed) = UnixStream::pair()?;
        data.set_read_timeout(Some(LOOK_EVERY))?;
        printed.set_nonblocking(true)?;
        let program = Command::new("/bin/sh")
            .args(["-c", SHELL, "gst-launch-1.0"])
            .args(words)
            .args(BEHIND.split(' '))
            // What it says is read here.
            .env("LC_ALL", "C")
            .stdin(Stdio::null())
            .stdout(OwnedFd::from(its_data))
            .stderr(OwnedFd::from(its_printed))
            .spawn()?;
        Ok(Self {
            program,
            data,
            printed,
            said: Said::default(),
            received: Vec::new(),
        })
    }

    /// Waits a moment for data. The error is why there will be none.
    fn read(&mut self) -> Result<(), PipelineFault> {
        let mut bytes = [0; 16 << 10];
        self.listen();
        match self.data.read(&mut bytes) {
            Ok(0) => Err(self.why_it_ended()),
            Ok(len) => {
                self.received.extend_from_slice(bytes.get(..len).unwrap_or_default());
                Ok(())
            }
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) => Ok(()),
            Err(error) => Err(PipelineFault::Unmade(error.to_string())),
        }
    }

    /// Takes what it has printed, so that it never waits for that.
    fn listen(&mut self) {
        let mut bytes = [0; 4 << 10];
        while let Ok(len) = self.printed.read(&mut bytes)
            && len > 0
        {
            self.said.take(bytes.get(..len).unwrap_or_default());
        }
    }

    /// The first packet of what was received, if it is whole.
    fn next_packet(&mut self) -> Option<Vec<u8>> {
        let (length, rest) = self.received.split_first_chunk::<2>()?;
        let len = usize::from(u16::from_be_bytes(*length));
        let packet = rest.get(..len)?.to_vec();
        self.received.drain(..2 + len);
        Some(packet)
    }

    fn why_it_ended(&mut self) -> PipelineFault {
        let code = self.wait(END_WITHIN);
        self.listen();
        self.said.fault(code)
    }

    /// Its exit status, if it ends in time by itself.
    fn wait(&mut self, within: Duration) -> Option<i32> {
        let since = Instant::now();
        while since.elapsed() < within {
            if let Ok(Some(status)) = self.program.try_wait() {
                return status.code();
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        None
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        if let Ok(None) = self.program.try_wait() {
            // What ends so gives its camera back.
            let _ = rustix::process::kill_process(Pid::from_child(&self.program), Signal::INT);
            self.wait(END_WITHIN);
        }
        let _ = self.program.kill();
        let _ = self.program.wait();
    }
}

#[cfg(test)]
mod tests;
