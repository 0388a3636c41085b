//! A body of each kind that would be taken: for the document, and for whoever sent one that is not. A test sends each of them to a
//! node that flies.
//!
//! Must never do: stand for a value that was left out.

use crate::body::{DetectionsBody, PayloadCommandBody, TrackChangeBody, TracksBody};
use crate::example::Example;
use crate::protocol::{
    AcknowledgeBody, CommandBody, ControlBody, CoordinatorBody, EmergencyStopBody, FenceFileBody, FencePlanBody,
    OverrideBody, ParameterBody, ReadingBody, ResumeBody, RouteBody,
};
use crate::upgrades::RolloutBody;
use serde_json::{Value, json};
use skein_config::PayloadRule;
use skein_coordination::ReferenceReport;
use skein_domain::{FormationRequest, TrajectoryRequest};
use skein_replay::ReplayChange;
use skein_runtime::{Fault, ObserveRequest};

macro_rules! examples {
    ($($body:ty => $example:tt,)*) => {
        $(impl Example for $body {
            fn example() -> Value {
                json!($example)
            }
        })*
    };
}

examples! {
    CommandBody => { "targets": { "vehicles": [1, 2] }, "command": { "command": "take_off", "height_m": 10.0 } },
    ControlBody => {
        "targets": "all",
        "console": { "id": "9f2c1b7e", "name": "Ground station" },
        "action": { "action": "take" },
    },
    ParameterBody => { "value": 12.5 },
    ReadingBody => { "action": "begin" },
    ReplayChange => { "position_s": 42.0, "rate": 4.0, "playing": true },
    FormationRequest => {
        "shape": "wedge", "spacing_m": 6.0, "leader": 1, "anchor": { "kind": "leader" },
        "heading": { "kind": "course" },
    },
    RouteBody => {
        "route": {
            "waypoints": [
                { "north_m": 40.0, "east_m": 0.0, "down_m": -10.0 },
                { "north_m": 40.0, "east_m": 40.0, "down_m": -10.0 },
            ],
            "speed_m_s": 4.0,
            "corner_radius_m": 5.0,
        },
    },
    ReferenceReport => {
        "position": { "north_m": 20.0, "east_m": 5.0, "down_m": 0.0 },
        "velocity": { "north_m_s": 1.0, "east_m_s": 0.0, "down_m_s": 0.0 },
    },
    TrajectoryRequest => {
        "vehicles": [{ "vehicle": 1, "waypoints": [{ "north_m": 40.0, "east_m": 0.0, "down_m": -10.0 }] }],
        "kind": "jerk",
        "start": { "when": "in", "in_s": 5.0 },
        "max_speed_m_s": 5.0,
    },
    EmergencyStopBody => { "key": "0123456789abcdef", "targets": { "vehicles": [1] } },
    OverrideBody => { "vehicle": 1, "items": ["battery"], "reason": "hover test on a half charge", "valid_s": 300.0 },
    FencePlanBody => {
        "plan": {
            "zones": [{
                "name": "field",
                "kind": "inclusion",
                "outline": { "shape": "local_circle", "centre_m": [0.0, 0.0], "radius_m": 300.0 },
                "ceiling_m": 80.0,
                "action": "hold",
            }],
        },
    },
    FenceFileBody => {
        "name": "field.plan",
        "text": "{\"fileType\":\"Plan\",\"geoFence\":{\"circles\":[{\"circle\":{\"center\":[47.397742,8.545594],\"radius\":300},\"inclusion\":true,\"version\":1}],\"polygons\":[],\"version\":2},\"version\":1}",
    },
    AcknowledgeBody => { "events": [17, 18] },
    ResumeBody => { "fly_on": true },
    CoordinatorBody => { "node": 1 },
    RolloutBody => { "nodes": [2, 3], "this_node": false },
    PayloadRule => { "name": "gimbal-2", "plugin": "gimbal" },
    PayloadCommandBody => { "command": "angles", "pitch_rad": (-0.8), "yaw_rad": 0.3 },
    TracksBody => {
        "tracks": [{
            "track": 4,
            "position": { "north_m": 120.0, "east_m": -30.0, "down_m": -25.0 },
            "velocity": { "north_m_s": 3.0, "east_m_s": 0.0, "down_m_s": 0.0 },
            "time": 0.0,
        }],
    },
    TrackChangeBody => { "name": "visitor", "pinned": true },
    ObserveRequest => { "count": 2, "stand_off_m": 30.0 },
    DetectionsBody => {
        "source": "radar-north",
        "detections": [
            {
                "id": 12,
                "age_s": 0.1,
                "class": "drone",
                "score": 0.7,
                "position": { "north_m": 120.0, "east_m": -30.0, "down_m": -25.0 },
                "covariance_m2": [9.0, 0.0, 0.0, 9.0, 0.0, 25.0],
            },
            {
                "bearing": {
                    "origin": { "north_m": 0.0, "east_m": 0.0, "down_m": -2.0 },
                    "azimuth_rad": 0.8,
                    "elevation_rad": 0.1,
                    "error_rad": 0.02,
                },
            },
        ],
    },
    Fault => { "fault": "coordinator" },
}

#[cfg(test)]
mod tests;
