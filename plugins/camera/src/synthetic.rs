//! Frames of a simulated scene: where the camera is and looks, and what is to be seen from there.

use crate::settings::Settings;
use skein_domain::exchange::{OwnState, PayloadReport, PeerState};
use skein_domain::payload::{CameraPose, GimbalState, PayloadKind};
use skein_sim_payloads::scene::{Scene, SceneTarget, TargetKind};

/// What the camera looks at.
#[derive(Debug)]
pub(crate) struct Synthetic {
    scene: Scene,
    gimbal: Option<GimbalState>,
    targets: Vec<SceneTarget>,
}

impl Synthetic {
    pub(crate) fn new(settings: &Settings) -> Self {
        Self {
            scene: Scene::with_ground(settings.scene_seed, settings.ground_down_m),
            gimbal: None,
            targets: Vec::new(),
        }
    }

    /// Another payload of the vehicle reported.
    pub(crate) fn hear(&mut self, report: &PayloadReport, settings: &Settings) {
        let carries = settings.gimbal.is_empty() || settings.gimbal == report.name;
        if report.kind == PayloadKind::Gimbal && carries {
            let state = report.state_json.as_deref();
            self.gimbal = state.and_then(|json| serde_json::from_str(json).ok());
        }
    }

    pub(crate) fn see(&mut self, peers: &[PeerState], settings: &Settings) {
        self.targets.clear();
        self.targets.extend(peers.iter().map(|peer| SceneTarget {
            position: peer.kinematics.position,
            size_m: settings.vehicle_size_m,
            kind: TargetKind::Multirotor,
            velocity: peer.kinematics.velocity,
            ..SceneTarget::default()
        }));
    }

    /// Where the camera is and looks; `None` while the vehicle does not know where it is.
    pub(crate) fn pose(&self, own: &OwnState, settings: &Settings, field_of_view_rad: f64) -> Option<CameraPose> {
        let vehicle = own.kinematics?;
        let pose = CameraPose {
            position: vehicle.position,
            field_of_view_rad,
            ..CameraPose::default()
        };
        Some(match self.gimbal.as_ref().filter(|gimbal| gimbal.connected) {
            Some(gimbal) => CameraPose {
                roll_rad: gimbal.roll_rad,
                pitch_rad: gimbal.pitch_rad,
                // From the nose: the vehicle's yaw is newer here than it was in the gimbal's report.
                yaw_rad: vehicle.yaw_rad + gimbal.yaw_vehicle_rad,
                ..pose
            },
            None => CameraPose {
                roll_rad: own.roll_rad.unwrap_or_default(),
                pitch_rad: own.pitch_rad.unwrap_or_default() + settings.mount_pitch_rad,
                yaw_rad: vehicle.yaw_rad,
                ..pose
            },
        })
    }

    /// Draws a frame of three bytes per pixel.
    pub(crate) fn draw(&self, pose: &CameraPose, width_px: u32, height_px: u32, out: &mut [u8]) {
        self.scene.render(pose, &self.targets, width_px, height_px, out);
    }
}
