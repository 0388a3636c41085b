//! Frames of a simulated scene: where the camera is and looks, and what is to be seen from there.
//!
//! Must never do: let what a picture's header says depend on the truth that the header is not to know.

use crate::settings::Settings;
use crate::truth::{NamedSeen, PictureTruth};
use skein_domain::exchange::{OwnState, PayloadReport, PeerState};
use skein_domain::payload::{CameraPose, GimbalState, PayloadKind};
use skein_domain::{NodeTime, VehicleId};
use skein_sim_payloads::scene::{Flaws, Scene, SceneObject, SceneTarget, Seen, TargetKind, truth};

/// What the camera looks at.
#[derive(Debug)]
pub(crate) struct Synthetic {
    scene: Scene,
    flaws: Flaws,
    gimbal: Option<GimbalState>,
    peers: Vec<VehicleId>,
    objects: Vec<SceneObject>,
    /// The peers, and behind them the objects where they were in the last picture.
    targets: Vec<SceneTarget>,
}

impl Synthetic {
    pub(crate) fn new(settings: &Settings, vehicle: VehicleId) -> Self {
        Self {
            scene: Scene::with_ground(settings.scene_seed, settings.ground_down_m)
                .with_look(settings.look)
                .with_clouds(settings.clouds),
            flaws: Flaws {
                // Each vehicle has its own wind and its own noise.
                seed: settings.scene_seed ^ u64::from(vehicle.0) << 48,
                exposure_change: settings.exposure_change,
                noise_levels: settings.noise_levels,
                sway_rad: settings.sway_rad,
                pose_error_rad: settings.pose_error_rad,
            },
            gimbal: None,
            peers: Vec::new(),
            objects: settings.objects.clone(),
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
        self.peers.clear();
        self.peers.extend(peers.iter().map(|peer| peer.id));
        self.targets.clear();
        self.targets.extend(peers.iter().map(|peer| SceneTarget {
            position: peer.kinematics.position,
            size_m: settings.vehicle_size_m,
            kind: TargetKind::Multirotor,
            velocity: peer.kinematics.velocity,
            ..SceneTarget::default()
        }));
    }

    /// Where the camera is and looks, in the wind; `None` while the vehicle does not know where it is.
    pub(crate) fn pose(
        &self,
        now: NodeTime,
        own: &OwnState,
        settings: &Settings,
        field_of_view_rad: f64,
    ) -> Option<CameraPose> {
        let vehicle = own.kinematics?;
        let pose = CameraPose {
            position: vehicle.position,
            field_of_view_rad,
            ..CameraPose::default()
        };
        let pose = match self.gimbal.as_ref().filter(|gimbal| gimbal.connected) {
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
        };
        Some(self.flaws.swayed(&pose, now.as_seconds()))
    }

    /// What the header of a picture says of a pose.
    pub(crate) fn believed(&self, now: NodeTime, pose: &CameraPose) -> CameraPose {
        self.flaws.believed(pose, now.as_seconds())
    }

    /// Draws a frame of three bytes per pixel.
    pub(crate) fn draw(&mut self, now: NodeTime, pose: &CameraPose, (width_px, height_px): (u32, u32), out: &mut [u8]) {
        let now_s = now.as_seconds();
        self.targets.truncate(self.peers.len());
        self.targets.extend(self.objects.iter().map(|object| object.at(now_s)));
        self.scene.render(pose, &self.targets, width_px, height_px, out);
        self.flaws.expose(now_s, out);
    }

    /// What is in the frame that was drawn last.
    pub(crate) fn truth(&self, frame: u64, time: NodeTime, pose: &CameraPose, size_px: (u32, u32)) -> PictureTruth {
        let named = |seen| NamedSeen {
            name: self.name(&seen),
            seen,
        };
        PictureTruth {
            frame,
            time,
            pose: *pose,
            seen: truth(pose, &self.targets, size_px).into_iter().map(named).collect(),
        }
    }

    fn name(&self, seen: &Seen) -> String {
        match self.peers.get(seen.target) {
            Some(vehicle) => format!("vehicle {}", vehicle.0),
            None => format!("{} {}", seen.kind.name(), seen.target - self.peers.len() + 1),
        }
    }
}
