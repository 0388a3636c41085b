//! The actor of one endpoint: owns a socket or line, feeds the links on it, and reports what it notices.
//!
//! The bytes are moved by one task per endpoint, not by the actor's mailbox: no actor message per datagram. The actor is there
//! to be supervised: it fails when its task ends, and its task ends with it.

mod hub;
mod line;
mod udp;

use crate::address::EndpointAddress;
use crate::error::EndpointError;
use crate::event::EndpointEvent;
use crate::settings::EndpointSettings;
use crate::sighting::ReferenceSink;
use crate::table::LinkTable;
use hub::Hub;
use ractor::{Actor, ActorProcessingErr, ActorRef};
use skein_domain::Clock;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::OwnedSemaphorePermit;
use tokio::task::JoinHandle;

/// How long a start waits for the endpoint's earlier task to let go of the port.
const LEASE_WAIT: Duration = Duration::from_secs(2);

/// Where an endpoint's events go. Called on the endpoint's task: must return at once.
pub type EventSink = Arc<dyn Fn(EndpointEvent) + Send + Sync>;

/// What an endpoint is started with.
#[derive(Clone)]
pub struct EndpointArguments {
    /// Its settings.
    pub settings: EndpointSettings,
    /// The node's clock.
    pub clock: Arc<dyn Clock>,
    /// The node's links; survives a restart of the actor.
    pub links: Arc<LinkTable>,
    /// Where events go.
    pub events: EventSink,
    /// Where the places of others go that are heard here, if anybody wants to know.
    pub references: Option<Arc<dyn ReferenceSink>>,
}

/// The actor of one endpoint. A failed start gives an [`EndpointError`] inside `ractor::SpawnErr::StartupFailed`.
#[derive(Debug, Default)]
pub struct Endpoint;

/// Messages of the actor; only its own task sends one, when it has ended.
#[derive(Debug)]
pub struct EndpointMessage(EndpointError);

/// State of the actor: the task ends when this is dropped.
#[derive(Debug)]
pub struct EndpointState {
    task: Option<JoinHandle<()>>,
}

impl Drop for EndpointState {
    fn drop(&mut self) {
        if let Some(task) = &self.task {
            task.abort();
        }
    }
}

impl Actor for Endpoint {
    type Msg = EndpointMessage;
    type State = EndpointState;
    type Arguments = EndpointArguments;

    async fn pre_start(
        &self,
        myself: ActorRef<Self::Msg>,
        arguments: Self::Arguments,
    ) -> Result<Self::State, ActorProcessingErr> {
        let name = arguments.settings.name.clone();
        check(&arguments.settings)?;
        let slot = arguments.links.slot(&name);
        let lease = tokio::time::timeout(LEASE_WAIT, Arc::clone(&slot.lease).acquire_owned()).await;
        let Ok(Ok(lease)) = lease else {
            return Err(EndpointError::NameInUse { name }.into());
        };
        let hub = Hub::new(arguments, slot);
        let task = start(hub, lease).await?;
        // The task is watched: its panic, too, becomes the actor's failure and so the supervisor's business.
        let watch = tokio::spawn(async move {
            let detail = match AbortOnDrop(task).join().await {
                Ok(error) => error,
                Err(join) => EndpointError::Ended {
                    name,
                    detail: join.to_string(),
                },
            };
            // The actor may be gone already.
            let _ = myself.cast(EndpointMessage(detail));
        });
        Ok(EndpointState { task: Some(watch) })
    }

    async fn handle(
        &self,
        _myself: ActorRef<Self::Msg>,
        message: Self::Msg,
        _state: &mut Self::State,
    ) -> Result<(), ActorProcessingErr> {
        Err(message.0.into())
    }

    async fn post_stop(&self, _myself: ActorRef<Self::Msg>, state: &mut Self::State) -> Result<(), ActorProcessingErr> {
        if let Some(task) = state.task.take() {
            task.abort();
            // Ends with "cancelled"; the port is free then.
            let _ = task.await;
        }
        Ok(())
    }
}

/// The receiving task, which ends with whoever waits for it.
struct AbortOnDrop(JoinHandle<EndpointError>);

impl AbortOnDrop {
    async fn join(mut self) -> Result<EndpointError, tokio::task::JoinError> {
        (&mut self.0).await
    }
}

impl Drop for AbortOnDrop {
    fn drop(&mut self) {
        self.0.abort();
    }
}

/// Binds or prepares the line, and starts the task that works it. The task holds the lease until its socket is closed.
async fn start(mut hub: Hub, lease: OwnedSemaphorePermit) -> Result<JoinHandle<EndpointError>, EndpointError> {
    match hub.settings.address.clone() {
        EndpointAddress::UdpListen(address) => {
            let port = udp::Port::listen(&mut hub, address)?;
            Ok(tokio::spawn(async move {
                let error = port.run(hub).await;
                drop(lease);
                error
            }))
        }
        EndpointAddress::UdpConnect(address) => {
            let port = udp::Port::connect(&mut hub, address).await?;
            Ok(tokio::spawn(async move {
                let error = port.run(hub).await;
                drop(lease);
                error
            }))
        }
        EndpointAddress::TcpConnect(_) | EndpointAddress::Serial { .. } => Ok(tokio::spawn(async move {
            let error = line::run(hub).await;
            drop(lease);
            error
        })),
    }
}

/// Settings that could only fail later, or silently.
fn check(settings: &EndpointSettings) -> Result<(), EndpointError> {
    let wrong = |detail: &str| {
        Err(EndpointError::Setting {
            name: settings.name.clone(),
            detail: detail.to_owned(),
        })
    };
    let link = &settings.link;
    if link.own_system_id == 0 || link.own_component_id == 0 {
        return wrong("own_system_id and own_component_id must be 1 to 255");
    }
    if !(2.0..=200.0).contains(&link.setpoint_rate_hz) {
        return wrong("setpoint_rate_hz must be 2 to 200: PX4 leaves OFFBOARD under about 1 Hz");
    }
    let times = [
        link.lost_after_s,
        link.duplicate_clear_s,
        link.ack_timeout_s,
        link.confirm_timeout_s,
        link.progress_timeout_s,
        settings.reconnect_max_s,
    ];
    if times.iter().any(|seconds| !seconds.is_finite() || *seconds <= 0.0) {
        return wrong("times must be over 0 s");
    }
    Ok(())
}
