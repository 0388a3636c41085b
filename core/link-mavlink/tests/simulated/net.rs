//! A node's endpoints for tests: real sockets, real time, events in a channel.

use ractor::{Actor, ActorRef};
use skein_domain::link::{LinkEvent, VehicleLink};
use skein_domain::{AutopilotCommand, Clock, NodeTime, Refusal, RequestId};
use skein_link_mavlink::endpoint::EndpointMessage;
use skein_link_mavlink::{
    Endpoint, EndpointAddress, EndpointArguments, EndpointError, EndpointEvent, EndpointSettings, LinkTable, Px4Link,
    ReferenceSink,
};
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::{Duration, Instant};
use tokio::sync::mpsc::{UnboundedReceiver, UnboundedSender, unbounded_channel};

/// Longest time anything here may take: far over what it does take, so that a loaded machine fails nothing.
const PATIENCE: Duration = Duration::from_secs(40);

struct WallClock(Instant);

impl Clock for WallClock {
    fn now(&self) -> NodeTime {
        NodeTime(1_000_000 + self.0.elapsed().as_micros() as u64)
    }
}

/// One node's links.
pub struct Net {
    pub links: Arc<LinkTable>,
    pub clock: Arc<dyn Clock>,
    /// Where the places of others go.
    pub references: Option<Arc<dyn ReferenceSink>>,
    sender: UnboundedSender<EndpointEvent>,
    events: UnboundedReceiver<EndpointEvent>,
    /// Events taken from the channel that nobody has asked for yet.
    seen: Vec<EndpointEvent>,
}

impl Net {
    pub fn new() -> Self {
        let (sender, events) = unbounded_channel();
        let clock: Arc<dyn Clock> = Arc::new(WallClock(Instant::now()));
        Self {
            links: Arc::new(LinkTable::new()),
            clock,
            references: None,
            sender,
            events,
            seen: Vec::new(),
        }
    }

    pub fn now(&self) -> NodeTime {
        self.clock.now()
    }

    /// Starts an endpoint.
    pub async fn try_start(&self, name: &str, address: &str) -> Result<ActorRef<EndpointMessage>, EndpointError> {
        let address: EndpointAddress = address.parse().unwrap();
        self.try_start_with(EndpointSettings::new(name, address)).await
    }

    pub async fn try_start_with(&self, settings: EndpointSettings) -> Result<ActorRef<EndpointMessage>, EndpointError> {
        let sender = self.sender.clone();
        let arguments = EndpointArguments {
            settings,
            clock: Arc::clone(&self.clock),
            links: Arc::clone(&self.links),
            events: Arc::new(move |event| sender.send(event).unwrap_or_default()),
            references: self.references.clone(),
        };
        match Actor::spawn(None, Endpoint, arguments).await {
            Ok((actor, _)) => Ok(actor),
            Err(ractor::SpawnErr::StartupFailed(error)) => Err(*error.downcast::<EndpointError>().unwrap()),
            Err(other) => panic!("{other}"),
        }
    }

    /// Starts one that listens on a port of the system's choice; gives the port.
    pub async fn listen(&mut self, name: &str) -> (ActorRef<EndpointMessage>, SocketAddr) {
        let actor = self.try_start(name, "udp-listen://127.0.0.1:0").await.unwrap();
        let name = name.to_owned();
        let bound = self.event(
            "bound",
            move |event| matches!(event, EndpointEvent::Bound { endpoint, .. } if **endpoint == name),
        );
        let EndpointEvent::Bound {
            local_addr: Some(address),
            ..
        } = bound.await
        else {
            panic!()
        };
        (actor, address)
    }

    /// The first event of a kind, also one that came while others were waited for.
    pub async fn event(&mut self, what: &str, is: impl Fn(&EndpointEvent) -> bool) -> EndpointEvent {
        if let Some(i) = self.seen.iter().position(&is) {
            return self.seen.remove(i);
        }
        let waiting = async {
            loop {
                let event = self.events.recv().await.unwrap();
                if is(&event) {
                    return event;
                }
                self.seen.push(event);
            }
        };
        let found = tokio::time::timeout(PATIENCE, waiting).await;
        found.unwrap_or_else(|_| panic!("{what}: not among {:?}", self.seen))
    }

    /// The link of a vehicle once it has been found.
    pub async fn discovered(&mut self, id: u8) -> Arc<Px4Link> {
        let found = self.event(
            "discovered",
            |e| matches!(e, EndpointEvent::Discovered { system_id, .. } if *system_id == id),
        );
        let EndpointEvent::Discovered { link, .. } = found.await else {
            panic!()
        };
        link
    }

    /// Whether an event of a kind has come.
    pub fn has(&mut self, is: impl Fn(&EndpointEvent) -> bool) -> bool {
        while let Ok(event) = self.events.try_recv() {
            self.seen.push(event);
        }
        self.seen.iter().any(is)
    }

    /// Waits until something is the case, looking once per control period.
    pub async fn until(&self, what: &str, mut met: impl FnMut(NodeTime) -> bool) {
        let began = Instant::now();
        let mut period = tokio::time::interval(Duration::from_millis(20));
        while !met(self.now()) {
            assert!(began.elapsed() < PATIENCE, "{what}");
            period.tick().await;
        }
    }

    /// The first event of a link that fits; earlier ones are dropped.
    pub async fn link_event(&self, what: &str, link: &Px4Link, is: impl Fn(&LinkEvent) -> bool) -> LinkEvent {
        let mut found = None;
        self.until(what, |now| {
            link.read(now);
            found = link.take_events().into_iter().find(&is);
            found.is_some()
        })
        .await;
        found.unwrap()
    }

    /// Asks and waits for the outcome.
    pub async fn ask(&self, link: &Px4Link, command: AutopilotCommand) -> Result<(), Refusal> {
        let request = RequestId(self.now().0 as u32);
        link.request(self.now(), request, command);
        let is = |event: &LinkEvent| matches!(event, LinkEvent::Result { request: of, .. } if *of == request);
        match self.link_event(&format!("{command:?}"), link, is).await {
            LinkEvent::Result { outcome, .. } => outcome,
            _ => unreachable!(),
        }
    }
}
