//! The actor of one endpoint: owns a socket or line, feeds the links on it, and reports what it notices.

use crate::error::EndpointError;
use crate::event::EndpointEvent;
use crate::settings::EndpointSettings;
use crate::table::LinkTable;
use ractor::{Actor, ActorProcessingErr, ActorRef};
use skein_domain::Clock;
use std::sync::Arc;

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
}

/// The actor of one endpoint. A failed start gives an [`EndpointError`] inside `ractor::SpawnErr::StartupFailed`.
#[derive(Debug, Default)]
pub struct Endpoint;

/// Messages of the actor; it only tells itself things, so that nobody else can make one.
#[derive(Debug)]
pub struct EndpointMessage(pub(crate) EndpointError);

/// State of the actor.
pub struct EndpointState {}

impl Actor for Endpoint {
    type Msg = EndpointMessage;
    type State = EndpointState;
    type Arguments = EndpointArguments;

    async fn pre_start(
        &self,
        _myself: ActorRef<Self::Msg>,
        _arguments: Self::Arguments,
    ) -> Result<Self::State, ActorProcessingErr> {
        Ok(EndpointState {})
    }

    async fn handle(
        &self,
        _myself: ActorRef<Self::Msg>,
        message: Self::Msg,
        _state: &mut Self::State,
    ) -> Result<(), ActorProcessingErr> {
        Err(message.0.into())
    }
}
