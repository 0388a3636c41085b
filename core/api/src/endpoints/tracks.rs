//! The routes about what the swarm sees, for the table.

use super::Endpoint;
use crate::body::{DetectionsBody, TrackChangeBody, TracksBody};
use crate::protocol::{Accepted, AskedObserverList, CameraViewList, ObserverList, TrackList};
use crate::{observed, payloads};
use axum::http::StatusCode;
use skein_runtime::{Detected, ObserveRequest};

/// Tracks, what sensors tell, and who keeps what in view.
pub(super) fn tracks() -> Vec<Endpoint> {
    vec![
        Endpoint::get("/api/v1/tracks", "getTracks", observed::tracks)
            .about(
                "tracks",
                "What is tracked: what was told last, and what the swarm makes of what its cameras and other sensors see.",
            )
            .json::<TrackList>(StatusCode::OK, "The tracks."),
        Endpoint::put("/api/v1/tracks", "setTracks", payloads::tracks)
            .about(
                "tracks",
                "Replaces what was told as tracked, for vehicles that are to observe it. Numbers are below 1000001: from there up they are the swarm's own.",
            )
            .takes::<TracksBody>()
            .json::<Accepted>(StatusCode::ACCEPTED, "It is known from now on."),
        Endpoint::patch("/api/v1/tracks/{id}", "changeTrack", observed::change)
            .about("tracks", "Names a track that the swarm makes, or has it kept longer.")
            .with::<u64>("id")
            .takes::<TrackChangeBody>()
            .answer(StatusCode::NO_CONTENT, "It is so.", None)
            .fails(&[404]),
        Endpoint::delete("/api/v1/tracks/{id}", "dropTrack", observed::drop_track)
            .about(
                "tracks",
                "Ends a track that the swarm makes. What its sensors see under the present names begins no new one.",
            )
            .with::<u64>("id")
            .answer(StatusCode::NO_CONTENT, "It has ended.", None)
            .fails(&[400, 404, 409]),
        Endpoint::get("/api/v1/tracks/{id}/observers", "getObservers", observed::observers)
            .about("tracks", "Which vehicles could keep a track in view, the best placed first.")
            .with::<u64>("id")
            .json::<ObserverList>(StatusCode::OK, "The vehicles.")
            .fails(&[400, 404]),
        Endpoint::post("/api/v1/tracks/{id}/observe", "observeTrack", observed::observe)
            .about(
                "tracks",
                "Has vehicles keep a track in view from several sides. Where one of them must return soon or is lost, the next best is asked.",
            )
            .with::<u64>("id")
            .takes::<ObserveRequest>()
            .json::<AskedObserverList>(StatusCode::OK, "Who was asked, and what each answered; some or all may be refusals.")
            .fails(&[404]),
        Endpoint::post("/api/v1/detections", "tellDetections", observed::detections)
            .about(
                "tracks",
                "Tells what a radar, a radio direction finder or another sensor has seen: positions or bearings in the swarm frame. Of a body with one that \
                 cannot be true nothing is taken.",
            )
            .takes::<DetectionsBody>()
            .json::<Detected>(StatusCode::ACCEPTED, "They are taken.")
            .fails(&[429]),
        Endpoint::get("/api/v1/cameras/views", "getCameraViews", observed::views)
            .about(
                "tracks",
                "Where the cameras of all vehicles are and look, as far as that is known: from their last frames, or from the gimbals.",
            )
            .json::<CameraViewList>(StatusCode::OK, "The views."),
    ]
}
