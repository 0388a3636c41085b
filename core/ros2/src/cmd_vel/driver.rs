//! Flies one vehicle by the velocities that come in: reads them, asks the node, and hears who else commands the vehicle.
//!
//! Must never do: ask anything that [`Steering`](super::Steering) does not say.

use super::{Order, Report, Steering};
use crate::interfaces::geometry::Twist;
use futures_util::StreamExt;
use parking_lot::Mutex;
use ros2_client::Subscription;
use skein_domain::exchange::CommandProgress;
use skein_domain::{CommandId, FlightState, Refusal, Stick, VehicleCommand, VehicleId};
use skein_runtime::{NodeHandle, Targets};
use skein_view::{EventKind, EventRecord, VehicleSnapshot};
use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::broadcast::error::RecvError;
use tokio::time::{Instant, MissedTickBehavior};

/// How often it is looked whether something is to be asked, and a stick said: several times while one is good.
const LOOK_EVERY: Duration = Duration::from_millis(50);
/// So many of its own commands it knows again.
const KNOWN_COMMANDS: usize = 16;

struct Driver {
    node: NodeHandle,
    vehicle: VehicleId,
    steering: Steering,
    began: Instant,
    own: VecDeque<CommandId>,
    /// The command by which it is steered.
    steered_by: Option<CommandId>,
    report: Arc<Mutex<Report>>,
}

impl Drop for Driver {
    /// Whoever drives no more leaves the vehicle where it is.
    fn drop(&mut self) {
        if !self.steering.is_engaged() {
            return;
        }
        let (node, vehicle) = (self.node.clone(), self.vehicle);
        if let Ok(runtime) = tokio::runtime::Handle::try_current() {
            runtime.spawn(async move {
                node.command(&Targets::Vehicles(vec![vehicle]), VehicleCommand::Hold)
                    .await;
            });
        }
    }
}

/// Flies a vehicle by what comes in, as long as it is polled; how it stands is always in `report`.
pub async fn drive(node: NodeHandle, vehicle: VehicleId, velocities: Subscription<Twist>, report: Arc<Mutex<Report>>) {
    let (valid_s, fastest_m_s) = (node.config().ros2.cmd_vel_valid_s, node.config().safety.max_speed_m_s);
    let mut events = node.subscribe();
    let mut driver = Driver {
        node,
        vehicle,
        steering: Steering::new(valid_s, fastest_m_s),
        began: Instant::now(),
        own: VecDeque::new(),
        steered_by: None,
        report,
    };
    let mut incoming = Box::pin(velocities.async_stream());
    let mut look = tokio::time::interval(LOOK_EVERY);
    look.set_missed_tick_behavior(MissedTickBehavior::Delay);
    loop {
        tokio::select! {
            // Ticks first: a flood of velocities does not keep one from expiring.
            biased;
            _ = look.tick() => driver.look().await,
            event = events.recv() => match event {
                Ok(event) => driver.hear(&event),
                Err(RecvError::Lagged(_)) => driver.lose("too much happened to know who commands it"),
                Err(RecvError::Closed) => return,
            },
            Some(velocity) = incoming.next() => {
                if let Ok((twist, _)) = velocity {
                    let now_s = driver.now_s();
                    driver.steering.take(&twist, now_s);
                }
            }
        }
    }
}

impl Driver {
    fn now_s(&self) -> f64 {
        self.began.elapsed().as_secs_f64()
    }

    /// Somebody else's command to this vehicle takes it over, and so does a task of the coordinator.
    fn hear(&mut self, event: &EventRecord) {
        if event.vehicle != Some(self.vehicle) {
            return;
        }
        let EventKind::Command { id, command, progress } = &event.kind else {
            return;
        };
        let replaced = matches!(
            progress,
            CommandProgress::Refused {
                refusal: Refusal::Superseded
            }
        );
        if replaced && self.steered_by == Some(*id) {
            self.lose("something else");
        } else if *progress == CommandProgress::Executing && !self.own.contains(id) {
            self.lose(command);
        }
    }

    fn lose(&mut self, to: &str) {
        let now_s = self.now_s();
        self.steering.taken_over(to, now_s);
    }

    async fn look(&mut self) {
        let picture = self.node.snapshot();
        let vehicle = picture.vehicles.iter().find(|v| v.id == self.vehicle);
        if let Some(vehicle) = vehicle.filter(|v| is_lost(v)) {
            self.lose(&vehicle.flight_state.to_string());
        }
        // A hold would take a leader out of its formation: it stands, and leads on.
        let leads = vehicle.is_some_and(|v| v.flight_state == FlightState::Leading);
        let now_s = self.now_s();
        if vehicle.is_some_and(|v| v.flight_state == FlightState::PilotControl) {
            self.steering.leave_to_pilot(now_s);
        }
        match self.steering.decide(now_s) {
            Order::Nothing => {}
            Order::Begin => self.steered_by = self.command(VehicleCommand::Steer).await,
            Order::Move(stick) => self.tell(stick),
            Order::Stop => {
                self.steered_by = None;
                if !leads {
                    self.command(VehicleCommand::Hold).await;
                }
            }
        }
        *self.report.lock() = self.steering.report();
    }

    /// Commands the vehicle; the command's number, if it was taken up.
    async fn command(&mut self, command: VehicleCommand) -> Option<CommandId> {
        let targets = Targets::Vehicles(vec![self.vehicle]);
        let receipt = self.node.command(&targets, command).await.into_iter().next()?;
        self.own.push_back(receipt.id);
        if self.own.len() > KNOWN_COMMANDS {
            self.own.pop_front();
        }
        let Some(refusal) = receipt.refusal else {
            return Some(receipt.id);
        };
        let now_s = self.now_s();
        self.steering.refused(&refusal, now_s);
        None
    }

    fn tell(&mut self, stick: Stick) {
        if let Err(refusal) = self.node.stick(None, self.vehicle, stick) {
            let now_s = self.now_s();
            self.steering.stick_refused(&refusal, now_s);
        }
    }
}

/// Whether a vehicle does what no velocity has it do.
fn is_lost(vehicle: &VehicleSnapshot) -> bool {
    let under_orders = vehicle
        .failsafe
        .as_ref()
        .is_some_and(|failsafe| failsafe.order.is_some());
    let flies_otherwise = matches!(
        vehicle.flight_state,
        FlightState::Returning | FlightState::Landing | FlightState::PilotControl | FlightState::Faulted
    );
    under_orders || flies_otherwise
}
