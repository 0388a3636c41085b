//! Draws every kind of thing in both looks, large, at 40 and at 8 pixels, against sky and ground, into a folder of PNG files; and a scene with clouds and noise.
//!
//! `PICTURES=/tmp/pictures cargo run -p skein-sim-payloads --example objects`

use skein_domain::PositionNed;
use skein_domain::payload::CameraPose;
use skein_sim_payloads::scene::{
    Flaws, Look, ObjectPath, Scene, SceneObject, SceneTarget, TargetKind, focal_length_px,
};
use std::path::Path;

const TILE_PX: (u32, u32) = (200, 150);
const FIELD_OF_VIEW_RAD: f64 = 0.5;
const KINDS: [TargetKind; 7] = [
    TargetKind::Multirotor,
    TargetKind::Marker,
    TargetKind::Quadrotor,
    TargetKind::FixedWing,
    TargetKind::Bird,
    TargetKind::Aeroplane,
    TargetKind::Helicopter,
];
/// Width in pixels, pitch of the camera and bearing of it from the thing's nose, in degrees, and the moment.
const VIEWS: [(f64, f64, f64, f64); 8] = [
    (150.0, 12.0, 50.0, 0.02),
    (150.0, -35.0, 130.0, 0.10),
    (40.0, 12.0, 90.0, 0.02),
    (40.0, 30.0, 10.0, 0.16),
    (40.0, -25.0, 120.0, 0.08),
    (8.0, 12.0, 60.0, 0.02),
    (8.0, 15.0, 60.0, 0.14),
    (8.0, -25.0, 60.0, 0.02),
];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::var("PICTURES")?;
    let folder = Path::new(&folder);
    std::fs::create_dir_all(folder)?;
    for (look, name) in [(Look::Visible, "visible"), (Look::Infrared, "infrared")] {
        let scene = Scene::with_ground(5, 0.0).with_look(look);
        let (width_px, height_px) = (TILE_PX.0 * VIEWS.len() as u32, TILE_PX.1 * KINDS.len() as u32);
        let mut sheet = image::RgbImage::new(width_px, height_px);
        for (row, kind) in (0_i64..).zip(KINDS) {
            for (column, view) in (0_i64..).zip(VIEWS) {
                let tile = tile(&scene, kind, view)?;
                let (left, top) = (column * i64::from(TILE_PX.0), row * i64::from(TILE_PX.1));
                image::imageops::replace(&mut sheet, &tile, left, top);
            }
        }
        sheet.save(folder.join(format!("{name}.png")))?;
        wide(&scene.with_clouds(0.5), TILE_PX.0 * 5, TILE_PX.1 * 4)?.save(folder.join(format!("{name}-clouds.png")))?;
    }
    Ok(())
}

fn drawn(scene: &Scene, pose: &CameraPose, targets: &[SceneTarget], size_px: (u32, u32)) -> Vec<u8> {
    let mut rgb = vec![0; 3 * size_px.0 as usize * size_px.1 as usize];
    scene.render(pose, targets, size_px.0, size_px.1, &mut rgb);
    rgb
}

fn tile(
    scene: &Scene,
    kind: TargetKind,
    (size_px, pitch_deg, bearing_deg, time_s): (f64, f64, f64, f64),
) -> Result<image::RgbImage, &'static str> {
    let object = SceneObject {
        kind,
        size_m: None,
        path: ObjectPath::Hover(PositionNed::new(0.0, 0.0, -120.0)),
        speed_m_s: None,
        phase: 0.0,
    };
    let distance_m = object.size_m() * focal_length_px(FIELD_OF_VIEW_RAD, TILE_PX.0) / size_px;
    let (yaw_rad, pitch_rad) = ((bearing_deg + 180.0_f64).to_radians(), f64::to_radians(pitch_deg));
    let pose = CameraPose {
        position: PositionNed::new(
            -distance_m * pitch_rad.cos() * yaw_rad.cos(),
            -distance_m * pitch_rad.cos() * yaw_rad.sin(),
            -120.0 + distance_m * pitch_rad.sin(),
        ),
        roll_rad: 0.0,
        pitch_rad,
        yaw_rad,
        field_of_view_rad: FIELD_OF_VIEW_RAD,
    };
    let rgb = drawn(scene, &pose, &[object.at(time_s)], TILE_PX);
    image::RgbImage::from_raw(TILE_PX.0, TILE_PX.1, rgb).ok_or("too few bytes")
}

fn wide(scene: &Scene, width_px: u32, height_px: u32) -> Result<image::RgbImage, &'static str> {
    let object = |kind, north_m, east_m, height_m: f64, phase| SceneObject {
        kind,
        size_m: None,
        path: ObjectPath::Circle {
            centre: PositionNed::new(north_m, east_m, -height_m),
            radius_m: 30.0,
        },
        speed_m_s: None,
        phase,
    };
    let objects = [
        object(TargetKind::Bird, 60.0, -10.0, 45.0, 0.4),
        object(TargetKind::Bird, 70.0, -10.0, 48.0, 0.7),
        object(TargetKind::Quadrotor, 50.0, 10.0, 40.0, 0.6),
        object(TargetKind::FixedWing, 80.0, 25.0, 60.0, 0.2),
        object(TargetKind::Aeroplane, 400.0, -120.0, 160.0, 0.1),
        object(TargetKind::Helicopter, 200.0, 60.0, 30.0, 0.5),
    ];
    let targets = objects.map(|object| object.at(12.3));
    let pose = CameraPose {
        position: PositionNed::new(0.0, 0.0, -40.0),
        roll_rad: 0.05,
        pitch_rad: 0.08,
        yaw_rad: 0.0,
        field_of_view_rad: 1.2,
    };
    let flaws = Flaws {
        noise_levels: 6.0,
        ..Flaws::default()
    };
    let mut rgb = drawn(scene, &pose, &targets, (width_px, height_px));
    flaws.expose(1.0, &mut rgb);
    image::RgbImage::from_raw(width_px, height_px, rgb).ok_or("too few bytes")
}
