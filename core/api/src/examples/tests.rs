//! Whether each example is what it is an example of. That a node does what they say is tested with one that flies.

use super::*;
use crate::body::understand;
use schemars::JsonSchema;
use serde::de::DeserializeOwned;

fn is_taken<T: Example + DeserializeOwned + JsonSchema + 'static>() {
    let example = T::example();
    let text = serde_json::to_vec(&example).unwrap();
    let understood = understand::<T>(&text);
    assert!(understood.is_ok(), "{example}: {:?}", understood.err());
}

#[test]
fn each_example_is_what_it_is_an_example_of() {
    is_taken::<CommandBody>();
    is_taken::<ControlBody>();
    is_taken::<ParameterBody>();
    is_taken::<ReadingBody>();
    is_taken::<FormationRequest>();
    is_taken::<RouteBody>();
    is_taken::<ReferenceReport>();
    is_taken::<TrajectoryRequest>();
    is_taken::<EmergencyStopBody>();
    is_taken::<OverrideBody>();
    is_taken::<FencePlanBody>();
    is_taken::<FenceFileBody>();
    is_taken::<AcknowledgeBody>();
    is_taken::<ResumeBody>();
    is_taken::<CoordinatorBody>();
    is_taken::<RolloutBody>();
    is_taken::<PayloadRule>();
    is_taken::<PayloadCommandBody>();
    is_taken::<TracksBody>();
    is_taken::<TrackChangeBody>();
    is_taken::<ObserveRequest>();
    is_taken::<DetectionsBody>();
    is_taken::<Fault>();
}
