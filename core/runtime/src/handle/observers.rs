//! Tracks of the swarm's making at run time: changed, dropped, kept in view; and what other sensors tell.
//!
//! Must never do: decide what is tracked; that is the tracking actor's, on the node that coordinates.

use super::{NodeHandle, PLAN_WITHIN, Targets};
use ractor::rpc::CallResult;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use skein_coordination::TrackObservation;
use skein_coordination::observing::{ObserverProposal, ranked, sides};
use skein_domain::payload::Target;
use skein_domain::{PositionNed, Refusal, VehicleCommand, VehicleId};
use skein_state::asks::{Ask, TrackOrder};
use skein_state::{SeenCounts, TrackingMessage};
use skein_tracking::{Detected, Detection, candidates, sightings};
use skein_view::{CommandReceipt, FleetSnapshot};

/// A name of a track has no more characters.
pub const LONGEST_TRACK_NAME: usize = 32;

/// How a track is to be kept in view.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, ts_rs::TS, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ObserveRequest {
    /// By these vehicles; by the best placed ones if left out.
    #[serde(default)]
    #[schemars(length(min = 1, max = 16), extend("uniqueItems" = true))]
    pub vehicles: Option<Vec<VehicleId>>,
    /// By so many, where no vehicles are named; two if left out.
    #[serde(default)]
    #[schemars(range(min = 1, max = 16))]
    pub count: Option<u8>,
    /// Horizontal distance to keep, in metres; each model's own if left out.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 100_000.0))]
    pub stand_off_m: Option<f64>,
}

/// A vehicle that was asked to keep a track in view, and what it answered.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ts_rs::TS, JsonSchema)]
pub struct AskedObserver {
    /// From which side it is to look: the bearing from the track to the vehicle, in radians clockwise from north.
    pub bearing_rad: f64,
    /// Its answer.
    pub receipt: CommandReceipt,
}

/// Vehicles that keep something in view if nobody says how many.
const OBSERVERS: usize = 2;

impl NodeHandle {
    /// Takes what another sensor saw. Gives how much of it there was room for.
    ///
    /// # Errors
    /// Which detection cannot be true, and why; then nothing is taken.
    pub fn tell_detections(&self, source: &str, detections: Vec<Detection>) -> Result<Detected, (usize, String)> {
        let sightings = sightings(source, detections, self.now())?;
        let all = sightings.len();
        let seen = &self.shared.observed.seen;
        let taken = seen.tell(sightings);
        let refused = all - taken;
        seen.count_refused(refused);
        Ok(Detected { taken, refused })
    }

    /// How much was seen since the node started.
    #[must_use]
    pub fn seen_counts(&self) -> SeenCounts {
        self.shared.observed.seen.counts()
    }

    /// Names a track, or has it kept longer; what is absent stays as it is.
    ///
    /// # Errors
    /// When there is no such track, it was told as it is, the name is none, or nobody coordinates.
    pub async fn change_track(&self, track: u64, name: Option<String>, pinned: Option<bool>) -> Result<(), Refusal> {
        let printable =
            |name: &String| name.chars().count() <= LONGEST_TRACK_NAME && !name.chars().any(char::is_control);
        if !name.as_ref().is_none_or(printable) {
            return Err(Refusal::invalid(format!(
                "a name has {LONGEST_TRACK_NAME} characters at most, all of which can be printed"
            )));
        }
        self.order_track(TrackOrder::Change { track, name, pinned }).await
    }

    /// Ends a track. What sensors see under their present names begins no new one.
    ///
    /// # Errors
    /// When there is no such track, it was told as it is, or nobody coordinates.
    pub async fn drop_track(&self, track: u64) -> Result<(), Refusal> {
        self.order_track(TrackOrder::Drop { track }).await
    }

    /// Here, or at the node that coordinates.
    async fn order_track(&self, order: TrackOrder) -> Result<(), Refusal> {
        match self.coordinator_elsewhere()? {
            Some(node) => self.done(node, Ask::Track(order)).await,
            None => self.order_track_here(order).await,
        }
    }

    pub(crate) async fn order_track_here(&self, order: TrackOrder) -> Result<(), Refusal> {
        if !self.shared.coordinates() {
            return Err(Refusal::not_running("a coordinator of this swarm (none is there)"));
        }
        let not_running = || Refusal::not_running("tracking");
        let tracking = self.parts.tracking.load_full().ok_or_else(not_running)?;
        match tracking
            .call(|reply| TrackingMessage::Order(order, reply), Some(PLAN_WITHIN))
            .await
        {
            Ok(CallResult::Success(answer)) => answer,
            Ok(CallResult::Timeout) => Err(Refusal::timed_out("tracking", PLAN_WITHIN.as_secs_f64())),
            _ => Err(not_running()),
        }
    }

    /// Vehicles that could keep a track in view, the best placed first.
    ///
    /// # Errors
    /// When there is no such track.
    pub fn observers_of(&self, track: u64) -> Result<Vec<ObserverProposal>, Refusal> {
        let target = self.place_of(track)?;
        Ok(ranked(&target, &candidates(&self.snapshot())))
    }

    fn place_of(&self, track: u64) -> Result<PositionNed, Refusal> {
        self.shared.observed.steering_track(track).map(|known| known.position)
    }

    /// Has vehicles keep a track in view from several sides; each answers for itself. Where one no longer can, the node that coordinates asks the next best.
    ///
    /// # Errors
    /// When there is no such track, or nobody can be asked.
    pub async fn observe_track(
        &self,
        console: Option<&str>,
        track: u64,
        request: &ObserveRequest,
    ) -> Result<Vec<AskedObserver>, Refusal> {
        let target = self.place_of(track)?;
        let snapshot = self.snapshot();
        let chosen = chosen(&target, &snapshot, request)?;
        let mut asked = Vec::new();
        for (vehicle, bearing_rad) in sides(&target, &chosen) {
            let command = VehicleCommand::Observe {
                target: Target::Track { track },
                stand_off_m: request.stand_off_m,
                height_m: None,
                bearing_rad: Some(bearing_rad),
            };
            let (handle, console) = (self.clone(), console.map(str::to_owned));
            // All at once: none waits for another one's answer.
            asked.push(tokio::spawn(async move {
                let targets = Targets::Vehicles(vec![vehicle]);
                let receipts = handle.command_from(console.as_deref(), &targets, command).await;
                receipts
                    .into_iter()
                    .next()
                    .map(|receipt| AskedObserver { bearing_rad, receipt })
            }));
        }
        let mut answers = Vec::new();
        for answer in asked {
            answers.extend(answer.await.ok().flatten());
        }
        let by: Vec<(VehicleId, f64)> = answers
            .iter()
            .filter(|answer| answer.receipt.refusal.is_none())
            .map(|answer| (answer.receipt.vehicle, answer.bearing_rad))
            .collect();
        if !by.is_empty() {
            let stand_off_m = request.stand_off_m;
            let order = TrackOrder::Observe(TrackObservation { track, by, stand_off_m });
            // They observe in any case; without a coordinator nobody relieves them.
            if let Err(refusal) = self.order_track(order).await {
                tracing::warn!("nobody will take over from those who observe track {track}: {refusal}");
            }
        }
        answers.sort_by_key(|answer| answer.receipt.vehicle);
        Ok(answers)
    }
}

/// Who is to be asked, and where each is: those named, or the best placed.
fn chosen(
    target: &PositionNed,
    snapshot: &FleetSnapshot,
    request: &ObserveRequest,
) -> Result<Vec<(VehicleId, PositionNed)>, Refusal> {
    let ids: Vec<VehicleId> = match &request.vehicles {
        Some(named) => named.clone(),
        None => {
            let count = request.count.map_or(OBSERVERS, usize::from);
            let fit = ranked(target, &candidates(snapshot))
                .into_iter()
                .filter(|one| one.unfit.is_none());
            fit.take(count).map(|one| one.vehicle).collect()
        }
    };
    if ids.is_empty() {
        return Err(Refusal::NotEnoughVehicles { have: 0, need: 1 });
    }
    let place = |id: VehicleId| {
        let vehicle = snapshot.vehicles.iter().find(|vehicle| vehicle.id == id);
        let vehicle = vehicle.ok_or(Refusal::UnknownVehicle { vehicle: id })?;
        let at = vehicle.kinematics.ok_or(Refusal::NoPosition)?;
        Ok((id, at.position))
    };
    ids.into_iter().map(place).collect()
}
