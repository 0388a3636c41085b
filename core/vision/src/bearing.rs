//! A camera's geometry: from a pixel to a direction in the swarm frame, and back. A pinhole without distortion.

use nalgebra::{Rotation3, Vector3};
use skein_domain::payload::CameraPose;

/// A camera that took a picture of so many pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lens {
    pose: CameraPose,
    size_px: (f64, f64),
    focal_px: f64,
}

impl Lens {
    /// `None` if the pose or the size cannot be.
    #[must_use]
    pub fn new(pose: CameraPose, width_px: u32, height_px: u32) -> Option<Self> {
        let angles = [pose.roll_rad, pose.pitch_rad, pose.yaw_rad];
        let view = 0.001..std::f64::consts::PI * 0.95;
        let sound = pose.position.is_finite()
            && angles.iter().all(|rad| rad.is_finite())
            && view.contains(&pose.field_of_view_rad)
            && width_px > 0
            && height_px > 0;
        let (width_px, height_px) = (f64::from(width_px), f64::from(height_px));
        let focal_px = width_px / 2.0 / (pose.field_of_view_rad / 2.0).tan();
        let size_px = (width_px, height_px);
        sound.then_some(Self {
            pose,
            size_px,
            focal_px,
        })
    }

    /// Pixels in a radian, at the middle of the picture.
    #[must_use]
    pub fn focal_px(&self) -> f64 {
        self.focal_px
    }

    /// From the camera's axes (forward, right, down) to north, east, down.
    fn attitude(&self) -> Rotation3<f64> {
        Rotation3::from_euler_angles(self.pose.roll_rad, self.pose.pitch_rad, self.pose.yaw_rad)
    }

    /// The direction of a pixel: a unit vector along north, east, down.
    #[must_use]
    pub fn direction(&self, x_px: f64, y_px: f64) -> Vector3<f64> {
        let (width_px, height_px) = self.size_px;
        let ray = Vector3::new(self.focal_px, x_px - width_px / 2.0, y_px - height_px / 2.0);
        self.attitude() * ray.normalize()
    }

    /// The pixel of a place in the swarm frame; `None` behind the camera. It may lie outside of the picture.
    #[must_use]
    pub fn pixel(&self, place: Vector3<f64>) -> Option<(f64, f64)> {
        self.sees(&(place - self.pose.position.vector()))
    }

    /// The middle of the picture.
    #[must_use]
    pub fn middle_px(&self) -> (f64, f64) {
        (self.size_px.0 / 2.0, self.size_px.1 / 2.0)
    }

    /// The pixel of what lies in a direction along north, east, down; `None` behind the camera. It may lie outside of the picture.
    #[must_use]
    pub fn sees(&self, direction: &Vector3<f64>) -> Option<(f64, f64)> {
        let ray = self.attitude().inverse() * direction;
        let (width_px, height_px) = self.size_px;
        let at = |across: f64, size_px: f64| size_px / 2.0 + self.focal_px * across / ray.x;
        (ray.x > 1e-6).then(|| (at(ray.y, width_px), at(ray.z, height_px)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use skein_domain::PositionNed;

    fn pose(roll_rad: f64, pitch_rad: f64, yaw_rad: f64) -> CameraPose {
        CameraPose {
            position: PositionNed::new(10.0, -20.0, -30.0),
            roll_rad,
            pitch_rad,
            yaw_rad,
            field_of_view_rad: 1.2,
        }
    }

    #[test]
    fn axes_are_those_of_the_field() {
        let east = Lens::new(pose(0.0, 0.0, std::f64::consts::FRAC_PI_2), 640, 480).unwrap();
        assert!((east.direction(320.0, 240.0) - Vector3::y()).norm() < 1e-12);
        // Upwards is positive, and down in the picture is down.
        let up = Lens::new(pose(0.0, 0.5, 0.0), 640, 480).unwrap();
        assert!((up.direction(320.0, 240.0) - Vector3::new(0.5_f64.cos(), 0.0, -0.5_f64.sin())).norm() < 1e-12);
        assert!(up.direction(320.0, 300.0).z > up.direction(320.0, 200.0).z);
        assert!(up.direction(400.0, 240.0).y > 0.0);
        assert!(Lens::new(pose(f64::NAN, 0.0, 0.0), 640, 480).is_none());
        assert!(Lens::new(pose(0.0, 0.0, 0.0), 0, 480).is_none());
    }

    proptest! {
        #[test]
        fn a_pixel_is_where_its_direction_leads(
            roll in -0.5..0.5, pitch in -1.5..1.5, yaw in -3.0..3.0, x in 0.0..640.0, y in 0.0..480.0, range_m in 1.0..500.0,
        ) {
            let lens = Lens::new(pose(roll, pitch, yaw), 640, 480).unwrap();
            let place = lens.pose.position.vector() + lens.direction(x, y) * range_m;
            let (back_x, back_y) = lens.pixel(place).unwrap();
            prop_assert!((back_x - x).abs() < 1e-6 && (back_y - y).abs() < 1e-6);
        }
    }
}
