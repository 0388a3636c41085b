//! How near vehicles of several simulations come to each other.
//!
//! Must never do: compare places of different moments. Each simulation has a thread and a clock of its own, and on a busy machine one may lag.

use skein_sim::{TruthFrame, VehicleTruth};
use std::collections::BTreeMap;
use std::fmt;
use std::time::Instant;

/// Two vehicles, and how near they came to each other.
#[derive(Debug, Clone)]
pub struct Nearest {
    /// Distance in metres.
    pub distance_m: f64,
    /// Both, as they were then.
    who: Option<Box<[VehicleTruth; 2]>>,
    /// When, in seconds since it was first looked.
    time_s: f64,
}

impl Default for Nearest {
    fn default() -> Self {
        Self {
            distance_m: f64::INFINITY,
            who: None,
            time_s: 0.0,
        }
    }
}

impl fmt::Display for Nearest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:.2} m after {:.1} s:", self.distance_m, self.time_s)?;
        for vehicle in self.who.iter().flat_map(|both| both.iter()) {
            let (at, speed) = (vehicle.position, vehicle.velocity);
            write!(
                f,
                " {} in {:?} at {:.2} {:.2} {:.2} m with {:.2} {:.2} {:.2} m/s;",
                vehicle.system_id,
                vehicle.mode,
                at.north_m,
                at.east_m,
                at.down_m,
                speed.north_m_s,
                speed.east_m_s,
                speed.down_m_s
            )?;
        }
        Ok(())
    }
}

/// What was last seen of a simulation.
struct Sight {
    frame: TruthFrame,
    /// What our clock showed when the simulation's showed zero, in seconds: as the frame that was told soonest has it.
    zero_s: f64,
}

/// Looks at the frames of several simulations.
pub struct Referee {
    began: Instant,
    latest: BTreeMap<u8, Sight>,
    nearest: Nearest,
}

impl Default for Referee {
    fn default() -> Self {
        Self {
            began: Instant::now(),
            latest: BTreeMap::new(),
            nearest: Nearest::default(),
        }
    }
}

impl Referee {
    /// The smallest distance so far between two vehicles of which one was off the ground.
    #[must_use]
    pub fn nearest(&self) -> &Nearest {
        &self.nearest
    }

    /// A frame of a node's simulation, just told.
    pub fn see(&mut self, node: u8, frame: &TruthFrame) {
        self.see_at(self.began.elapsed().as_secs_f64(), node, frame);
    }

    fn see_at(&mut self, heard_s: f64, node: u8, frame: &TruthFrame) {
        let zero_s = heard_s - frame.time_s;
        let before_s = self.latest.get(&node).map_or(f64::INFINITY, |sight| sight.zero_s);
        let sight = Sight {
            frame: frame.clone(),
            zero_s: zero_s.min(before_s),
        };
        let now_s = sight.zero_s + frame.time_s;
        self.latest.insert(node, sight);
        self.look(node, now_s);
    }

    /// Compares who was just seen with all others, each brought to this moment.
    fn look(&mut self, node: u8, now_s: f64) {
        for seen in &self.latest[&node].frame.vehicles {
            let others = self.latest.iter().filter(|(other, _)| **other != node);
            let others = others.flat_map(|(_, sight)| {
                let lag_s = now_s - (sight.zero_s + sight.frame.time_s);
                sight.frame.vehicles.iter().map(move |vehicle| (vehicle, lag_s))
            });
            for (other, lag_s) in others {
                let counts = seen.alive && other.alive && !(seen.touches_ground && other.touches_ground);
                let there = other.position.moved(other.velocity.vector() * lag_s);
                let distance_m = seen.position.distance_m(&there);
                if counts && distance_m < self.nearest.distance_m {
                    self.nearest = Nearest {
                        distance_m,
                        who: Some(Box::new([seen.clone(), other.clone()])),
                        time_s: now_s,
                    };
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Referee;
    use skein_domain::{PositionNed, VelocityNed};
    use skein_sim::{TruthFrame, VehicleTruth};

    fn frame(time_s: f64, north_m: f64, speed_m_s: f64) -> TruthFrame {
        let vehicle = VehicleTruth {
            alive: true,
            position: PositionNed::new(north_m, 0.0, -5.0),
            velocity: VelocityNed::new(speed_m_s, 0.0, 0.0),
            ..VehicleTruth::default()
        };
        TruthFrame {
            time_s,
            vehicles: vec![vehicle],
            ..TruthFrame::default()
        }
    }

    #[test]
    fn a_simulation_that_lags_is_compared_with_where_its_vehicle_is_by_then() {
        let mut referee = Referee::default();
        // Both fly at 10 m/s, five metres apart.
        referee.see_at(7.0, 1, &frame(0.0, 0.0, 10.0));
        referee.see_at(7.0, 2, &frame(2.0, 5.0, 10.0));
        referee.see_at(7.4, 1, &frame(0.4, 4.0, 10.0));
        let near_m = referee.nearest().distance_m;
        assert!((4.5..5.5).contains(&near_m), "{}", referee.nearest());
        // And who comes near is seen to.
        referee.see_at(7.4, 2, &frame(2.4, 5.0, 10.0));
        assert!(referee.nearest().distance_m < 1.5, "{}", referee.nearest());
    }
}
