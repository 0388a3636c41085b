//! A camera in the network, asked over RTSP: its H.264 as it comes, put together from RTP.
//!
//! Must never do: wait for a camera without an end, or show a password.

use super::{Coded, Outlet, RtspCamera, StreamFault};
use crate::feed::Ended;
use futures_util::StreamExt;
use retina::client::{Credentials, Demuxed, PlayOptions, Session, SessionOptions, SetupOptions};
use retina::codec::{CodecItem, FrameFormat};
use std::time::Duration;
use tokio::time::{sleep, timeout};
use url::Url;

/// The handshake may take so long.
const HANDSHAKE_WITHIN: Duration = Duration::from_secs(10);
/// A camera of which nothing comes for so long is asked anew.
const SILENT_AFTER: Duration = Duration::from_secs(5);
/// How often it is looked whether anybody still wants the stream.
const LOOK_EVERY: Duration = Duration::from_millis(100);

/// Reads until nobody wants it any more.
pub(super) fn read(camera: &RtspCamera, outlet: &Outlet) -> Result<(), StreamFault> {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
    let runtime = runtime.map_err(|error| failed(camera, &error))?;
    runtime.block_on(async {
        tokio::select! {
            outcome = receive(camera, outlet) => outcome,
            () = unwanted(outlet) => Ok(()),
        }
    })
}

async fn unwanted(outlet: &Outlet) {
    while outlet.is_wanted() {
        sleep(LOOK_EVERY).await;
    }
}

fn failed(camera: &RtspCamera, error: &dyn std::fmt::Display) -> StreamFault {
    // What comes behind the first line is for those who look for faults in the library.
    let reason = error.to_string();
    StreamFault::Rtsp {
        url: camera.url.clone(),
        reason: reason.lines().next().unwrap_or_default().to_owned(),
    }
}

fn silent(camera: &RtspCamera, what: &'static str, within: Duration) -> StreamFault {
    StreamFault::Silent {
        url: camera.url.clone(),
        what,
        within_s: within.as_secs(),
    }
}

async fn receive(camera: &RtspCamera, outlet: &Outlet) -> Result<(), StreamFault> {
    let opened = timeout(HANDSHAKE_WITHIN, open(camera)).await;
    let mut session = opened.map_err(|_| silent(camera, "answer", HANDSHAKE_WITHIN))??;
    loop {
        let next = timeout(SILENT_AFTER, session.next()).await;
        let item = next.map_err(|_| silent(camera, "send a picture", SILENT_AFTER))?;
        match item {
            Some(Ok(CodecItem::VideoFrame(frame))) => {
                if !outlet.give(Ok(Coded::at_once(frame.into_data()))) {
                    return Ok(());
                }
            }
            Some(Ok(_)) => {}
            Some(Err(error)) => return Err(failed(camera, &error)),
            None => return Err(Ended.into()),
        }
    }
}

async fn open(camera: &RtspCamera) -> Result<Demuxed, StreamFault> {
    let address = Url::parse(&camera.url).map_err(|error| StreamFault::Address {
        url: camera.url.clone(),
        reason: error.to_string(),
    })?;
    let credentials = (!camera.user.is_empty()).then(|| Credentials {
        username: camera.user.clone(),
        password: camera.password.clone(),
    });
    let options = SessionOptions::default()
        .creds(credentials)
        .user_agent("skein".to_owned());
    let described = Session::describe(address, options).await;
    let mut session = described.map_err(|error| failed(camera, &error))?;
    let streams = session.streams();
    let video = streams
        .iter()
        .position(|stream| stream.media() == "video" && stream.encoding_name() == "h264");
    let Some(video) = video else {
        let names = streams
            .iter()
            .map(|stream| format!("{} {}", stream.media(), stream.encoding_name()));
        let has: Vec<String> = names.collect();
        return Err(StreamFault::NoH264 {
            url: camera.url.clone(),
            has: if has.is_empty() {
                "nothing".to_owned()
            } else {
                has.join(", ")
            },
        });
    };
    // As the node takes it: Annex B, parameter sets before each key picture.
    let setup = SetupOptions::default().frame_format(FrameFormat::SIMPLE);
    session
        .setup(video, setup)
        .await
        .map_err(|error| failed(camera, &error))?;
    let playing = session.play(PlayOptions::default()).await;
    let playing = playing.map_err(|error| failed(camera, &error))?;
    playing.demuxed().map_err(|error| failed(camera, &error))
}
