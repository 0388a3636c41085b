//! What other sensors than cameras see, as somebody tells it over the API: what it may say, and what becomes of it.
//!
//! Must never do: take half of what cannot be true.

use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use skein_domain::payload::symmetric;
use skein_domain::{NodeTime, PositionNed};
use skein_vision::{ClassScores, Observation, Sensor, Sighting};

/// How well a sensor knows its own place if it does not say, along each axis in metres.
const ORIGIN_ERROR_M: f64 = 0.5;
/// How well a place is known if the sensor does not say, along each axis in square metres: five metres.
const COVARIANCE_M2: [f64; 6] = [25.0, 0.0, 0.0, 25.0, 0.0, 25.0];

/// Something that a radar, a radio direction finder or another sensor has seen once. It says a position or a bearing, and not both.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ts_rs::TS, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Detection {
    /// What the sensor calls the thing, if it follows it; what it names once it must not use for another thing soon.
    #[serde(default)]
    #[ts(type = "number | null")]
    #[schemars(range(max = 9_007_199_254_740_991_u64))]
    pub id: Option<u64>,
    /// How long ago that was, in seconds.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 2.0))]
    pub age_s: f64,
    /// What it is taken for, for example `drone`.
    #[serde(default)]
    #[schemars(length(min = 1, max = 64))]
    pub class: Option<String>,
    /// How sure that is, 0..=1; 1 if left out.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub score: Option<f64>,
    /// Where it is, in the swarm frame.
    #[serde(default)]
    pub position: Option<PositionNed>,
    /// Covariance of the position along north, east and down, in square metres: north-north, north-east, north-down, east-east, east-down, down-down. Five
    /// metres along each axis if left out.
    #[serde(default)]
    pub covariance_m2: Option<[f64; 6]>,
    /// In which direction it is.
    #[serde(default)]
    pub bearing: Option<DetectedBearing>,
}

/// A direction from a place.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ts_rs::TS, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DetectedBearing {
    /// Where the sensor is, in the swarm frame.
    pub origin: PositionNed,
    /// How well that is known: one standard deviation along each axis, in metres; half a metre if left out.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 1_000.0))]
    pub origin_error_m: Option<f64>,
    /// Clockwise from north, in radians.
    #[schemars(range(min = -1000.0, max = 1000.0))]
    pub azimuth_rad: f64,
    /// Above the horizon, in radians.
    #[schemars(range(min = -1.6, max = 1.6))]
    pub elevation_rad: f64,
    /// One standard deviation of the direction, in radians.
    #[schemars(range(min = 1e-6, max = 1.5))]
    pub error_rad: f64,
}

/// What became of detections that were told.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ts_rs::TS, JsonSchema)]
pub struct Detected {
    /// So many were taken.
    pub taken: usize,
    /// So many were not, because too much waits already.
    pub refused: usize,
}

/// All of them as sightings.
///
/// # Errors
/// The place in the list of the first that cannot be true, and why.
pub fn sightings(source: &str, detections: Vec<Detection>, now: NodeTime) -> Result<Vec<Sighting>, (usize, String)> {
    let one = |(index, detection): (usize, Detection)| sighting(source, detection, now).map_err(|why| (index, why));
    detections.into_iter().enumerate().map(one).collect()
}

fn sighting(source: &str, detection: Detection, now: NodeTime) -> Result<Sighting, String> {
    if !(0.0..=2.0).contains(&detection.age_s) {
        return Err("`age_s` is not between 0 and 2".to_owned());
    }
    let score = detection.score.unwrap_or(1.0);
    if !(0.0..=1.0).contains(&score) {
        return Err("`score` is not between 0 and 1".to_owned());
    }
    let sighting = Sighting {
        sensor: Sensor(source.to_owned()),
        name: detection.id,
        time: now.plus_seconds(-detection.age_s),
        observation: observation(&detection)?,
        scores: detection
            .class
            .map(|class| ClassScores::one(&class, score))
            .unwrap_or_default(),
        guess: None,
        size_rad: None,
    };
    sighting.check().map_err(|unsound| unsound.to_string())?;
    Ok(sighting)
}

fn observation(detection: &Detection) -> Result<Observation, String> {
    match (&detection.position, &detection.bearing) {
        (Some(position), None) => Ok(Observation::Position {
            position: position.vector(),
            covariance: symmetric(detection.covariance_m2.unwrap_or(COVARIANCE_M2)),
        }),
        (None, Some(_)) if detection.covariance_m2.is_some() => {
            Err("`covariance_m2` belongs to a position, and it has a bearing".to_owned())
        }
        (None, Some(bearing)) => {
            let (sin_azimuth, cos_azimuth) = bearing.azimuth_rad.sin_cos();
            let (sin_elevation, cos_elevation) = bearing.elevation_rad.sin_cos();
            let direction = Vector3::new(cos_elevation * cos_azimuth, cos_elevation * sin_azimuth, -sin_elevation);
            Ok(Observation::Bearing {
                origin: bearing.origin.vector(),
                origin_error_m: bearing.origin_error_m.unwrap_or(ORIGIN_ERROR_M),
                direction,
                error_rad: bearing.error_rad,
            })
        }
        (Some(_), Some(_)) => Err("it has a position and a bearing; say one of them".to_owned()),
        (None, None) => Err("it has neither a position nor a bearing".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    const NOW: NodeTime = NodeTime(10_000_000);

    fn told(detections: serde_json::Value) -> Result<Vec<Sighting>, (usize, String)> {
        sightings("radar", serde_json::from_value(detections).expect("has the shape"), NOW)
    }

    fn place() -> serde_json::Value {
        json!({ "north_m": 10.0, "east_m": 20.0, "down_m": -30.0 })
    }

    #[test]
    fn positions_and_bearings_become_sightings() {
        let told = told(json!([
            { "id": 7, "age_s": 0.5, "class": "drone", "score": 0.6, "position": place(), "covariance_m2": [4, 1, 0, 4, 0, 9] },
            { "bearing": { "origin": place(), "azimuth_rad": std::f64::consts::FRAC_PI_2, "elevation_rad": 0.5, "error_rad": 0.02 } },
        ]));
        let [radar, finder] = told.expect("are sound").try_into().expect("two");
        assert_eq!((radar.name, radar.time), (Some(7), NodeTime(9_500_000)));
        assert_eq!(radar.scores.best(), Some(("drone", 0.6)));
        let Observation::Position { covariance, .. } = radar.observation else {
            panic!("no position")
        };
        assert_eq!((covariance[(1, 0)], covariance[(2, 2)]), (1.0, 9.0));
        let Observation::Bearing { direction, .. } = finder.observation else {
            panic!("no bearing")
        };
        // East, and upwards is against down.
        assert!((direction - Vector3::new(0.0, 0.5_f64.cos(), -0.5_f64.sin())).norm() < 1e-12);
    }

    #[test]
    fn the_first_that_cannot_be_true_is_named_with_its_reason() {
        let sound = json!({ "position": place() });
        let bearing = json!({ "origin": place(), "azimuth_rad": 0.0, "elevation_rad": 0.0, "error_rad": 0.02 });
        for (wrong, why) in [
            (json!({}), "neither"),
            (json!({ "position": place(), "bearing": bearing }), "say one of them"),
            (
                json!({ "bearing": bearing, "covariance_m2": [1, 0, 0, 1, 0, 1] }),
                "belongs to a position",
            ),
            (
                json!({ "position": place(), "covariance_m2": [1, 0, 0, 1, 0, 0] }),
                "positive definite",
            ),
            (
                json!({ "position": place(), "covariance_m2": [-1, 0, 0, 1, 0, 1] }),
                "positive definite",
            ),
            (json!({ "position": place(), "score": 1.5 }), "score"),
            (json!({ "position": place(), "age_s": 3.0 }), "age_s"),
            (
                json!({ "position": { "north_m": 1e9, "east_m": 0, "down_m": 0 } }),
                "too large",
            ),
        ] {
            let (index, said) = told(json!([sound, wrong])).expect_err("cannot be");
            assert_eq!(index, 1);
            assert!(said.contains(why), "{said}");
        }
    }
}
