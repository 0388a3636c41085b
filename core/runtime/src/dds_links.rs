//! The actor that holds what reads vehicles whose PX4 speaks DDS, and brings their news to the fleet and the event log.
//!
//! Mailbox: one message, from itself, twice a second. Must never do: read or write DDS itself, which has a thread of its own; hold what a restart must not lose, which is
//! the table of links.

use crate::fleet::{Discovery, FleetMessage};
use crate::listening::tell;
use crate::parts::Parts;
use ractor::{Actor, ActorProcessingErr, ActorRef};
use skein_config::LinkKind;
use skein_dds::Place;
use skein_domain::SystemId;
use skein_domain::exchange::Severity;
use skein_link_dds::naming::Namespace;
use skein_link_dds::{DdsArguments, DdsEvent, DdsNode};
use skein_px4::LinkSettings;
use skein_state::SharedState;
use skein_view::{EventKind, UnadoptedVehicle};
use std::sync::Arc;
use std::time::Duration;

/// How often it is looked whether the thread still reads.
const LOOK: Duration = Duration::from_millis(500);

/// The actor.
pub struct DdsLinks;

/// What it is started with.
pub struct DdsLinksArguments {
    /// The shared state.
    pub shared: Arc<SharedState>,
    /// Where the fleet and the table of links are.
    pub parts: Arc<Parts>,
    /// The node's participant.
    pub place: Arc<Place>,
    /// How links behave.
    pub settings: LinkSettings,
}

/// Time to look.
pub struct Look;

impl Actor for DdsLinks {
    type Msg = Look;
    type State = DdsNode;
    type Arguments = DdsLinksArguments;

    async fn pre_start(
        &self,
        myself: ActorRef<Look>,
        arguments: DdsLinksArguments,
    ) -> Result<DdsNode, ActorProcessingErr> {
        let DdsLinksArguments {
            shared,
            parts,
            place,
            settings,
        } = arguments;
        // The first to ask waits until the participant's threads have started.
        let node = tokio::task::spawn_blocking(move || {
            let participant = place.participant().map_err(|error| error.to_string())?;
            let arguments = DdsArguments {
                participant,
                clock: shared.clock.clone(),
                settings,
                links: parts.dds_links.clone(),
                events: Arc::new(move |event| noticed(&shared, &parts, event)),
            };
            DdsNode::start(arguments).map_err(|error| error.to_string())
        });
        let node = node.await??;
        myself.send_interval(LOOK, || Look);
        Ok(node)
    }

    async fn handle(&self, _: ActorRef<Look>, _: Look, node: &mut DdsNode) -> Result<(), ActorProcessingErr> {
        if node.goes_on() {
            Ok(())
        } else {
            Err("the thread that reads has ended".into())
        }
    }
}

/// What a vehicle's place on DDS is called where endpoints are named.
fn named(namespace: &Namespace) -> String {
    format!("DDS {namespace}")
}

fn noticed(shared: &SharedState, parts: &Parts, event: DdsEvent) {
    // Before a vehicle is admitted nothing that it says is believed, its system id neither.
    let not_taken = |namespace: &Namespace, why: String| {
        tell(
            parts,
            FleetMessage::Trouble(UnadoptedVehicle {
                system_id: SystemId(0),
                endpoint: named(namespace),
                why,
            }),
        );
    };
    let (severity, text) = match event {
        DdsEvent::Discovered {
            link,
            system_id,
            releases,
        } => {
            tracing::info!(namespace = %link.namespace(), ?releases, "messages of a vehicle fit");
            let endpoint = named(link.namespace());
            shared.vehicles.forget_unadopted(|u| u.endpoint == endpoint);
            return tell(
                parts,
                FleetMessage::Discovered(Discovery {
                    endpoint,
                    kind: LinkKind::Dds,
                    link,
                    system_id: SystemId(system_id),
                }),
            );
        }
        DdsEvent::Refused { namespace, mismatch } => return not_taken(&namespace, mismatch.to_string()),
        DdsEvent::Incomplete { namespace, missing } => {
            return not_taken(&namespace, format!("nothing comes on {}", missing.join(", ")));
        }
        DdsEvent::Duplicate { namespace, system_id } => {
            let why = format!("two speak as system id {system_id}; give one another namespace");
            return not_taken(&namespace, why);
        }
        DdsEvent::DuplicateCleared { namespace, system_id } => {
            let endpoint = named(&namespace);
            shared.vehicles.forget_unadopted(|u| u.endpoint == endpoint);
            let text = format!("system id {system_id} is unique again on {endpoint}");
            (Severity::Advisory, text)
        }
        DdsEvent::Ignored { namespace, mismatch } => (Severity::Warning, format!("{}: {mismatch}", named(&namespace))),
        DdsEvent::ForeignPublisher { topic } => (
            Severity::Critical,
            format!("another program writes to {topic}, from which a vehicle takes commands"),
        ),
    };
    shared
        .events
        .record(shared.now(), None, severity, EventKind::Notice, text);
}
