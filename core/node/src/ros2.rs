//! The actor that shows the node to ROS 2: starts what speaks there, and fails when that does, so that it is started again.

use ractor::{Actor, ActorProcessingErr, ActorRef};
use skein_dds::Place;
use skein_ros2::Ros2Error;
use skein_runtime::{Adapter, NodeHandle};
use std::sync::Arc;
use tokio::task::JoinHandle;

/// The actor.
struct Ros2;

/// What speaks has ended; that is always a failure.
struct Ended(Ros2Error);

struct Ros2State {
    running: JoinHandle<()>,
}

impl Drop for Ros2State {
    fn drop(&mut self) {
        self.running.abort();
    }
}

impl Actor for Ros2 {
    type Msg = Ended;
    type State = Ros2State;
    type Arguments = (NodeHandle, Arc<Place>);

    async fn pre_start(
        &self,
        myself: ActorRef<Ended>,
        (node, place): Self::Arguments,
    ) -> Result<Ros2State, ActorProcessingErr> {
        let running = skein_ros2::start(node, place)?;
        let running = tokio::spawn(async move {
            let failed = running.failed().await;
            // An actor that is gone needs no word of it.
            let _ = myself.cast(Ended(failed));
        });
        Ok(Ros2State { running })
    }

    async fn handle(&self, _: ActorRef<Ended>, ended: Ended, _: &mut Ros2State) -> Result<(), ActorProcessingErr> {
        Err(ended.0.into())
    }
}

/// It as a part of the node.
pub fn adapter(place: Arc<Place>) -> Adapter {
    Adapter {
        name: "ros2".into(),
        start: Arc::new(move |node, supervisor| {
            let place = place.clone();
            Box::pin(async move {
                let spawned = Ros2::spawn_linked(None, Ros2, (node, place), supervisor).await;
                spawned.map(|(actor, _)| actor.get_id()).map_err(|e| e.to_string())
            })
        }),
    }
}
