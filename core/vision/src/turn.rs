//! How what stands still has moved from one picture to the next, since the camera has turned: by what its attitude says, put right by what is seen.
//!
//! Must never do: look at a picture.

use crate::Lens;

/// The camera's own motion between two pictures.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Turn {
    /// As it looked in the last picture, and as it looks now.
    lenses: Option<(Lens, Lens)>,
    /// What is left beside that, in pixels to the right and down.
    rest_px: (f64, f64),
}

impl Turn {
    /// As the camera's pose says, if it is known of both pictures. What is far counts: that the camera has moved is left out.
    #[must_use]
    pub fn by_pose(before: Option<Lens>, now: Option<Lens>) -> Self {
        Self {
            lenses: before.zip(now),
            rest_px: (0.0, 0.0),
        }
    }

    /// The same, where the picture itself says how far its middle has moved. A pose comes a moment early or late, and an attitude is a little wrong.
    #[must_use]
    pub fn put_right(self, middle_px: Option<(f64, f64)>) -> Self {
        let Some((x_px, y_px)) = middle_px else { return self };
        let (by_pose_x_px, by_pose_y_px) = Self {
            rest_px: (0.0, 0.0),
            ..self
        }
        .of_middle();
        Self {
            rest_px: (x_px - by_pose_x_px, y_px - by_pose_y_px),
            ..self
        }
    }

    /// How far what was in the middle has moved, in pixels to the right and down.
    #[must_use]
    pub fn of_middle(&self) -> (f64, f64) {
        let (x_px, y_px) = self.lenses.map_or((0.0, 0.0), |(before, _)| before.middle_px());
        self.at(x_px, y_px)
    }

    /// How far what was at a pixel has moved, in pixels to the right and down.
    #[must_use]
    pub fn at(&self, x_px: f64, y_px: f64) -> (f64, f64) {
        let there = self
            .lenses
            .and_then(|(before, now)| now.sees(&before.direction(x_px, y_px)));
        let (new_x_px, new_y_px) = there.unwrap_or((x_px, y_px));
        (new_x_px - x_px + self.rest_px.0, new_y_px - y_px + self.rest_px.1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use skein_domain::payload::CameraPose;

    fn lens(roll_rad: f64, pitch_rad: f64, yaw_rad: f64) -> Lens {
        let pose = CameraPose {
            roll_rad,
            pitch_rad,
            yaw_rad,
            field_of_view_rad: 1.2,
            ..CameraPose::default()
        };
        Lens::new(pose, 640, 512).expect("is one")
    }

    #[test]
    fn what_is_seen_outweighs_the_pose_and_a_pose_is_not_needed() {
        let none = Turn::by_pose(None, Some(lens(0.0, 0.0, 0.0)));
        assert_eq!(none.at(5.0, 7.0), (0.0, 0.0));
        assert_eq!(none.put_right(Some((3.0, -2.0))).at(5.0, 7.0), (3.0, -2.0));
        // The nose goes down: what stands still goes up in the picture.
        let down = Turn::by_pose(Some(lens(0.0, 0.0, 0.0)), Some(lens(0.0, -0.1, 0.0)));
        assert!(down.of_middle().1 < -46.0 && down.of_middle().0.abs() < 1e-9);
        let seen = down.put_right(Some((1.0, -50.0)));
        assert!((seen.of_middle().1 + 50.0).abs() < 1e-9 && (seen.of_middle().0 - 1.0).abs() < 1e-9);
        // A roll moves what is beside the middle, whatever the middle does.
        let roll = Turn::by_pose(Some(lens(0.0, 0.0, 0.0)), Some(lens(0.2, 0.0, 0.0))).put_right(Some((0.0, 0.0)));
        assert!(roll.at(600.0, 256.0).1 < -50.0 && roll.at(40.0, 256.0).1 > 50.0);
    }

    proptest! {
        #[test]
        fn what_turns_there_and_back_is_where_it_was(
            roll in -0.3..0.3, pitch in -0.3..0.3, yaw in -0.3..0.3, x in 100.0..540.0, y in 100.0..412.0,
        ) {
            let (before, after) = (Some(lens(0.0, 0.1, 2.0)), Some(lens(roll, 0.1 + pitch, 2.0 + yaw)));
            let (dx, dy) = Turn::by_pose(before, after).at(x, y);
            let (back_x, back_y) = Turn::by_pose(after, before).at(x + dx, y + dy);
            prop_assert!((dx + back_x).abs() < 1e-6 && (dy + back_y).abs() < 1e-6);
        }
    }
}
