//! A camera that gives H.264 and no pixels: single pictures are made of it for those who ask, and only then.

use super::*;
use muxide::api::{MuxerBuilder, VideoCodec};
use ros2_client::{Context, MessageTypeName, Name, Node, NodeName, NodeOptions, Subscription};
use skein_dds::{DdsSettings, Place};
use skein_domain::payload::{FrameHeader, PixelFormat};
use skein_ros2::interfaces::sensor::CompressedImage;
use skein_ros2::quality;
use skein_video::{H264Encoder, Planes};
use std::net::Ipv4Addr;
use std::path::Path;

pub(super) const SIZE_PX: (u32, u32) = (160, 120);
const RATE_HZ: f64 = 25.0;

/// A video of a second that becomes brighter.
pub(super) fn write_video(path: &Path) {
    let mut encoder = H264Encoder::new(SIZE_PX, RATE_HZ).unwrap();
    let file = std::fs::File::create(path).unwrap();
    let builder = MuxerBuilder::new(file).video(VideoCodec::H264, SIZE_PX.0, SIZE_PX.1, RATE_HZ);
    let mut video = builder.build().unwrap();
    for number in 0..RATE_HZ as u8 {
        let header = FrameHeader {
            width_px: SIZE_PX.0,
            height_px: SIZE_PX.1,
            format: PixelFormat::Gray8,
            ..FrameHeader::default()
        };
        let pixels = vec![40 + 6 * number; (SIZE_PX.0 * SIZE_PX.1) as usize];
        let planes = Planes::of_frame(&header, &pixels).unwrap();
        let at_s = f64::from(number) / RATE_HZ;
        if let Some(picture) = encoder.encode(NodeTime::from_seconds(at_s), &planes, false).unwrap() {
            video.write_video(at_s, &picture.bytes, picture.key).unwrap();
        }
    }
    video.finish().unwrap();
}

async fn with_encoding_camera(folder: &Path, adapt: impl FnOnce(&mut NodeConfig)) -> Swarm {
    let path = folder.join("brighter.mp4");
    write_video(&path);
    let encoding = json!({ "source": "video", "path": path, "decode": false });
    with_camera_and(Isolation::InProcess, move |config| {
        config.adopt[0].payloads[0].config = encoding;
        adapt(config);
    })
    .await
}

async fn nobody_looks(swarm: &Swarm) {
    eventually(patience(), "nobody looks, so nothing is decoded", async || {
        (stream_of(swarm).await["viewers"] == 0).then_some(())
    })
    .await;
}

fn is_one_of_it(file: &[u8]) -> bool {
    let picture = image::load_from_memory(file).unwrap();
    (picture.width(), picture.height()) == SIZE_PX
}

#[tokio::test(flavor = "multi_thread")]
async fn a_camera_that_encodes_gives_single_pictures_to_those_who_ask() {
    let folder = tempfile::tempdir().unwrap();
    let swarm = with_encoding_camera(folder.path(), |_| {}).await;
    let url = format!("http://{}/api/v1/vehicles/1/payloads/camera/frame", swarm.web_address());
    for _ in 0..2 {
        let answer = reqwest::get(&url).await.unwrap();
        assert_eq!(
            (answer.status().as_u16(), &answer.headers()["content-type"]),
            (200, &"image/jpeg".parse().unwrap())
        );
        assert!(is_one_of_it(&answer.bytes().await.unwrap()));
        nobody_looks(&swarm).await;
    }
    swarm.stop().await;
}

/// A program of ROS 2 that subscribes to the pictures of the camera.
struct Ros2Viewer {
    // Before the context: it goes before that does.
    pictures: Subscription<CompressedImage>,
    _node: Node,
    _context: Context,
}

impl Ros2Viewer {
    fn join(domain_id: u16) -> Self {
        let place = Place::new(DdsSettings {
            domain_id,
            interfaces: vec![Ipv4Addr::LOCALHOST.into()],
            peers: Vec::new(),
        });
        let context = Context::from_domain_participant(place.participant().unwrap()).unwrap();
        let name = NodeName::new("/test", "viewer").unwrap();
        let options = NodeOptions::new().enable_rosout(false);
        let mut node = context.new_node(name, options).unwrap();
        let topic = Name::parse("/skein/uav_1/camera/image_raw/compressed").unwrap();
        let kind = MessageTypeName::new("sensor_msgs", "CompressedImage");
        let topic = node.create_topic(&topic, kind, &quality::pictures()).unwrap();
        Self {
            pictures: node.create_subscription(&topic, Some(quality::pictures())).unwrap(),
            _node: node,
            _context: context,
        }
    }

    async fn picture(&self) -> CompressedImage {
        let taken = tokio::time::timeout(patience(), self.pictures.async_take()).await;
        taken.expect("a picture on ROS 2").unwrap().0
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn ros2_gets_the_pictures_of_a_camera_that_encodes_while_it_subscribes() {
    // Domains of tests that run one after the other are apart: what has ended in one is remembered by others for a minute.
    let domain_id = 1 + (std::process::id() % 100) as u16;
    let folder = tempfile::tempdir().unwrap();
    let swarm = with_encoding_camera(folder.path(), |config| {
        config.ros2.enabled = true;
        config.ros2.image_rate_hz = 10.0;
        config.dds.domain_id = domain_id;
    })
    .await;
    nobody_looks(&swarm).await;
    let viewer = Ros2Viewer::join(domain_id);
    let (first, second) = (viewer.picture().await, viewer.picture().await);
    assert_eq!(
        (first.format.as_str(), first.header.frame_id.as_str()),
        ("jpeg", "uav_1/camera_optical")
    );
    assert!(is_one_of_it(&first.data) && is_one_of_it(&second.data));
    assert_ne!(first.header.stamp, second.header.stamp, "each picture is said once");
    drop(viewer);
    nobody_looks(&swarm).await;
    swarm.stop().await;
}
