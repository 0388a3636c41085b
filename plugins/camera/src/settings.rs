//! The plugin's configuration.

use crate::stream;
use payload_mavlink::Patience;
use schemars::JsonSchema;
use serde::Deserialize;
use skein_domain::PositionNed;
use skein_sim_payloads::scene::{Look, ObjectPath, SceneObject};
use std::net::SocketAddr;
use std::path::PathBuf;

/// More objects than this in a simulated world are refused: each is drawn and judged in every picture.
const MOST_OBJECTS: usize = 64;
/// Places are within this of the swarm frame's origin along each axis, in metres.
const FARTHEST_M: f64 = 1e5;

/// Where frames come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Source {
    /// None: a MAVLink camera is steered, its pictures stay with it.
    Mavlink,
    /// A simulated scene, as seen from where the vehicle is and the gimbal looks.
    #[default]
    Synthetic,
    /// The pictures (JPEG, PNG) of a folder in the order of their names, again and again.
    Stills,
    /// A video file (H.264 in MP4), again and again, at its own speed: passed on as it is encoded, and decoded at `rate_hz` beside that.
    Video,
    /// A camera in the network that is asked over RTSP: its H.264 is passed on as it is.
    Rtsp,
    /// RTP with H.264 that somebody sends to `listen`: it is passed on as it is.
    Rtp,
    /// A pipeline of GStreamer that gives H.264, for cameras on this computer's own ports. It needs `gst-launch-1.0`.
    Gstreamer,
}

/// Configuration of the camera plugin. Every key may be left out, but `path` for stills and video.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Settings {
    /// Where frames come from.
    pub source: Source,
    /// Steer a MAVLink camera beside another source of frames. With `source = "mavlink"` it is always steered.
    pub mavlink: bool,
    /// The MAVLink camera's component id.
    #[schemars(range(min = 1))]
    pub component_id: u8,
    /// The folder of stills, or the video file.
    pub path: PathBuf,
    /// Address of a camera in the network: `rtsp://HOST[:PORT]/PATH`.
    pub url: String,
    /// Who asks for it; empty: nobody in particular.
    pub user: String,
    /// The password of that user.
    pub password: String,
    /// Where RTP comes to: `ADDRESS:PORT`, such as `0.0.0.0:5600`. The address of a multicast group is joined.
    pub listen: String,
    /// Parameter sets of a sender that does not send them, as SDP has them (`sprop-parameter-sets`): base64, with commas between.
    pub parameter_sets: String,
    /// The pipeline in GStreamer's launch syntax, up to and with what encodes, such as `videotestsrc is-live=true ! x264enc tune=zerolatency`.
    pub pipeline: String,
    /// Width of simulated frames in pixels. Stills and video have their own.
    #[schemars(range(min = 16, max = 4096))]
    pub width_px: u32,
    /// Height of simulated frames in pixels.
    #[schemars(range(min = 16, max = 4096))]
    pub height_px: u32,
    /// Give decoded pictures of a video too, for detectors and for those who ask for a single picture.
    pub decode: bool,
    /// Frames per second. A frame that nobody has room for is left out.
    #[schemars(range(min = 0.01, max = 60.0))]
    pub rate_hz: f64,
    /// Horizontal field of view at the widest zoom, in radians. A MAVLink camera that says its own is believed.
    #[schemars(range(min = 0.01, max = 3.0))]
    pub field_of_view_rad: f64,
    /// The greatest zoom factor. MAVLink has no message for it.
    #[schemars(range(min = 1.0))]
    pub zoom_max: f64,
    /// Where the camera looks in the vehicle while no gimbal reports, upwards from its nose, in radians.
    #[schemars(range(min = -1.6, max = 1.6))]
    pub mount_pitch_rad: f64,
    /// Name of the gimbal that carries it, among the vehicle's payloads; empty: any.
    pub gimbal: String,
    /// Which simulated world.
    pub scene_seed: u64,
    /// How far the ground of the simulated world is below the origin of the swarm frame, in metres.
    pub ground_down_m: f64,
    /// How wide other vehicles are in the simulated world, in metres.
    #[schemars(range(min = 0.01))]
    pub vehicle_size_m: f64,
    /// What moves in the simulated world beside the swarm: other UAVs, birds, aeroplanes, helicopters. Where each is follows from the node's clock, so cameras of
    /// several nodes agree as well as their clocks do.
    #[schemars(length(max = 64))]
    pub objects: Vec<SceneObject>,
    /// Whether simulated pictures show light or warmth.
    pub look: Look,
    /// How much of the simulated sky is under clouds, as a share.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub clouds: f64,
    /// By which share of itself the brightness of simulated pictures slowly rises and falls.
    #[schemars(range(min = 0.0, max = 0.9))]
    pub exposure_change: f64,
    /// Standard deviation of the noise in simulated pictures, in levels of 255.
    #[schemars(range(min = 0.0, max = 64.0))]
    pub noise_levels: f64,
    /// How far simulated pictures roll to either side, as on a vehicle in wind, in radians. The header of a frame knows of it.
    #[schemars(range(min = 0.0, max = 0.8))]
    pub sway_rad: f64,
    /// How far roll, pitch and yaw in the header of a simulated frame are off at most, each, in radians. Nobody is told how far they are.
    #[schemars(range(min = 0.0, max = 0.5))]
    pub pose_error_rad: f64,
    /// Report in the state, as `truth`, what is in the last simulated picture: name, kind, position, velocity and box of each thing.
    pub truth: bool,
    /// Draw the node's clock into simulated frames, for whoever measures how old a picture is when it is seen.
    pub clock: bool,
    /// How long an acknowledgement is waited for, in seconds, before a command is sent again.
    #[schemars(range(min = 0.05))]
    pub ack_timeout_s: f64,
    /// How often a command is sent before it counts as failed.
    #[schemars(range(min = 1))]
    pub attempts: u32,
    /// The MAVLink camera counts as lost when nothing was heard of it for this long, in seconds.
    #[schemars(range(min = 0.1))]
    pub lost_after_s: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            source: Source::Synthetic,
            mavlink: false,
            component_id: 100,
            path: PathBuf::new(),
            url: String::new(),
            user: String::new(),
            password: String::new(),
            listen: String::new(),
            parameter_sets: String::new(),
            pipeline: String::new(),
            width_px: 640,
            height_px: 360,
            decode: true,
            rate_hz: 5.0,
            field_of_view_rad: 1.2,
            zoom_max: 6.0,
            mount_pitch_rad: 0.0,
            gimbal: String::new(),
            scene_seed: 1,
            ground_down_m: 0.0,
            vehicle_size_m: 0.6,
            objects: Vec::new(),
            look: Look::Visible,
            clouds: 0.0,
            exposure_change: 0.0,
            noise_levels: 0.0,
            sway_rad: 0.0,
            pose_error_rad: 0.0,
            truth: false,
            clock: false,
            ack_timeout_s: 0.7,
            attempts: 4,
            lost_after_s: 5.0,
        }
    }
}

impl Settings {
    /// Whether every value can be worked with; else which cannot.
    pub fn check(&self) -> Result<(), String> {
        for (key, value, low, high) in [
            ("component_id", f64::from(self.component_id), 1.0, 255.0),
            ("width_px", f64::from(self.width_px), 16.0, 4096.0),
            ("height_px", f64::from(self.height_px), 16.0, 4096.0),
            ("rate_hz", self.rate_hz, 0.01, 60.0),
            ("field_of_view_rad", self.field_of_view_rad, 0.01, 3.0),
            ("zoom_max", self.zoom_max, 1.0, 1000.0),
            ("mount_pitch_rad", self.mount_pitch_rad, -1.6, 1.6),
            ("ground_down_m", self.ground_down_m, -1e5, 1e5),
            ("vehicle_size_m", self.vehicle_size_m, 0.01, 1000.0),
            ("clouds", self.clouds, 0.0, 1.0),
            ("exposure_change", self.exposure_change, 0.0, 0.9),
            ("noise_levels", self.noise_levels, 0.0, 64.0),
            ("sway_rad", self.sway_rad, 0.0, 0.8),
            ("pose_error_rad", self.pose_error_rad, 0.0, 0.5),
            ("ack_timeout_s", self.ack_timeout_s, 0.05, 60.0),
            ("attempts", f64::from(self.attempts), 1.0, 1000.0),
            ("lost_after_s", self.lost_after_s, 0.1, 1000.0),
        ] {
            within(key, value, low, high)?;
        }
        self.check_scene()?;
        self.check_source()
    }

    fn check_scene(&self) -> Result<(), String> {
        if self.source != Source::Synthetic && (self.truth || !self.objects.is_empty()) {
            return Err("truth and objects are of a simulated scene: they need source = \"synthetic\"".to_owned());
        }
        if self.objects.len() > MOST_OBJECTS {
            return Err(format!(
                "objects: {} of them, at most {MOST_OBJECTS} are drawn",
                self.objects.len()
            ));
        }
        let mut numbered = self.objects.iter().zip(1..);
        numbered.try_for_each(|(object, number)| {
            check_object(object)
                .map_err(|reason| format!("objects, number {number} ({}): {reason}", object.kind.name()))
        })
    }

    fn check_source(&self) -> Result<(), String> {
        let reads_files = matches!(self.source, Source::Stills | Source::Video);
        if reads_files && self.path.as_os_str().is_empty() {
            return Err("path is needed for stills and video".to_owned());
        }
        if self.source == Source::Rtsp && !self.url.starts_with("rtsp://") {
            return Err("url is needed for rtsp: rtsp://HOST[:PORT]/PATH".to_owned());
        }
        if self.source == Source::Gstreamer {
            match stream::words(&self.pipeline) {
                None => return Err("pipeline: a quotation mark is left open".to_owned()),
                Some(words) if words.is_empty() => {
                    return Err("pipeline is needed for gstreamer: SOURCE ! ENCODER".to_owned());
                }
                Some(_) => {}
            }
        }
        if self.source == Source::Rtp {
            self.listen_address()?;
            stream::parameter_sets(&self.parameter_sets).map_err(|reason| format!("parameter_sets: {reason}"))?;
        }
        Ok(())
    }

    /// Where RTP comes to; else why it cannot.
    pub(crate) fn listen_address(&self) -> Result<SocketAddr, String> {
        let listen = &self.listen;
        match listen.parse::<SocketAddr>() {
            Ok(address) if address.port() != 0 => Ok(address),
            _ if listen.is_empty() => Err("listen is needed for rtp: ADDRESS:PORT, such as 0.0.0.0:5600".to_owned()),
            _ => Err(format!(
                "listen = {listen:?}: it must be ADDRESS:PORT, such as 0.0.0.0:5600"
            )),
        }
    }

    /// Whether a MAVLink camera is steered.
    pub(crate) fn steers_remote(&self) -> bool {
        self.mavlink || self.source == Source::Mavlink
    }

    pub(crate) fn patience(&self) -> Patience {
        Patience {
            wait_s: self.ack_timeout_s,
            attempts: self.attempts,
        }
    }

    /// Horizontal field of view at a zoom factor, in radians.
    pub(crate) fn field_of_view_at(&self, widest_rad: f64, zoom: f64) -> f64 {
        2.0 * ((0.5 * widest_rad).tan() / zoom.max(1.0)).atan()
    }
}

fn within(key: &str, value: f64, low: f64, high: f64) -> Result<(), String> {
    if (low..=high).contains(&value) {
        return Ok(());
    }
    Err(format!("{key} = {value}: it must be within {low} and {high}"))
}

fn check_object(object: &SceneObject) -> Result<(), String> {
    within("size_m", object.size_m(), 0.01, 1000.0)?;
    within("speed_m_s", object.speed_m_s(), 0.1, 1000.0)?;
    within("phase", object.phase, 0.0, 1.0)?;
    let place = |key: &str, place: &PositionNed| {
        within(&format!("{key}.north_m"), place.north_m, -FARTHEST_M, FARTHEST_M)?;
        within(&format!("{key}.east_m"), place.east_m, -FARTHEST_M, FARTHEST_M)?;
        within(&format!("{key}.down_m"), place.down_m, -FARTHEST_M, FARTHEST_M)
    };
    match &object.path {
        ObjectPath::Line { from, to } => {
            place("from", from)?;
            place("to", to)?;
            within(
                "the way over the ground from `from` to `to`, in metres,",
                from.horizontal_distance_m(to),
                1.0,
                2.0 * FARTHEST_M,
            )
        }
        ObjectPath::Circle { centre, radius_m } => {
            place("centre", centre)?;
            within("radius_m", *radius_m, 0.1, FARTHEST_M)
        }
        ObjectPath::Hover(at) => place("hover", at),
    }
}
