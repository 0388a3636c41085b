//! Video between nodes: a stream of another node is asked for as long as somebody looks at it here, and one of this node is sent as long as another
//! asks for it.
//!
//! Bound: one picture of a stream waits for the bus at a time. Must never do: send what nobody asked for within the last seconds.

use crate::CameraStreams;
use crate::streams::Looked;
use ractor::ActorRef;
use skein_domain::{NodeId, Refusal, VehicleId};
use skein_state::asks::{Answer, Ask};
use skein_state::video::{Quality, RemoteStream, Rendition, Viewer};
use skein_state::{SharedState, SwarmMessage};
use skein_video::Coding;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;
use tokio::sync::oneshot;
use tokio::time::{Instant, sleep};

/// A stream that is looked at is asked for so often.
const ASK_EVERY: Duration = Duration::from_secs(1);
/// How long an answer is waited for.
const ANSWER_WITHIN: Duration = Duration::from_secs(2);
/// How often it is looked whether a decoder waits for a key picture.
const LOOK_EVERY: Duration = Duration::from_millis(50);
/// A link that carried too little for so many groups within [`THIN_WITHIN`] is thin: small pictures go over it.
const THIN_AFTER: usize = 3;
const THIN_WITHIN: Duration = Duration::from_secs(8);
/// After so long it is tried again whether it carries the others.
const THIN_FOR: Duration = Duration::from_secs(20);

/// Gets a stream of another node for as long as somebody looks at it, and that node flies the vehicle.
pub(crate) async fn fetch(node: CameraStreams, from: NodeId, looked: Looked, remote: RemoteStream) {
    let is_there = || remote.stream.viewers() > 0 && node.shared().host(looked.vehicle) == Some(from);
    while is_there() {
        // One that was started anew knows of no stream.
        match Fetching::begin(&node, from, &remote).await {
            Some(mut fetching) => {
                while is_there() && fetching.go_on(&node, &looked, &remote).await {}
                fetching.end();
            }
            None => sleep(ASK_EVERY).await,
        }
    }
}

/// A stream under its number at one incarnation of the swarm actor.
struct Fetching {
    actor: Arc<ActorRef<SwarmMessage>>,
    from: NodeId,
    number: u32,
    asked: Option<Instant>,
}

impl Fetching {
    async fn begin(node: &CameraStreams, from: NodeId, remote: &RemoteStream) -> Option<Self> {
        let actor = node.shared().swarm.as_ref()?.actor()?;
        let (numbered, number) = oneshot::channel();
        let stream = Box::new(remote.clone());
        let number_of = SwarmMessage::ExpectVideo {
            from,
            stream,
            number: numbered,
        };
        actor.cast(number_of).ok()?;
        Some(Self {
            number: number.await.ok()?,
            asked: None,
            actor,
            from,
        })
    }

    /// Asks for it when that is due. False when the swarm actor is not there any more.
    async fn go_on(&mut self, node: &CameraStreams, looked: &Looked, remote: &RemoteStream) -> bool {
        sleep(LOOK_EVERY).await;
        let (from, number) = (self.from, self.number);
        if remote.stream.take_wish_for_key() && self.actor.cast(SwarmMessage::WantVideoKey { from, number }).is_err() {
            return false;
        }
        if self.asked.is_some_and(|at| at.elapsed() < ASK_EVERY) {
            return true;
        }
        let present = node.shared().swarm.as_ref().and_then(|swarm| swarm.actor());
        if present.is_none_or(|present| present.get_id() != self.actor.get_id()) {
            return false;
        }
        self.asked = Some(Instant::now());
        let ask = Ask::Video {
            to: NodeId(node.shared().config.swarm.node.unwrap_or_default()),
            number,
            vehicle: looked.vehicle,
            payload: looked.payload.clone(),
            small: remote.rendition.quality == Quality::Sub,
        };
        let refusal = match node.shared().ask(from, ask, ANSWER_WITHIN).await {
            Ok(Answer::Done(Ok(()))) => None,
            Ok(Answer::Done(Err(refusal))) | Err(refusal) => Some(refusal.to_string()),
            Ok(_) => Some(format!("node {from} answered something else")),
        };
        remote.video.note_refusal(node.now(), refusal);
        true
    }

    fn end(self) {
        let (from, number) = (self.from, self.number);
        // One that has ended has forgotten it.
        let _ = self.actor.cast(SwarmMessage::ForgetVideo { from, number });
    }
}

impl CameraStreams {
    /// Another node wants the video of a camera of this one, under its number for it; for the next seconds.
    pub fn send_video(
        &self,
        to: NodeId,
        number: u32,
        vehicle: VehicleId,
        payload: &str,
        small: bool,
    ) -> Result<(), Refusal> {
        self.camera(vehicle, payload)?;
        let Some(key) = self.shared().videos.want(self.now(), to, number) else {
            return Ok(());
        };
        let quality = if small { Quality::Sub } else { Quality::Main };
        let sender = Sender {
            node: self.clone(),
            to,
            number,
            vehicle,
            payload: payload.to_owned(),
            quality,
            key,
            left_out: Vec::new(),
            thin_until: None,
        };
        tokio::spawn(sender.run());
        Ok(())
    }
}

/// Sends one stream to one node.
struct Sender {
    node: CameraStreams,
    to: NodeId,
    number: u32,
    vehicle: VehicleId,
    payload: String,
    quality: Quality,
    /// The other node's decoder waits for a key picture.
    key: Arc<AtomicBool>,
    /// When the link carried too little.
    left_out: Vec<Instant>,
    thin_until: Option<Instant>,
}

impl Sender {
    async fn run(mut self) {
        while let Ok(viewer) = self.view() {
            if self.send(viewer).await.is_none() {
                break;
            }
        }
        self.shared().videos.forget(self.to, self.number);
        if let Some(actor) = self.shared().swarm.as_ref().and_then(|swarm| swarm.actor()) {
            let (to, number) = (self.to, self.number);
            // One that has ended keeps nothing.
            let _ = actor.cast(SwarmMessage::EndVideo { to, number });
        }
    }

    fn shared(&self) -> &Arc<SharedState> {
        self.node.shared()
    }

    fn is_thin(&self) -> bool {
        self.thin_until.is_some_and(|until| Instant::now() < until)
    }

    fn view(&self) -> Result<Viewer, Refusal> {
        let quality = if self.is_thin() { Quality::Sub } else { self.quality };
        let coding = Coding::H264;
        self.node
            .watch_video(self.vehicle, &self.payload, Rendition { coding, quality })
    }

    /// Sends until another rendition fits the link better; none when it is not wanted any more.
    async fn send(&mut self, mut viewer: Viewer) -> Option<()> {
        let began_thin = self.is_thin();
        let mut left_out = false;
        loop {
            let given = tokio::select! {
                given = viewer.next() => Some(given),
                () = sleep(ASK_EVERY) => None,
            };
            if !self.shared().videos.is_wanted(self.node.now(), self.to, self.number) {
                return None;
            }
            if self.key.swap(false, Ordering::Relaxed) {
                viewer.ask_for_key();
            }
            let Some(given) = given else { continue };
            let actor = self.shared().swarm.as_ref().and_then(|swarm| swarm.actor())?;
            let (answer, taken) = oneshot::channel();
            let message = SwarmMessage::SendVideo {
                to: self.to,
                number: self.number,
                frame: given.frame,
                taken: answer,
            };
            actor.cast(message).ok()?;
            // The actor may have been started anew in between: then this picture is lost, and the next one not.
            if taken.await.unwrap_or(true) {
                left_out = false;
            } else if !std::mem::replace(&mut left_out, true) {
                viewer.ask_for_key();
                self.note_left_out();
            }
            if began_thin != self.is_thin() {
                return Some(());
            }
        }
    }

    /// A group was left out: after several of them small pictures go over this link for a while.
    fn note_left_out(&mut self) {
        let now = Instant::now();
        self.left_out.retain(|at| now.duration_since(*at) < THIN_WITHIN);
        self.left_out.push(now);
        if self.left_out.len() >= THIN_AFTER && self.quality == Quality::Main {
            self.left_out.clear();
            self.thin_until = Some(now + THIN_FOR);
        }
    }
}
