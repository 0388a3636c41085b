//! What a node subscribes to, and how the others come to know of it where datagrams get lost.
//!
//! Must never do: rest on a declaration arriving; hand a datagram on twice.
//!
//! Over UDP Zenoh says only once what it subscribes to, and by which number it calls a key from then on. Of nodes that did not get this it hears nothing until
//! the session ends. So here no key is called by a number (one that begins with a wildcard never is), and everything is subscribed to under
//! several names, of which one after the other is given up and declared anew.

use crate::{OpenError, arrive, start};
use skein_bus::arrivals::Arrivals;
use skein_domain::{NodeId, NodeTime};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use zenoh::Wait;
use zenoh::pubsub::Subscriber;

/// Different words for the first part of every key; none of them begins with a letter that stands for itself alone.
const NAMES: [&str; 6] = ["*", "s$*", "sk$*", "ske$*", "skei$*", "skein$*"];
/// One name is declared anew so often, in seconds. Who lost all six, at a third of loss one of seven hundred, hears of the next one so soon.
const ANEW_AFTER_S: f64 = 1.0;

/// The subscriptions of one node. They end when this is dropped.
#[derive(Debug)]
pub(crate) struct Hearing {
    session: zenoh::Session,
    /// What of the keys follows their first part: for this node, for all.
    receivers: [String; 2],
    /// By their name; none while one could not be declared.
    subscribers: Vec<Option<[Subscriber<()>; 2]>>,
    /// All names hear everything; this one hands it on.
    hands_on: Arc<AtomicUsize>,
    me: NodeId,
    arrivals: Arc<Arrivals>,
    /// When which name is next; none if nothing gets lost underneath.
    next: Option<(NodeTime, usize)>,
}

impl Hearing {
    /// Subscribes; again and again, if datagrams may get `lost`.
    pub(crate) fn begin(
        session: zenoh::Session,
        receivers: [String; 2],
        lost: bool,
        me: NodeId,
        arrivals: Arc<Arrivals>,
    ) -> Result<Self, OpenError> {
        let mut hearing = Self {
            session,
            receivers,
            subscribers: Vec::new(),
            hands_on: Arc::default(),
            me,
            arrivals,
            next: lost.then_some((NodeTime(0), 0)),
        };
        let names = if lost { NAMES.len() } else { 1 };
        for name in 0..names {
            let declared = hearing.declare(name).map_err(start)?;
            hearing.subscribers.push(Some(declared));
        }
        Ok(hearing)
    }

    /// Declares what is due anew.
    pub(crate) fn refresh(&mut self, now: NodeTime) {
        let Some((due, name)) = self.next.filter(|(due, _)| *due <= now) else {
            return;
        };
        let following = (name + 1) % self.subscribers.len();
        // The first time, everything has just been declared.
        self.next = Some((now.plus_seconds(ANEW_AFTER_S), following));
        if due == NodeTime(0) {
            return;
        }
        // One that stays hands on what comes meanwhile.
        self.hands_on.store(following, Ordering::Release);
        let Some(place) = self.subscribers.get_mut(name) else {
            return;
        };
        drop(place.take());
        let declared = self.declare(name).ok();
        if let Some(place) = self.subscribers.get_mut(name) {
            *place = declared;
        }
    }

    fn declare(&self, name: usize) -> zenoh::Result<[Subscriber<()>; 2]> {
        let [mine, of_all] = &self.receivers;
        Ok([self.subscriber(name, mine)?, self.subscriber(name, of_all)?])
    }

    fn subscriber(&self, name: usize, receiver: &str) -> zenoh::Result<Subscriber<()>> {
        let first = NAMES.get(name).copied().unwrap_or("*");
        let (me, arrivals, hands_on) = (self.me, Arc::clone(&self.arrivals), Arc::clone(&self.hands_on));
        let subscriber = self.session.declare_subscriber(format!("{first}/{receiver}/*/*"));
        subscriber
            .callback(move |sample| {
                if hands_on.load(Ordering::Acquire) == name {
                    arrive(&arrivals, me, &sample);
                }
            })
            .wait()
    }
}
