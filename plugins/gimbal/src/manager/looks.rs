//! What a device is and where it looks, as it or its manager says.

use super::{FIRST_COMPONENT, Manager};
use crate::attitude::{Attitude, Limits, Yaw};
use crate::orders::Moment;
use mavlink::dialects::common::{
    GIMBAL_DEVICE_ATTITUDE_STATUS_DATA, GIMBAL_DEVICE_INFORMATION_DATA, GimbalDeviceErrorFlags, GimbalDeviceFlags,
};
use payload_mavlink::text;
use skein_domain::frames::wrap_angle_rad;
use skein_domain::payload::MavlinkMessage;

/// MOUNT_ORIENTATION. The library marks the message as superseded; for PX4's servos nothing supersedes it.
pub(super) const MOUNT_ORIENTATION: u32 = 265;

impl Manager {
    pub(super) fn hear_device(&mut self, at: &Moment, message: &MavlinkMessage, said: &GIMBAL_DEVICE_INFORMATION_DATA) {
        if !self.is_of_device(message, said.gimbal_device_id) {
            return;
        }
        self.heard = Some(at.now);
        let (vendor, model) = (text(&*said.vendor_name), text(&*said.model_name));
        self.model = format!("{vendor} {model}").trim().to_owned();
        self.device_limits = Limits::said((said.pitch_min, said.pitch_max), (said.yaw_min, said.yaw_max));
    }

    pub(super) fn hear_attitude(
        &mut self,
        at: &Moment,
        message: &MavlinkMessage,
        said: &GIMBAL_DEVICE_ATTITUDE_STATUS_DATA,
    ) {
        if !self.is_of_device(message, said.gimbal_device_id) {
            return;
        }
        let has = |flag| said.flags.contains(flag);
        let from_north = if has(GimbalDeviceFlags::GIMBAL_DEVICE_FLAGS_YAW_IN_EARTH_FRAME) {
            true
        } else if has(GimbalDeviceFlags::GIMBAL_DEVICE_FLAGS_YAW_IN_VEHICLE_FRAME) {
            false
        } else {
            // Devices that know neither flag say it by this one.
            has(GimbalDeviceFlags::GIMBAL_DEVICE_FLAGS_YAW_LOCK)
        };
        let yaw = if from_north { Yaw::North } else { Yaw::Vehicle };
        let Some(attitude) = Attitude::from_quaternion(at.now, said.q, yaw) else {
            return;
        };
        self.heard = Some(at.now);
        self.attitude = Some(attitude);
        self.failures = said.failure_flags.bits();
        self.flags = said.flags.bits();
    }

    /// Where the servos stand that the autopilot turns itself.
    ///
    /// Of such a gimbal PX4 puts into GIMBAL_DEVICE_ATTITUDE_STATUS what was asked for, even where it does not turn the servo, and only
    /// into MOUNT_ORIENTATION what it puts out: degrees from the vehicle's body, which is what it wants less the vehicle's own angle,
    /// each axis for itself. So the vehicle's angles are added here. Nothing measures a servo; it is as near as one gets.
    #[expect(deprecated, reason = "see above")]
    pub(super) fn hear_mount(&mut self, at: &Moment, message: &MavlinkMessage) {
        use mavlink::dialects::common::MOUNT_ORIENTATION_DATA;
        let Some(said) = payload_mavlink::decode::<MOUNT_ORIENTATION_DATA>(message) else {
            return;
        };
        let (true, Some((vehicle_roll_rad, vehicle_pitch_rad))) = (self.has_servos(), at.vehicle_roll_pitch_rad) else {
            return;
        };
        let [roll, pitch, yaw] = [said.roll, said.pitch, said.yaw].map(|deg| f64::from(deg).to_radians());
        if self.component != Some(message.component_id) || !(roll.is_finite() && pitch.is_finite() && yaw.is_finite()) {
            return;
        }
        self.servos = Some(Attitude {
            heard: at.now,
            roll_rad: wrap_angle_rad(roll + vehicle_roll_rad),
            pitch_rad: wrap_angle_rad(pitch + vehicle_pitch_rad),
            yaw: Yaw::Vehicle(wrap_angle_rad(yaw)),
        });
    }

    /// Whether the device is servos at the autopilot's outputs.
    pub(super) fn has_servos(&self) -> bool {
        (1..FIRST_COMPONENT).contains(&self.device)
    }

    /// Where the device looks, by what is nearest to the truth.
    pub(super) fn looks(&self, at: &Moment) -> Option<Attitude> {
        let servos = self
            .servos
            .filter(|servos| at.within(Some(servos.heard), at.settings.lost_after_s));
        servos.or(self.attitude)
    }

    /// Whether the device says that it is at an end stop.
    pub(super) fn is_at_end_stop(&self) -> bool {
        GimbalDeviceErrorFlags::from_bits_retain(self.failures).intersects(
            GimbalDeviceErrorFlags::GIMBAL_DEVICE_ERROR_FLAGS_AT_PITCH_LIMIT
                | GimbalDeviceErrorFlags::GIMBAL_DEVICE_ERROR_FLAGS_AT_YAW_LIMIT,
        )
    }

    pub(super) fn fault(&self) -> String {
        let failures = GimbalDeviceErrorFlags::from_bits_retain(self.failures);
        let words = [
            (
                GimbalDeviceErrorFlags::GIMBAL_DEVICE_ERROR_FLAGS_ENCODER_ERROR,
                "encoder",
            ),
            (GimbalDeviceErrorFlags::GIMBAL_DEVICE_ERROR_FLAGS_POWER_ERROR, "power"),
            (GimbalDeviceErrorFlags::GIMBAL_DEVICE_ERROR_FLAGS_MOTOR_ERROR, "motor"),
            (
                GimbalDeviceErrorFlags::GIMBAL_DEVICE_ERROR_FLAGS_SOFTWARE_ERROR,
                "software",
            ),
            (
                GimbalDeviceErrorFlags::GIMBAL_DEVICE_ERROR_FLAGS_COMMS_ERROR,
                "communication",
            ),
            (
                GimbalDeviceErrorFlags::GIMBAL_DEVICE_ERROR_FLAGS_CALIBRATION_RUNNING,
                "calibrating",
            ),
            (
                GimbalDeviceErrorFlags::GIMBAL_DEVICE_ERROR_FLAGS_NO_MANAGER,
                "no manager",
            ),
        ];
        let mut faults: Vec<&str> = words
            .iter()
            .filter(|(flag, _)| failures.contains(*flag))
            .map(|(_, w)| *w)
            .collect();
        let flags = GimbalDeviceFlags::from_bits_retain(self.flags);
        if flags.contains(GimbalDeviceFlags::GIMBAL_DEVICE_FLAGS_RC_EXCLUSIVE) {
            faults.push("steered by the remote control alone");
        }
        faults.join(", ")
    }

    /// Whether a message is of the device: by the id it names, or by where it comes from.
    fn is_of_device(&self, message: &MavlinkMessage, named: u8) -> bool {
        if self.device == 0 {
            return self.component.is_some();
        }
        named == self.device
            || named == 0 && (message.component_id == self.device || Some(message.component_id) == self.component)
    }
}
