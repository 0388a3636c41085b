//! PX4's flight modes: `custom_mode = sub << 24 | main << 16`, to and from the words of the vocabulary.

use skein_domain::FlightMode;

/// Main and sub mode as PX4 counts them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Px4Mode {
    /// Main mode: 1 manual .. 10 termination.
    pub main: u8,
    /// Sub mode of the automatic and position modes; 0 elsewhere.
    pub sub: u8,
}

impl Px4Mode {
    /// From a heartbeat's `custom_mode`.
    #[must_use]
    pub fn from_custom_mode(custom_mode: u32) -> Self {
        let [_, _, main, sub] = custom_mode.to_le_bytes();
        Self { main, sub }
    }

    /// As a heartbeat's `custom_mode`.
    #[must_use]
    pub fn custom_mode(self) -> u32 {
        u32::from_le_bytes([0, 0, self.main, self.sub])
    }

    /// The vocabulary's word for it.
    #[must_use]
    pub fn flight_mode(self) -> FlightMode {
        match (self.main, self.sub) {
            (1, _) => FlightMode::Manual,
            (2, _) => FlightMode::Altitude,
            (3, _) => FlightMode::Position,
            (4, 1) => FlightMode::Ready,
            (4, 2) => FlightMode::TakeOff,
            (4, 3) => FlightMode::Hold,
            (4, 4) => FlightMode::Mission,
            (4, 5) => FlightMode::Return,
            (4, 6) => FlightMode::Land,
            (4, 20) => FlightMode::Descend,
            (5, _) => FlightMode::Acro,
            (6, _) => FlightMode::Offboard,
            (7, _) => FlightMode::Stabilized,
            (10, _) => FlightMode::Termination,
            _ => FlightMode::Unknown,
        }
    }

    /// What to ask PX4 for to get into a mode; `None` for [`FlightMode::Unknown`].
    #[must_use]
    pub fn of(mode: FlightMode) -> Option<Self> {
        let (main, sub) = match mode {
            FlightMode::Unknown => return None,
            FlightMode::Manual => (1, 0),
            FlightMode::Altitude => (2, 0),
            FlightMode::Position => (3, 0),
            FlightMode::Ready => (4, 1),
            FlightMode::TakeOff => (4, 2),
            FlightMode::Hold => (4, 3),
            FlightMode::Mission => (4, 4),
            FlightMode::Return => (4, 5),
            FlightMode::Land => (4, 6),
            FlightMode::Descend => (4, 20),
            FlightMode::Acro => (5, 0),
            FlightMode::Offboard => (6, 0),
            FlightMode::Stabilized => (7, 0),
            FlightMode::Termination => (10, 0),
        };
        Some(Self { main, sub })
    }
}

#[cfg(test)]
mod tests {
    //! The encoding against the numbers measured on a real PX4.

    use super::*;

    #[test]
    fn every_mode_comes_back_and_hold_is_what_px4_sends() {
        for &mode in FlightMode::ALL {
            let Some(px4) = Px4Mode::of(mode) else {
                assert_eq!(mode, FlightMode::Unknown);
                continue;
            };
            assert_eq!(Px4Mode::from_custom_mode(px4.custom_mode()).flight_mode(), mode);
        }
        assert_eq!(
            Px4Mode::from_custom_mode(3 << 24 | 4 << 16).flight_mode(),
            FlightMode::Hold
        );
        assert_eq!(Px4Mode::from_custom_mode(6 << 16).flight_mode(), FlightMode::Offboard);
        assert_eq!(Px4Mode::from_custom_mode(99 << 16).flight_mode(), FlightMode::Unknown);
    }
}
