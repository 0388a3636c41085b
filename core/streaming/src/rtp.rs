//! Video as RTP over UDP to addresses of the configuration, for QGroundControl and other players: one actor, a task for each address.
//!
//! Bound: one picture in work; what it is not in time for is left out, as for any viewer. Must never do: look at a camera while the network does
//! not take the pictures, or wait anywhere but in its own task.

mod announcing;
mod packets;

use crate::CameraStreams;
use packets::Packets;
use ractor::{Actor, ActorProcessingErr, ActorRef};
use skein_config::{RtpQuality, RtpSettings};
use skein_domain::exchange::Severity;
use skein_domain::{Refusal, VehicleId};
use skein_state::video::{Quality, Rendition, Viewer};
use skein_video::Coding;
use skein_view::EventKind;
use std::hash::{BuildHasher, RandomState};
use std::io;
use std::net::{Ipv4Addr, Ipv6Addr, SocketAddr};
use std::time::Duration;
use thiserror::Error;
use tokio::net::UdpSocket;
use tokio::task::AbortHandle;
use tokio::time::{Instant, sleep, timeout};

/// Pause after the camera was not there, or the network did not take a picture.
const AGAIN_AFTER: Duration = Duration::from_secs(2);
/// A camera that is not there for so many tries is told of.
const TELL_AFTER: u32 = 3;
/// When no picture comes for so long, it is looked whether the camera is another one now: another node may have taken over the vehicle.
const LOOK_ANEW_AFTER: Duration = Duration::from_secs(3);
/// A fault that comes later than this after the last one is told again.
const TELL_AGAIN_AFTER: Duration = Duration::from_secs(60);
/// So many packets go out at once, and then none for a millisecond: a key picture is not to overflow what a receiver keeps.
const BURST: usize = 32;
const BURST_PAUSE: Duration = Duration::from_millis(1);

/// Sends the cameras that the configuration names.
pub struct RtpOut;

/// A task of it has ended, which none does but by a panic.
#[derive(Debug, Error)]
#[error("{0}")]
pub struct RtpEnded(String);

/// Its tasks, which end with this.
#[derive(Default)]
pub struct Sending(Vec<AbortHandle>);

impl Sending {
    /// One more task, whose panic becomes the actor's failure and so the supervisor's business.
    fn run(&mut self, actor: &ActorRef<RtpEnded>, task: impl Future<Output = ()> + Send + 'static) {
        let (actor, task) = (actor.clone(), tokio::spawn(task));
        self.0.push(task.abort_handle());
        tokio::spawn(async move {
            if let Err(error) = task.await {
                // An actor that is gone has ended it.
                let _ = actor.cast(RtpEnded(error.to_string()));
            }
        });
    }
}

impl Drop for Sending {
    fn drop(&mut self) {
        self.0.iter().for_each(AbortHandle::abort);
    }
}

impl Actor for RtpOut {
    type Msg = RtpEnded;
    type State = Sending;
    type Arguments = CameraStreams;

    async fn pre_start(&self, myself: ActorRef<RtpEnded>, node: CameraStreams) -> Result<Sending, ActorProcessingErr> {
        let mut sending = Sending::default();
        for settings in node.config().video.rtp.clone() {
            sending.run(&myself, Sender::new(node.clone(), settings).run());
        }
        sending.run(&myself, announcing::announce(node));
        Ok(sending)
    }

    async fn handle(&self, _: ActorRef<RtpEnded>, ended: RtpEnded, _: &mut Sending) -> Result<(), ActorProcessingErr> {
        Err(ended.into())
    }
}

/// Sends one camera to one address.
struct Sender {
    node: CameraStreams,
    settings: RtpSettings,
    packets: Packets,
    /// How often the camera was not there, one after the other.
    missing: u32,
    /// When the network last took nothing.
    failed: Option<Instant>,
}

impl Sender {
    fn new(node: CameraStreams, settings: RtpSettings) -> Self {
        // Another one after each start: a player then takes the stream for a new one, and does not wait for numbers that were.
        let source = RandomState::new().hash_one(settings.to) as u32;
        Self {
            node,
            settings,
            packets: Packets::new(source),
            missing: 0,
            failed: None,
        }
    }

    async fn run(mut self) {
        loop {
            match self.look() {
                Ok(viewer) => {
                    self.missing = 0;
                    if let Err(error) = self.send(viewer).await {
                        self.note_failure(&error);
                    }
                }
                Err(refusal) => self.note_missing(&refusal),
            }
            sleep(AGAIN_AFTER).await;
        }
    }

    fn vehicle(&self) -> VehicleId {
        VehicleId(self.settings.vehicle)
    }

    fn look(&self) -> Result<Viewer, Refusal> {
        let rendition = Rendition {
            coding: Coding::H264,
            quality: match self.settings.quality {
                RtpQuality::Main => Quality::Main,
                RtpQuality::Sub => Quality::Sub,
            },
        };
        self.node.watch_video(self.vehicle(), &self.settings.camera, rendition)
    }

    /// Sends until the camera is gone, or the network takes nothing.
    async fn send(&mut self, mut viewer: Viewer) -> io::Result<()> {
        let socket = connected(self.settings.to).await?;
        loop {
            let Ok(given) = timeout(LOOK_ANEW_AFTER, viewer.next()).await else {
                match self.look() {
                    Ok(anew) if anew.sees_the_same(&viewer) => continue,
                    Ok(anew) => viewer = anew,
                    Err(_) => return Ok(()),
                }
                continue;
            };
            for (at, packet) in self.packets.of(&given.frame).iter().enumerate() {
                if at % BURST == BURST - 1 {
                    sleep(BURST_PAUSE).await;
                }
                socket.send(packet).await?;
            }
        }
    }

    /// A vehicle that is not there may come; a camera that a vehicle does not have is a mistake.
    fn note_missing(&mut self, refusal: &Refusal) {
        if matches!(refusal, Refusal::UnknownVehicle { .. }) {
            self.missing = 0;
            return;
        }
        self.missing += 1;
        if self.missing == TELL_AFTER {
            self.tell(&format!("waits for the camera: {refusal}"));
        }
    }

    fn note_failure(&mut self, error: &io::Error) {
        let last = self.failed.replace(Instant::now());
        if last.is_none_or(|last| last.elapsed() > TELL_AGAIN_AFTER) {
            self.tell(&format!("{error}; it is tried again every {} s", AGAIN_AFTER.as_secs()));
        }
    }

    fn tell(&self, what: &str) {
        let RtpSettings { camera, to, .. } = &self.settings;
        let (shared, vehicle) = (self.node.shared(), self.vehicle());
        let text = format!("{camera} of vehicle {vehicle} as RTP to {to}: {what}");
        let kind = EventKind::Payload {
            payload: camera.clone(),
        };
        shared
            .events
            .record(shared.now(), Some(vehicle), Severity::Warning, kind, text);
    }
}

/// A socket that hears of it when nobody receives. A new one each time: an address of this computer may have changed.
async fn connected(to: SocketAddr) -> io::Result<UdpSocket> {
    let any = if to.is_ipv4() {
        SocketAddr::from((Ipv4Addr::UNSPECIFIED, 0))
    } else {
        SocketAddr::from((Ipv6Addr::UNSPECIFIED, 0))
    };
    let socket = UdpSocket::bind(any).await?;
    socket.connect(to).await?;
    Ok(socket)
}
