//! Trajectories for everyone outside of the node: planned, flown, ended, and how each is getting on.

use super::{NodeHandle, PLAN_WITHIN};
use crate::coordinator::{CoordinatorMessage, TrajectoryAnswer, TrajectoryAsk};
use skein_coordination::Flight;
use skein_domain::link::RoutePoint;
use skein_domain::{
    NodeTime, Refusal, RouteUpload, TrajectoryObjection, TrajectoryPlan, TrajectoryProgress, TrajectoryRequest,
    TrajectoryStatus, VehicleId,
};
use skein_state::VehicleMessage;
use skein_state::asks::{Answer, Ask};

impl NodeHandle {
    /// Plans trajectories and flies them.
    ///
    /// # Errors
    /// Everything that is against them, item by item; nothing has changed then.
    pub async fn fly_trajectories(
        &self,
        request: TrajectoryRequest,
    ) -> Result<TrajectoryPlan, Vec<TrajectoryObjection>> {
        self.ask_trajectories(request, true).await
    }

    /// Plans trajectories without flying them.
    ///
    /// # Errors
    /// As [`Self::fly_trajectories`].
    pub async fn preview_trajectories(
        &self,
        request: TrajectoryRequest,
    ) -> Result<TrajectoryPlan, Vec<TrajectoryObjection>> {
        self.ask_trajectories(request, false).await
    }

    async fn ask_trajectories(&self, request: TrajectoryRequest, fly: bool) -> TrajectoryAnswer {
        let against = |refusal| vec![TrajectoryObjection { vehicle: None, refusal }];
        let Some(node) = self.coordinator_elsewhere().map_err(against)? else {
            return self.ask_trajectories_here(request, fly).await;
        };
        let request = Box::new(request);
        match self.ask(node, Ask::Trajectories { request, fly }, PLAN_WITHIN).await {
            Ok(Answer::Trajectories(outcome)) => outcome,
            Ok(_) => Err(Vec::new()),
            Err(refusal) => Err(against(refusal)),
        }
    }

    pub(crate) async fn ask_trajectories_here(&self, request: TrajectoryRequest, fly: bool) -> TrajectoryAnswer {
        let against = |refusal| Err(vec![TrajectoryObjection { vehicle: None, refusal }]);
        let asked_at = self.now();
        let message = |reply| {
            CoordinatorMessage::PlanTrajectories(Box::new(TrajectoryAsk {
                request,
                fly,
                asked_at,
                reply,
            }))
        };
        self.ask_coordinator(message).await.unwrap_or_else(against)
    }

    /// Ends all trajectories; who flew one holds. Whose they were.
    ///
    /// # Errors
    /// When the coordinator is not running.
    pub async fn end_trajectories(&self) -> Result<Vec<VehicleId>, Refusal> {
        let Some(node) = self.coordinator_elsewhere()? else {
            return self.end_trajectories_here().await;
        };
        match self.ask(node, Ask::EndTrajectories, PLAN_WITHIN).await? {
            Answer::Ended(outcome) => outcome,
            _ => Ok(Vec::new()),
        }
    }

    pub(crate) async fn end_trajectories_here(&self) -> Result<Vec<VehicleId>, Refusal> {
        self.coordinate(CoordinatorMessage::EndTrajectories).await
    }

    /// Puts routes on the autopilots of this node's own vehicles.
    pub(crate) fn upload_here(&self, routes: Vec<(VehicleId, Vec<RoutePoint>)>) -> Result<(), Refusal> {
        for (vehicle, points) in routes {
            let record = self.shared.vehicles.known(vehicle)?;
            if let Some(actor) = record.actor.get() {
                // What becomes of it is told as an event.
                let _ = actor.cast(VehicleMessage::UploadRoute(points));
            }
        }
        Ok(())
    }

    /// How each is getting on, by ascending id. One that has ended is told of until the vehicle is given another.
    #[must_use]
    pub fn trajectories(&self) -> Vec<TrajectoryStatus> {
        let now = self.now();
        let flights = self.shared.coordination.read().flights.clone();
        let upload = |id| self.shared.vehicles.record(id)?.route.lock().state();
        flights
            .into_iter()
            .map(|(id, flight)| status(flight, upload(id), now))
            .collect()
    }
}

fn status(flight: Flight, upload: Option<RouteUpload>, now: NodeTime) -> TrajectoryStatus {
    let elapsed_s = now.seconds_since(flight.trajectory.start);
    let passed = flight.plan.passes_s.iter().filter(|s| **s <= elapsed_s).count();
    TrajectoryStatus {
        vehicle: flight.plan.vehicle,
        start: flight.trajectory.start,
        passed: u32::try_from(passed).unwrap_or(u32::MAX),
        elapsed_s,
        progress: match flight.ended {
            Some(why) => TrajectoryProgress::Ended { why },
            None if flight.finished => TrajectoryProgress::Flown,
            None if elapsed_s < 0.0 => TrajectoryProgress::Waiting,
            None => TrajectoryProgress::Flying,
        },
        plan: flight.plan,
        waypoints: flight.waypoints,
        upload,
    }
}
