//! A ground station behind the autopilot finds the video by MAVLink alone: it hears the camera's heartbeat, asks, and listens at the port it is told.

use super::encoded::{SIZE_PX, write_video};
use super::rtp::{Receiver, to};
use super::*;
use mavlink::dialects::common::{
    COMMAND_LONG_DATA, HEARTBEAT_DATA, MavAutopilot, MavCmd, MavMessage, MavModeFlag, MavResult, MavState, MavType,
    VIDEO_STREAM_INFORMATION_DATA, VideoStreamStatusFlags, VideoStreamType,
};
use mavlink::{MAVLinkV2MessageRaw, MavHeader, MavlinkVersion, Message as _};
use skein_config::RtpQuality;
use skein_link_mavlink::{EndpointCounters, frame::each_in_datagram};
use std::sync::Arc;
use tokio::net::UdpSocket;
use tokio::task::JoinHandle;

const VEHICLE: u8 = 1;
/// The camera on the vehicle that speaks for itself.
const OTHER_CAMERA: u8 = 105;

/// An autopilot that passes messages on between its links, as PX4 does. It says no more than that it is there, and so does a camera on it.
struct Autopilot {
    socket: Arc<UdpSocket>,
    heart: JoinHandle<()>,
}

fn frame(component_id: u8, system_id: u8, message: &MavMessage) -> Vec<u8> {
    let header = MavHeader {
        system_id: system_id.into(),
        component_id,
        sequence: 0,
    };
    let mut raw = MAVLinkV2MessageRaw::new();
    raw.serialize_message(header, message);
    raw.raw_bytes().to_vec()
}

fn heartbeat(mavtype: MavType, autopilot: MavAutopilot) -> MavMessage {
    MavMessage::HEARTBEAT(HEARTBEAT_DATA {
        custom_mode: 0,
        mavtype,
        autopilot,
        base_mode: MavModeFlag::empty(),
        system_status: MavState::MAV_STATE_STANDBY,
        mavlink_version: 3,
    })
}

impl Autopilot {
    async fn at(node: SocketAddr) -> Self {
        let socket = Arc::new(UdpSocket::bind("127.0.0.1:0").await.unwrap());
        socket.connect(node).await.unwrap();
        let speaking = socket.clone();
        let own = heartbeat(MavType::MAV_TYPE_QUADROTOR, MavAutopilot::MAV_AUTOPILOT_PX4);
        let camera = heartbeat(MavType::MAV_TYPE_CAMERA, MavAutopilot::MAV_AUTOPILOT_INVALID);
        let heart = tokio::spawn(async move {
            loop {
                for (component, message) in [(1, &own), (OTHER_CAMERA, &camera)] {
                    speaking.send(&frame(component, VEHICLE, message)).await.unwrap();
                }
                tokio::time::sleep(Duration::from_millis(200)).await;
            }
        });
        Self { socket, heart }
    }

    /// The next message of a camera that is passed on to the ground station.
    async fn of_camera(&self) -> (u8, MavMessage) {
        let mut buffer = [0; 512];
        loop {
            let received = tokio::time::timeout(patience(), self.socket.recv(&mut buffer)).await;
            let len = received.expect("the node speaks").unwrap();
            let mut read = None;
            each_in_datagram(&buffer[..len], &mut EndpointCounters::default(), |_, frame| {
                let header = frame.header;
                if header.system_id == VEHICLE {
                    let message = MavMessage::parse(MavlinkVersion::V2, header.message_id, frame.payload);
                    read = Some((header.component_id, message.unwrap()));
                }
            });
            if let Some(read) = read {
                return read;
            }
        }
    }

    /// What a ground station asks of a camera until that is acknowledged; the messages that came with it.
    async fn ask(&self, component: u8, message_id: f32) -> MavMessage {
        let command = MavMessage::COMMAND_LONG(COMMAND_LONG_DATA {
            command: MavCmd::MAV_CMD_REQUEST_MESSAGE,
            param1: message_id,
            target_system: VEHICLE,
            target_component: component,
            ..COMMAND_LONG_DATA::default()
        });
        self.socket.send(&frame(190, 255, &command)).await.unwrap();
        let mut acknowledged = false;
        loop {
            match self.of_camera().await {
                (from, MavMessage::COMMAND_ACK(ack)) if from == component => {
                    assert_eq!((ack.target_system, ack.target_component), (255, 190));
                    assert_eq!(ack.result, MavResult::MAV_RESULT_ACCEPTED);
                    acknowledged = true;
                }
                (_, MavMessage::HEARTBEAT(_)) => {}
                (from, message) => {
                    assert!(acknowledged && from == component, "{message:?}");
                    return message;
                }
            }
        }
    }

    async fn stream(&self, component: u8) -> VIDEO_STREAM_INFORMATION_DATA {
        match self.ask(component, 269.0).await {
            MavMessage::VIDEO_STREAM_INFORMATION(stream) => stream,
            other => panic!("{other:?}"),
        }
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_ground_station_finds_the_video_by_mavlink_and_receives_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("brighter.mp4");
    write_video(&path);
    let mut receiver = Receiver::at("127.0.0.1:0").await;
    let sent = to(receiver.address(), "camera", RtpQuality::Main);
    let camera = rule("camera", json!({ "source": "video", "path": path, "decode": false }));
    let swarm = Swarm::start_with(0, move |config, _| {
        config.adopt[0].payloads = vec![camera];
        config.video.rtp = vec![sent];
    })
    .await;
    let endpoint = *swarm.node().endpoint_addresses().values().next().unwrap();
    let autopilot = Autopilot::at(endpoint).await;

    let (component, found) = autopilot.of_camera().await;
    assert!(
        matches!(found, MavMessage::HEARTBEAT(ref m) if m.mavtype == MavType::MAV_TYPE_CAMERA),
        "{found:?}"
    );
    assert_eq!(component, OTHER_CAMERA - 1, "the other camera keeps its id");
    let MavMessage::CAMERA_INFORMATION(information) = autopilot.ask(component, 259.0).await else {
        panic!("no CAMERA_INFORMATION")
    };
    assert!(information.model_name.starts_with(b"camera\0"));
    let running = eventually(patience(), "the stream is told to run", async || {
        let stream = autopilot.stream(component).await;
        let running = VideoStreamStatusFlags::VIDEO_STREAM_STATUS_FLAGS_RUNNING;
        stream.flags.contains(running).then_some(stream)
    })
    .await;
    assert_eq!(running.mavtype, VideoStreamType::VIDEO_STREAM_TYPE_RTPUDP);
    assert_eq!(
        (u32::from(running.resolution_h), u32::from(running.resolution_v)),
        SIZE_PX
    );
    assert_eq!(running.uri.to_str().unwrap(), receiver.address().port().to_string());
    assert_eq!(receiver.picture().await.1, SIZE_PX);
    autopilot.heart.abort();
    swarm.stop().await;
}
