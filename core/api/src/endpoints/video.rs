//! The routes about live video, for the table.

use super::{Endpoint, VIDEO, schema_of};
use crate::protocol::{VideoMessage, VideoRecordingAnswer, VideoRecordingList, VideoStreamList};
use crate::video::{self, QualityQuery, SocketQuery};
use axum::http::StatusCode;
use skein_domain::VehicleId;

/// What can be looked at.
pub(super) fn videos() -> Vec<Endpoint> {
    vec![
        Endpoint::get("/api/v1/video", "getVideo", video::list)
            .about(VIDEO, "The cameras of this node's vehicles, and how their video is.")
            .json::<VideoStreamList>(StatusCode::OK, "The streams."),
        Endpoint::get("/api/v1/vehicles/{id}/payloads/{payload}/video", "openVideo", video::open)
            .about(
                VIDEO,
                "A WebSocket with live video: binary messages with a header of 32 bytes and one picture, as the page on video in the documentation \
                 has it; as text the messages of the schema. A viewer may send the messages of the schema VideoRequest.",
            )
            .websocket()
            .with::<VehicleId>("id")
            .with::<String>("payload")
            .asks::<SocketQuery>()
            .json::<VideoMessage>(StatusCode::SWITCHING_PROTOCOLS, "The video is open. The schema is that of its text messages.")
            .fails(&[400, 404, 409, 426, 503]),
        Endpoint::get("/api/v1/vehicles/{id}/payloads/{payload}/video/mjpeg", "getVideoAsJpeg", video::multipart)
            .about(VIDEO, "Live video as JPEG files in one answer that does not end, for players and pages without scripts.")
            .with::<VehicleId>("id")
            .with::<String>("payload")
            .asks::<QualityQuery>()
            .answer(
                StatusCode::OK,
                "The pictures, until the connection is closed.",
                Some(("multipart/x-mixed-replace", schema_of::<String>)),
            )
            .fails(&[400, 404, 409, 503]),
        Endpoint::post("/api/v1/vehicles/{id}/payloads/{payload}/video/whep", "openVideoOverWebrtc", video::answer)
            .about(
                VIDEO,
                "Live video over WebRTC, as WHEP has it: the body is an SDP offer that receives video, with all its candidates; `location` names the \
                 session.",
            )
            .with::<VehicleId>("id")
            .with::<String>("payload")
            .asks::<QualityQuery>()
            .takes_sdp()
            .answer(
                StatusCode::CREATED,
                "The SDP answer.",
                Some(("application/sdp", schema_of::<String>)),
            )
            .fails(&[400, 404, 409, 415, 422, 503]),
        Endpoint::delete("/api/v1/video/sessions/{session}", "endVideoOverWebrtc", video::end)
            .about(VIDEO, "Ends a session of WebRTC.")
            .with::<String>("session")
            .answer(StatusCode::NO_CONTENT, "It has ended.", None)
            .fails(&[400, 404]),
    ]
}

/// What is recorded.
pub(super) fn recordings() -> Vec<Endpoint> {
    const RECORDING: &str = "/api/v1/vehicles/{id}/payloads/{payload}/video/recording";
    vec![
        Endpoint::post(RECORDING, "startRecording", video::start)
            .about(VIDEO, "Records a camera on this node, as its pictures are encoded, until that is ended.")
            .with::<VehicleId>("id")
            .with::<String>("payload")
            .json::<VideoRecordingAnswer>(StatusCode::CREATED, "It is being recorded.")
            .fails(&[400, 403, 404, 409]),
        Endpoint::delete(RECORDING, "stopRecording", video::stop)
            .about(VIDEO, "Ends a recording.")
            .with::<VehicleId>("id")
            .with::<String>("payload")
            .json::<VideoRecordingAnswer>(StatusCode::OK, "It has ended.")
            .fails(&[400, 403]),
        Endpoint::get("/api/v1/video/recordings", "getRecordings", video::recordings)
            .about(VIDEO, "What is and was recorded on this node, the newest first. At most 500 are named.")
            .json::<VideoRecordingList>(StatusCode::OK, "The recordings."),
        Endpoint::get("/api/v1/video/recordings/{file}", "getRecording", video::file)
            .about(
                VIDEO,
                "A recording as an MP4 file; with `.jsonl` in place of `.mp4` where the vehicle was and how its payloads stood, a line for each tenth \
                 of a second.",
            )
            .with::<String>("file")
            .answer(StatusCode::OK, "The file.", Some(("video/mp4", schema_of::<String>)))
            .fails(&[400, 404]),
    ]
}
