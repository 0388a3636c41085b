//! Draws what a simulated camera sees into a file, and says how long a picture takes.
//!
//! `cargo run --release -p skein-sim-payloads --example picture -- picture.ppm`

use skein_domain::PositionNed;
use skein_domain::payload::CameraPose;
use skein_sim_payloads::scene::{Scene, SceneTarget, TargetKind};
use std::io::Write;
use std::time::Instant;

const PICTURES: u32 = 50;

fn main() -> std::io::Result<()> {
    let scene = Scene::new(1);
    let pose = CameraPose {
        position: PositionNed::new(0.0, 0.0, -20.0),
        roll_rad: 4_f64.to_radians(),
        pitch_rad: -12_f64.to_radians(),
        yaw_rad: 30_f64.to_radians(),
        field_of_view_rad: 70_f64.to_radians(),
    };
    let target = |north_m: f64, east_m: f64, height_m: f64, kind| SceneTarget {
        position: PositionNed::new(north_m, east_m, -height_m),
        size_m: 0.7,
        kind,
        ..SceneTarget::default()
    };
    let targets = [
        target(6.0, 3.0, 18.5, TargetKind::Multirotor),
        target(9.0, 7.5, 19.5, TargetKind::Multirotor),
        target(26.0, 12.0, 22.0, TargetKind::Multirotor),
        target(12.0, 3.0, 16.5, TargetKind::Marker),
        target(60.0, 50.0, 20.0, TargetKind::Multirotor),
    ];
    for (width_px, height_px) in [(320, 240), (640, 480), (1280, 720)] {
        let mut rgb = vec![0; 3 * width_px as usize * height_px as usize];
        let begin = Instant::now();
        for _ in 0..PICTURES {
            scene.render(&pose, &targets, width_px, height_px, &mut rgb);
        }
        println!("{width_px} x {height_px}: {:.2?}", begin.elapsed() / PICTURES);
        if let Some(path) = std::env::args().nth(1) {
            let mut file = std::fs::File::create(path)?;
            writeln!(file, "P6 {width_px} {height_px} 255")?;
            file.write_all(&rgb)?;
        }
    }
    Ok(())
}
