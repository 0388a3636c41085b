//! What sensors saw, told to the node that coordinates, and the tracks that it makes, told to all: as both go over the bus.
//!
//! Must never do: judge what is told; believe a moment of another node's clock as it stands.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use skein_coordination::TrackObservation;
use skein_domain::payload::{TrackEstimate, symmetric, upper_triangle};
use skein_domain::{NodeTime, PositionNed, SwarmFrame};
use skein_vision::{ClassScores, Observation, RangeGuess, Sensor, Sighting};

/// What the sensors of a node saw since it was told last.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SightingsTold {
    /// The teller's clock.
    pub told: NodeTime,
    sensors: Vec<String>,
    sightings: Vec<SightingTold>,
}

/// One of them; short, since there may be many.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct SightingTold {
    /// Which of the sensors.
    #[serde(rename = "s")]
    sensor: u16,
    #[serde(rename = "n")]
    name: Option<u64>,
    #[serde(rename = "a")]
    age_us: u32,
    #[serde(rename = "o")]
    seen: Seen,
    #[serde(rename = "c")]
    scores: Vec<(String, f32)>,
    /// Range and factor.
    #[serde(rename = "g")]
    guess: Option<(f32, f32)>,
    /// How large it looks, in radians.
    #[serde(rename = "w", default)]
    size_rad: Option<f32>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
enum Seen {
    /// Origin in millimetres and its error, direction and its error.
    #[serde(rename = "b")]
    Bearing([i32; 3], f32, [f32; 3], f32),
    /// Place in millimetres, and the upper triangle of its covariance.
    #[serde(rename = "p")]
    Position([i32; 3], [f32; 6]),
}

fn mm(place: &Vector3<f64>) -> [i32; 3] {
    [place.x, place.y, place.z].map(|m| (m * 1e3).round() as i32)
}

fn metres(mm: [i32; 3]) -> Vector3<f64> {
    Vector3::from(mm.map(|mm| f64::from(mm) * 1e-3))
}

impl SightingsTold {
    /// As they are told at this moment.
    #[must_use]
    pub fn of(sightings: &[Sighting], now: NodeTime) -> Self {
        let mut sensors: Vec<String> = Vec::new();
        let mut index = |sensor: &Sensor| {
            let known = sensors.iter().position(|known| *known == sensor.0);
            known.unwrap_or_else(|| {
                sensors.push(sensor.0.clone());
                sensors.len() - 1
            }) as u16
        };
        let sightings = sightings.iter().map(|sighting| SightingTold {
            sensor: index(&sighting.sensor),
            name: sighting.name,
            age_us: u32::try_from(now.0.saturating_sub(sighting.time.0)).unwrap_or(u32::MAX),
            seen: match &sighting.observation {
                Observation::Bearing {
                    origin,
                    origin_error_m,
                    direction,
                    error_rad,
                } => Seen::Bearing(
                    mm(origin),
                    *origin_error_m as f32,
                    [direction.x as f32, direction.y as f32, direction.z as f32],
                    *error_rad as f32,
                ),
                Observation::Position { position, covariance } => {
                    Seen::Position(mm(position), upper_triangle(covariance).map(|part| part as f32))
                }
            },
            scores: sighting
                .scores
                .iter()
                .map(|(class, score)| (class.to_owned(), score as f32))
                .collect(),
            guess: sighting
                .guess
                .map(|guess| (guess.range_m as f32, guess.range_factor as f32)),
            size_rad: sighting.size_rad.map(|size_rad| size_rad as f32),
        });
        Self {
            told: now,
            sightings: sightings.collect(),
            sensors,
        }
    }

    /// By the receiver's clock, on which they were told at `told`, and in its frame.
    pub fn sightings(self, told: NodeTime, frames: Option<(SwarmFrame, SwarmFrame)>) -> Vec<Sighting> {
        let Self { sensors, sightings, .. } = self;
        let here = |place: [i32; 3]| moved(metres(place).into(), frames).vector();
        let one = |sighting: SightingTold| {
            Some(Sighting {
                sensor: Sensor(sensors.get(usize::from(sighting.sensor))?.clone()),
                name: sighting.name,
                time: NodeTime(told.0.saturating_sub(u64::from(sighting.age_us))),
                observation: match sighting.seen {
                    Seen::Bearing(origin, origin_error_m, direction, error_rad) => Observation::Bearing {
                        origin: here(origin),
                        origin_error_m: f64::from(origin_error_m),
                        direction: Vector3::from(direction.map(f64::from)).normalize(),
                        error_rad: f64::from(error_rad),
                    },
                    Seen::Position(position, covariance) => Observation::Position {
                        position: here(position),
                        covariance: symmetric(covariance.map(f64::from)),
                    },
                },
                scores: ClassScores::all(
                    sighting
                        .scores
                        .into_iter()
                        .map(|(class, score)| (class, f64::from(score))),
                ),
                guess: sighting.guess.map(|(range_m, range_factor)| RangeGuess {
                    range_m: f64::from(range_m),
                    range_factor: f64::from(range_factor),
                }),
                size_rad: sighting.size_rad.map(f64::from),
            })
        };
        sightings.into_iter().filter_map(one).collect()
    }
}

/// A place of a node whose frame may be another one.
fn moved(place: PositionNed, frames: Option<(SwarmFrame, SwarmFrame)>) -> PositionNed {
    match frames {
        Some((theirs, ours)) => ours.position(&theirs.geodetic(&place)),
        None => place,
    }
}

/// What the node that coordinates makes of all that is seen, and who keeps what in view: what its successor goes on with.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct TracksTold {
    /// The tracks.
    pub tracks: Vec<TrackEstimate>,
    /// Who keeps which in view.
    pub observations: Vec<TrackObservation>,
}

impl TracksTold {
    /// The same by a clock that is ahead by so many microseconds, on which it is `now`, and in another frame.
    #[must_use]
    pub fn heard(mut self, ahead_us: i64, now: NodeTime, frames: Option<(SwarmFrame, SwarmFrame)>) -> Self {
        let here = |at: NodeTime| at.on_clock_ahead_by(ahead_us).min(now);
        for track in &mut self.tracks {
            track.track.time = here(track.track.time);
            track.seen = here(track.seen);
            track.track.position = moved(track.track.position, frames);
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parts::{pack, unpack};
    use nalgebra::Matrix3;

    fn bearing(name: u64, time_s: f64) -> Sighting {
        Sighting {
            sensor: Sensor("3/camera".to_owned()),
            name: Some(name),
            time: NodeTime::from_seconds(time_s),
            observation: Observation::Bearing {
                origin: Vector3::new(120.5, -30.25, -40.0),
                origin_error_m: 0.5,
                direction: Vector3::new(0.3, 0.8, -0.1).normalize(),
                error_rad: 0.011,
            },
            scores: ClassScores::one("drone", 0.75),
            guess: Some(RangeGuess {
                range_m: 80.0,
                range_factor: 2.0,
            }),
            size_rad: Some(0.02),
        }
    }

    #[test]
    fn sightings_arrive_as_they_were_by_the_receivers_clock() {
        let radar = Sighting {
            sensor: Sensor("radar".to_owned()),
            observation: Observation::Position {
                position: Vector3::new(1.0, 2.0, -3.0),
                covariance: Matrix3::new(4.0, 1.0, 0.0, 1.0, 5.0, 0.5, 0.0, 0.5, 6.0),
            },
            ..bearing(8, 9.5)
        };
        let told = SightingsTold::of(&[bearing(7, 9.75), radar.clone()], NodeTime::from_seconds(10.0));
        let packed = pack(&told).expect("can be written");
        let back: SightingsTold = unpack(&packed).expect("can be read");
        // The receiver's clock is 90 s ahead.
        let heard = back.sightings(NodeTime::from_seconds(100.0), None);
        assert_eq!(heard[0].time, NodeTime::from_seconds(99.75));
        assert_eq!((heard[0].sensor.0.as_str(), heard[0].name), ("3/camera", Some(7)));
        assert!(heard.iter().all(|sighting| sighting.check().is_ok()), "{heard:?}");
        let Observation::Bearing { direction, origin, .. } = &heard[0].observation else {
            panic!("no bearing")
        };
        assert!((direction - Vector3::new(0.3, 0.8, -0.1).normalize()).norm() < 1e-6);
        assert!((origin - Vector3::new(120.5, -30.25, -40.0)).norm() < 1e-3);
        assert_eq!(heard[1].observation, radar.observation);
    }

    #[test]
    fn as_many_as_are_told_at_once_are_few_datagrams() {
        let many: Vec<Sighting> = (0..128).map(|name| bearing(name, 9.0 + 0.007 * name as f64)).collect();
        let packed = pack(&SightingsTold::of(&many, NodeTime::from_seconds(10.0))).expect("can be written");
        assert!(packed.len() < 12_000, "{}", packed.len());
    }
}
