//! What other nodes ask of this one, carried out as if it had been asked here.
//!
//! Must never do: pass anything on to yet another node.

use super::NodeHandle;
use skein_domain::{NodeTime, Refusal, TrajectoryObjection, TrajectoryPlan, TrajectoryRequest, TrajectoryStart};
use skein_state::SwarmMessage;
use skein_state::asks::{Answer, ApiAnswer, Ask};

/// Does what is asked. `ahead_us`: how far this node's clock is ahead of the asker's, if that was measured.
pub async fn carry_out(handle: NodeHandle, ask: Ask, ahead_us: Option<i64>) -> Answer {
    match ask {
        Ask::Orders(orders) => Answer::Receipts(handle.carry_out(orders).await),
        Ask::EmergencyStop(ids) => Answer::Receipts(handle.stop_motors_here(&ids)),
        Ask::Upload(routes) => Answer::Done(handle.upload_here(routes)),
        Ask::Formation(request) => Answer::Formation(handle.set_formation_here(*request).await),
        Ask::Forecast(request) => Answer::Forecast(Box::new(handle.foresee_formation_here(*request).await)),
        Ask::Dissolve => Answer::Done(handle.dissolve_formation_here().await),
        Ask::Route(route) => Answer::Route(handle.set_route_here(route).await),
        Ask::Trajectories { request, fly } => Answer::Trajectories(trajectories(handle, *request, fly, ahead_us).await),
        Ask::EndTrajectories => Answer::Ended(handle.end_trajectories_here().await),
        Ask::Fences(plan) => Answer::Done(handle.set_fences_here(*plan)),
        Ask::Preflight => Answer::Preflight(handle.preflight().vehicles),
        Ask::Track(order) => Answer::Done(handle.order_track_here(order).await),
        Ask::TakeLeadership => Answer::Done(take_leadership(&handle).await),
        Ask::Video {
            to,
            number,
            vehicle,
            payload,
            small,
        } => Answer::Done(handle.streams().send_video(to, number, vehicle, &payload, small)),
        Ask::Stick { vehicle, stick, told } => {
            Answer::Done(handle.stick_from_elsewhere(vehicle, stick, told, ahead_us))
        }
        Ask::Upgrade(ask) => Answer::Upgrade(handle.exchange_version(ask).await),
        Ask::Api(request) => {
            let server = handle.shared().swarm.as_ref().and_then(|swarm| swarm.api().cloned());
            Answer::Api(match server {
                Some(server) => server(request).await,
                None => ApiAnswer {
                    status: 501,
                    headers: Vec::new(),
                    body: Vec::new(),
                },
            })
        }
    }
}

/// Takes the leadership on this node.
///
/// # Errors
/// When it cannot coordinate, or is in no swarm.
pub async fn take_leadership(handle: &NodeHandle) -> Result<(), Refusal> {
    let not_running = || Refusal::not_running("this node's part in a swarm");
    let actor = handle.shared().swarm.as_ref().and_then(|swarm| swarm.actor());
    let actor = actor.ok_or_else(not_running)?;
    let (answer, answered) = tokio::sync::oneshot::channel();
    actor
        .cast(SwarmMessage::TakeLeadership(answer))
        .map_err(|_| not_running())?;
    answered.await.map_err(|_| not_running())?
}

/// Moments in request and answer are by the asker's clock.
async fn trajectories(
    handle: NodeHandle,
    mut request: TrajectoryRequest,
    fly: bool,
    ahead_us: Option<i64>,
) -> Result<TrajectoryPlan, Vec<TrajectoryObjection>> {
    if let TrajectoryStart::At { time } = &mut request.start {
        let Some(ahead_us) = ahead_us else {
            let refusal = Refusal::Clock {
                detail: "how far the clocks of the two nodes are apart is not known yet".into(),
            };
            return Err(vec![TrajectoryObjection { vehicle: None, refusal }]);
        };
        *time = time.on_clock_ahead_by(ahead_us);
    }
    let plan = handle.ask_trajectories_here(request, fly).await?;
    Ok(TrajectoryPlan {
        start: ahead_us.map_or(NodeTime::default(), |ahead_us| plan.start.on_clock_ahead_by(-ahead_us)),
        ..plan
    })
}
