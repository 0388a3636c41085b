//! What the demonstration can fly: one file per scenario, each with its own criteria, judged by the simulator's truth.

mod car;
mod fence;
mod formations;
mod join_leave;
mod leader_loss;
mod mixed;
mod no_coordinator;
mod observe;
mod observe_video;
mod tour;

use super::layout::Layout;
use super::referee::Referee;
use super::report::Criterion;
use super::scenario_runner::ScenarioRunner;
use crate::args::Scenario;
use skein_config::NodeConfig;
use skein_sim::SimSettings;

/// What a scenario may change of node and simulation before they are started.
pub struct Setup {
    /// How many vehicles.
    pub vehicles: u8,
    /// The node's configuration.
    pub node: NodeConfig,
    /// The simulation's settings; the ports are filled in later.
    pub simulation: SimSettings,
}

/// A scenario.
pub trait Flight {
    /// Before node and simulation are started.
    fn prepare(&self, _setup: &mut Setup) {}

    /// The whole flight.
    ///
    /// # Errors
    /// When something that should happen does not, or is refused.
    async fn fly(&mut self, runner: &ScenarioRunner<'_>) -> anyhow::Result<()>;

    /// What it has to meet beside what every flight has to; also after a flight that broke off.
    fn criteria(&self, referee: &Referee) -> Vec<Criterion>;
}

/// The swarm's origin, fixed to the simulation's: positions of the node and of the truth are then the same, whichever vehicle is heard
/// first.
fn swarm_origin() -> skein_domain::Geodetic {
    SimSettings::default().origin
}

/// The scenario that was asked for.
pub enum Chosen {
    /// The tour.
    Tour(tour::Tour),
    /// Formations.
    Formations(formations::Formations),
    /// Leader lost and replaced.
    LeaderLoss(leader_loss::LeaderLoss),
    /// Members change.
    JoinLeave(join_leave::JoinLeave),
    /// Different vehicles.
    Mixed(mixed::Mixed),
    /// Where not to fly.
    Fence(fence::Fence),
    /// Without a coordinator.
    NoCoordinator(no_coordinator::NoCoordinator),
    /// What cameras see.
    Observe(observe::Observe),
    /// Video of the cameras.
    ObserveVideo(observe_video::ObserveVideo),
}

impl Chosen {
    /// By its name.
    pub fn new(scenario: Scenario, layout: Layout) -> Self {
        match scenario {
            Scenario::Tour => Self::Tour(tour::Tour::new(layout)),
            Scenario::LeaderLoss => Self::LeaderLoss(leader_loss::LeaderLoss::default()),
            Scenario::NoCoordinator => Self::NoCoordinator(no_coordinator::NoCoordinator::default()),
            Scenario::Formations => Self::Formations(formations::Formations::default()),
            Scenario::JoinLeave => Self::JoinLeave(join_leave::JoinLeave::default()),
            Scenario::Mixed => Self::Mixed(mixed::Mixed::default()),
            Scenario::Observe => Self::Observe(observe::Observe::default()),
            Scenario::ObserveVideo => Self::ObserveVideo(observe_video::ObserveVideo::new(layout)),
            Scenario::Fence => Self::Fence(fence::Fence::default()),
        }
    }
}

impl Flight for Chosen {
    fn prepare(&self, setup: &mut Setup) {
        match self {
            Self::Tour(flight) => flight.prepare(setup),
            Self::Formations(flight) => flight.prepare(setup),
            Self::LeaderLoss(flight) => flight.prepare(setup),
            Self::JoinLeave(flight) => flight.prepare(setup),
            Self::Mixed(flight) => flight.prepare(setup),
            Self::Fence(flight) => flight.prepare(setup),
            Self::NoCoordinator(flight) => flight.prepare(setup),
            Self::Observe(flight) => flight.prepare(setup),
            Self::ObserveVideo(flight) => flight.prepare(setup),
        }
    }

    async fn fly(&mut self, runner: &ScenarioRunner<'_>) -> anyhow::Result<()> {
        match self {
            Self::Tour(flight) => flight.fly(runner).await,
            Self::Formations(flight) => flight.fly(runner).await,
            Self::LeaderLoss(flight) => flight.fly(runner).await,
            Self::JoinLeave(flight) => flight.fly(runner).await,
            Self::Mixed(flight) => flight.fly(runner).await,
            Self::Fence(flight) => flight.fly(runner).await,
            Self::NoCoordinator(flight) => flight.fly(runner).await,
            Self::Observe(flight) => flight.fly(runner).await,
            Self::ObserveVideo(flight) => flight.fly(runner).await,
        }
    }

    fn criteria(&self, referee: &Referee) -> Vec<Criterion> {
        match self {
            Self::Tour(flight) => flight.criteria(referee),
            Self::Formations(flight) => flight.criteria(referee),
            Self::LeaderLoss(flight) => flight.criteria(referee),
            Self::JoinLeave(flight) => flight.criteria(referee),
            Self::Mixed(flight) => flight.criteria(referee),
            Self::Fence(flight) => flight.criteria(referee),
            Self::NoCoordinator(flight) => flight.criteria(referee),
            Self::Observe(flight) => flight.criteria(referee),
            Self::ObserveVideo(flight) => flight.criteria(referee),
        }
    }
}
