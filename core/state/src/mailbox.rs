//! What the actors of a node are told: the messages of their mailboxes, and where the mailbox of a vehicle or payload is found.
//!
//! Must never do: carry something that the sender has to wait for without an end.

use crate::asks::{Answer, Ask, TrackOrder};
use crate::video::RemoteStream;
use arc_swap::ArcSwapOption;
use ractor::{ActorRef, Message, RpcReplyPort};
use skein_domain::exchange::FaultDrill;
use skein_domain::link::RoutePoint;
use skein_domain::{CommandId, NodeId, NodeTime, ParameterError, ParameterValue, Refusal, RequestId, VehicleCommand};
use skein_plugin_host::Plugin;
use skein_video::EncodedFrame;
use skein_view::{CommandReceipt, Restored};
use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;
use tokio::sync::oneshot;

/// What a vehicle actor is told.
pub enum VehicleMessage {
    /// The control period.
    Tick,
    /// An operator's command. Answered at once: taken up or refused.
    Command {
        /// Its id.
        id: CommandId,
        /// The command.
        command: VehicleCommand,
        /// How it is flown, if it takes more than one flight; empty if the model flies it by itself.
        legs: VecDeque<VehicleCommand>,
        /// Not to be begun before.
        not_before: NodeTime,
        /// Where the receipt goes; none if the node itself commands.
        reply: Option<RpcReplyPort<CommandReceipt>>,
    },
    /// A payload's answer to a request of the model.
    PayloadResult {
        /// Which request.
        request: RequestId,
        /// Why not; absent if accepted.
        refusal: Option<Refusal>,
    },
    /// Put this route on the autopilot.
    UploadRoute(Vec<RoutePoint>),
    /// Write a parameter of the autopilot. Answered when it is written, or known not to be.
    WriteParameter(ParameterOrder),
    /// Make the plugin fail.
    Drill(FaultDrill),
    /// End the plugin's process, or make it panic if it has none of its own.
    Kill,
    /// Go over to another version of the model.
    Exchange(Arc<Plugin>, ExchangeReply),
    /// Forget all failures of the model and start it anew.
    Reset,
}

/// A write that an operator asked for.
pub struct ParameterOrder {
    /// Its number.
    pub id: CommandId,
    /// The parameter.
    pub name: String,
    /// The value.
    pub value: ParameterValue,
    /// Who asked, for the event log; empty if nobody says.
    pub by: String,
    /// Where the outcome goes: the value before, and the one it has now.
    pub reply: RpcReplyPort<ParameterOutcome>,
}

/// What came of a write: the value before, if it was known, and the one it has now.
pub type ParameterOutcome = Result<(Option<ParameterValue>, ParameterValue), ParameterError>;

/// Who asked a payload for something, and where the answer goes.
pub enum Asker {
    /// An operator or another program.
    Operator(RpcReplyPort<CommandReceipt>),
    /// The UAV model of its vehicle.
    Model(RequestId),
}

/// What became of the exchange of a version.
pub type ExchangeReply = RpcReplyPort<Result<Restored, String>>;

/// What a payload actor is told.
pub enum PayloadMessage {
    /// Its tick is due.
    Tick,
    /// A command. Answered at once: taken up or refused.
    Command {
        /// Its id.
        id: CommandId,
        /// As JSON text.
        command_json: String,
        /// Who asks.
        asker: Asker,
    },
    /// Make the plugin fail.
    Drill(FaultDrill),
    /// End the plugin's process, or make it panic if it has none of its own.
    Kill,
    /// Go over to another version.
    Exchange(Arc<Plugin>, ExchangeReply),
    /// Forget all failures and start anew.
    Reset,
}

/// What the actor is told that makes tracks of what sensors saw.
pub enum TrackingMessage {
    /// Take in what was seen.
    Step,
    /// An operator wants something of a track.
    Order(TrackOrder, RpcReplyPort<Result<(), Refusal>>),
}

/// What the actor is told that speaks with the other nodes.
pub enum SwarmMessage {
    /// Something has arrived, or it is time to look.
    Look,
    /// Ask another node something.
    Ask {
        /// Whom.
        to: NodeId,
        /// What.
        ask: Box<Ask>,
        /// How long to wait.
        within: Duration,
        /// Where the answer goes.
        answer: oneshot::Sender<Result<Answer, Refusal>>,
    },
    /// This node has done what another one asked for.
    Served {
        /// Who asked.
        to: NodeId,
        /// Its number.
        id: u64,
        /// The answer.
        answer: Box<Answer>,
    },
    /// A video of another node is to come here.
    ExpectVideo {
        /// Whose.
        from: NodeId,
        /// Where its pictures go.
        stream: Box<RemoteStream>,
        /// This node's number for it.
        number: oneshot::Sender<u32>,
    },
    /// It is not looked at any more.
    ForgetVideo {
        /// Whose.
        from: NodeId,
        /// This node's number for it.
        number: u32,
    },
    /// A node does not want a video of this one any more.
    EndVideo {
        /// Which node.
        to: NodeId,
        /// Its number for the stream.
        number: u32,
    },
    /// A decoder of it needs a key picture.
    WantVideoKey {
        /// Whose.
        from: NodeId,
        /// This node's number for it.
        number: u32,
    },
    /// A picture for a node that wants it.
    SendVideo {
        /// Which node.
        to: NodeId,
        /// Its number for the stream.
        number: u32,
        /// The picture.
        frame: Arc<EncodedFrame>,
        /// Whether the link carries it.
        taken: oneshot::Sender<bool>,
    },
    /// Take the leadership, because somebody asks for it.
    TakeLeadership(oneshot::Sender<Result<(), Refusal>>),
}

/// An ask as a message of the actor.
#[must_use]
pub fn asking(to: NodeId, ask: Ask, within: Duration) -> (SwarmMessage, oneshot::Receiver<Result<Answer, Refusal>>) {
    let (answer, answered) = oneshot::channel();
    let message = SwarmMessage::Ask {
        to,
        ask: Box::new(ask),
        within,
        answer,
    };
    (message, answered)
}

/// The mailbox of a vehicle's or a payload's present actor, if it has one.
pub struct ActorSlot<M> {
    actor: ArcSwapOption<ActorRef<M>>,
    /// A tick has been sent and not yet been taken up: at most one waits in the mailbox.
    tick_waiting: AtomicBool,
}

impl<M> Default for ActorSlot<M> {
    fn default() -> Self {
        Self {
            actor: ArcSwapOption::empty(),
            tick_waiting: AtomicBool::new(false),
        }
    }
}

impl<M: Message> ActorSlot<M> {
    /// The running actor.
    pub fn get(&self) -> Option<Arc<ActorRef<M>>> {
        self.actor.load_full()
    }

    /// An incarnation begins: no tick waits for it.
    pub fn begin(&self, actor: ActorRef<M>) {
        self.take_tick();
        self.actor.store(Some(Arc::new(actor)));
    }

    /// The fleet knows that it has ended, or ends it.
    pub fn end(&self) -> Option<Arc<ActorRef<M>>> {
        self.actor.swap(None)
    }

    /// The control loop wakes it, if no tick waits.
    pub fn send_tick(&self, tick: M) {
        let Some(actor) = self.get() else { return };
        if !self.tick_waiting.swap(true, Ordering::AcqRel) && actor.cast(tick).is_err() {
            // The actor has ended; its next incarnation clears the mark.
            self.take_tick();
        }
    }

    /// It takes the tick up.
    pub fn take_tick(&self) {
        self.tick_waiting.store(false, Ordering::Release);
    }
}
