//! The cameras: a clip that FFmpeg has made once, sent over RTP at its own pace, again and again; and FFmpeg as a relay of RTP.

use super::errors;
use crate::error::BenchError;
use crate::process::Part;
use std::net::{Ipv4Addr, UdpSocket};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;
use tempfile::TempDir;

/// Its name in faults.
pub(super) const RELAY: &str = "relay of FFmpeg";
/// How long streams may take to begin.
pub(super) const PATIENCE: Duration = Duration::from_secs(30);
/// So often other ports are looked for.
const TRIES: usize = 1000;
/// As cameras of small aircraft send it: 640x480, 30 pictures and about a megabit a second, a key picture every two seconds.
const ENCODED: &str = "-f lavfi -i testsrc2=size=640x480:rate=30 -t 10 -c:v libx264 -profile:v baseline -preset veryfast -pix_fmt yuv420p \
     -g 60 -b:v 1M -maxrate 1M -bufsize 500k -f mpegts";

/// A port of this computer, with the one above it that RTP takes for its reports.
pub(super) struct Port {
    pub(super) number: u16,
    data: UdpSocket,
    _reports: UdpSocket,
}

impl Port {
    /// So many that nobody has. They are held until they are dropped.
    pub(super) fn free(count: usize) -> Result<Vec<Self>, BenchError> {
        let mut found = Vec::new();
        for _ in 0..TRIES {
            if found.len() == count {
                break;
            }
            let data = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).map_err(BenchError::system("port"))?;
            let number = data.local_addr().map_err(BenchError::system("port"))?.port();
            data.set_nonblocking(true).map_err(BenchError::system("port"))?;
            if let (0, Ok(reports)) = (
                number % 2,
                UdpSocket::bind((Ipv4Addr::LOCALHOST, number.saturating_add(1))),
            ) {
                found.push(Self {
                    number,
                    data,
                    _reports: reports,
                });
            }
        }
        Ok(found)
    }

    /// Whether anything has come.
    pub(super) fn hears(&self) -> bool {
        self.data.recv(&mut [0; 16]).is_ok()
    }
}

/// The clip.
pub(super) struct Clip {
    folder: TempDir,
}

impl Clip {
    pub(super) fn make(ffmpeg: &Path) -> Result<Self, BenchError> {
        let folder = TempDir::with_prefix("skein-bench-").map_err(BenchError::system("temporary directory"))?;
        let clip = Self { folder };
        let mut command = quiet(ffmpeg);
        command.args(ENCODED.split_whitespace()).arg(clip.file());
        let made = command.status().map_err(|source| BenchError::Start {
            program: ffmpeg.into(),
            source,
        })?;
        if made.success() {
            Ok(clip)
        } else {
            Err(BenchError::Child {
                part: "encoder of FFmpeg",
                detail: format!("ended ({made}); it needs libx264"),
            })
        }
    }

    fn file(&self) -> PathBuf {
        self.folder.path().join("clip.ts")
    }

    /// Sends it to each port until it is dropped.
    pub(super) fn send(&self, ffmpeg: &Path, to: &[Port]) -> Result<Part, BenchError> {
        let mut command = quiet(ffmpeg);
        command.args(["-re", "-stream_loop", "-1", "-i"]).arg(self.file());
        for port in to {
            command
                .args(["-map", "0:v", "-c", "copy", "-f", "rtp"])
                .arg(address(port.number));
        }
        Part::start_by("sender of FFmpeg", command.into(), &[], errors())
    }

    /// Takes in what comes to one port and sends it to another.
    pub(super) fn relay(&self, ffmpeg: &Path, from: u16, to: u16) -> Result<Part, BenchError> {
        let description = self.folder.path().join(format!("{from}.sdp"));
        let text = format!(
            "v=0\no=- 0 0 IN IP4 127.0.0.1\ns=clip\nc=IN IP4 127.0.0.1\nt=0 0\nm=video {from} RTP/AVP 96\na=rtpmap:96 H264/90000\n"
        );
        std::fs::write(&description, text).map_err(BenchError::system("temporary file"))?;
        let mut command = quiet(ffmpeg);
        command
            .args(["-protocol_whitelist", "file,udp,rtp", "-i"])
            .arg(description);
        command.args(["-c", "copy", "-f", "rtp"]).arg(address(to));
        Part::start_by(RELAY, command.into(), &[], errors())
    }
}

fn address(port: u16) -> String {
    format!("rtp://127.0.0.1:{port}?pkt_size=1200")
}

/// FFmpeg that says only what is wrong. A description of the stream, which it prints, goes to an output that is not read.
fn quiet(ffmpeg: &Path) -> Command {
    let mut command = Command::new(ffmpeg);
    command.args(["-nostdin", "-hide_banner", "-loglevel", "fatal", "-y"]);
    command
}
