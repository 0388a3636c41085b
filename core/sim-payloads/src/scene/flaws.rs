//! What is wrong with a camera: its exposure wanders, its sensor is noisy, it rolls in the wind, and it does not quite know where it looks.
//! All of it follows from the seed and the time alone.
//!
//! Must never do: change anything that it was not told to, or allocate.

use skein_domain::payload::CameraPose;
use std::f64::consts::TAU;

/// Periods of two swings that make one which does not soon repeat itself, in seconds, and how much the first one counts.
type Swings = ([f64; 2], f64);
const EXPOSURE: Swings = ([31.0, 73.0], 0.6);
const ROLL: Swings = ([2.9, 1.1], 0.7);
const ERRORS: [Swings; 3] = [([43.0, 17.0], 0.8), ([61.0, 23.0], 0.8), ([97.0, 29.0], 0.8)];
/// What the sum of four even chances below 2^16 is on the average, and its standard deviation.
const CHANCE_MEAN: f32 = 131_070.0;
const CHANCE_DEVIATION: f32 = 37_837.2;

/// What is wrong with a camera; by default nothing.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Flaws {
    /// Two cameras with different seeds are wrong in different ways.
    pub seed: u64,
    /// By which share of itself the brightness rises and falls, over half a minute and more.
    pub exposure_change: f64,
    /// Standard deviation of the sensor's noise, in levels of 255. All three colours of a pixel have the same.
    pub noise_levels: f64,
    /// How far the picture rolls to either side, over a second and more.
    pub sway_rad: f64,
    /// How far each angle of the pose that it believes in is off at most; that changes over a quarter of a minute and more.
    pub pose_error_rad: f64,
}

impl Flaws {
    /// The pose with the roll that the wind gives it at a time.
    #[must_use]
    pub fn swayed(&self, pose: &CameraPose, time_s: f64) -> CameraPose {
        CameraPose {
            roll_rad: pose.roll_rad + self.sway_rad * self.swing(ROLL, 1, time_s),
            ..*pose
        }
    }

    /// Where the camera thinks that it looks when it truly looks so.
    #[must_use]
    pub fn believed(&self, pose: &CameraPose, time_s: f64) -> CameraPose {
        let [roll, pitch, yaw] = ERRORS;
        let off_rad = |swings, which| self.pose_error_rad * self.swing(swings, which, time_s);
        CameraPose {
            roll_rad: pose.roll_rad + off_rad(roll, 2),
            pitch_rad: pose.pitch_rad + off_rad(pitch, 3),
            yaw_rad: pose.yaw_rad + off_rad(yaw, 4),
            ..*pose
        }
    }

    /// Makes of a picture, three bytes per pixel, what the sensor makes of it.
    pub fn expose(&self, time_s: f64, rgb: &mut [u8]) {
        if self.exposure_change == 0.0 && self.noise_levels == 0.0 {
            return;
        }
        let gain = (1.0 + self.exposure_change * self.swing(EXPOSURE, 5, time_s)) as f32;
        let levels = self.noise_levels as f32 / CHANCE_DEVIATION;
        let key = mixed(self.seed ^ time_s.to_bits());
        for (pixel, number) in rgb.as_chunks_mut::<3>().0.iter_mut().zip(0_u64..) {
            let noise = (chance(key, number) - CHANCE_MEAN) * levels;
            *pixel = pixel.map(|value| (f32::from(value) * gain + noise).round() as u8);
        }
    }

    /// Between -1 and 1.
    fn swing(&self, ([first_s, second_s], first): Swings, which: u64, time_s: f64) -> f64 {
        let begin = |number: u64| mixed(self.seed ^ (2 * which + number)) as f64 / u64::MAX as f64;
        let at = |period_s: f64, number: u64| (TAU * (time_s / period_s + begin(number))).sin();
        first * at(first_s, 0) + (1.0 - first) * at(second_s, 1)
    }
}

/// The sum of four even chances.
fn chance(key: u64, number: u64) -> f32 {
    let bits = mixed(key.wrapping_add(number.wrapping_mul(0x9E37_79B9_7F4A_7C15)));
    let sum = (0..4).map(|part| (bits >> (16 * part)) & 0xffff).sum::<u64>();
    sum as f32
}

/// Bits that look like chance (the finaliser of SplitMix64).
fn mixed(bits: u64) -> u64 {
    let bits = bits.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let bits = (bits ^ (bits >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let bits = (bits ^ (bits >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    bits ^ (bits >> 31)
}

#[cfg(test)]
mod tests;
