//! PX4's numbers for its flight modes, and what each mode needs. The links have a table of their own: what one of the two has wrong, flights show.

use skein_domain::FlightMode;

/// PX4's main and sub mode; sub mode 0 where it has none.
pub(crate) fn px4_numbers(mode: FlightMode) -> (u8, u8) {
    match mode {
        FlightMode::Manual | FlightMode::Unknown => (1, 0),
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
    }
}

/// The mode that PX4's main and sub mode stand for, if there is one.
pub(crate) fn from_px4_numbers(main: u8, sub: u8) -> Option<FlightMode> {
    Some(match (main, sub) {
        (1, _) => FlightMode::Manual,
        (2, _) => FlightMode::Altitude,
        (3, _) => FlightMode::Position,
        (4, 2) => FlightMode::TakeOff,
        // An automatic mode without a sub mode, or "ready": it holds.
        (4, 0 | 1 | 3) => FlightMode::Hold,
        (4, 4) => FlightMode::Mission,
        (4, 5) => FlightMode::Return,
        (4, 6) => FlightMode::Land,
        (5, _) => FlightMode::Acro,
        (6, _) => FlightMode::Offboard,
        (7, _) => FlightMode::Stabilized,
        (10, _) => FlightMode::Termination,
        _ => return None,
    })
}

/// `custom_mode` of the heartbeat.
pub(crate) fn custom_mode(mode: FlightMode) -> u32 {
    let (main, sub) = px4_numbers(mode);
    u32::from(sub) << 24 | u32::from(main) << 16
}

/// Flags of `base_mode` without the armed bit.
pub(crate) fn base_mode_flags(mode: FlightMode) -> u8 {
    const CUSTOM: u8 = 1;
    const AUTO: u8 = 4;
    const GUIDED: u8 = 8;
    const STABILIZE: u8 = 16;
    const MANUAL_INPUT: u8 = 64;
    match mode {
        FlightMode::Manual | FlightMode::Acro => CUSTOM | MANUAL_INPUT,
        FlightMode::Altitude | FlightMode::Position | FlightMode::Stabilized => CUSTOM | STABILIZE | MANUAL_INPUT,
        FlightMode::Offboard => CUSTOM | STABILIZE,
        FlightMode::Termination | FlightMode::Unknown => CUSTOM,
        _ => CUSTOM | AUTO | GUIDED | STABILIZE,
    }
}

/// Flown by the pilot's sticks.
pub(crate) fn needs_pilot(mode: FlightMode) -> bool {
    use FlightMode as M;
    matches!(mode, M::Manual | M::Altitude | M::Position | M::Acro | M::Stabilized)
}

/// Modes that need to know the place.
pub(crate) fn needs_position(mode: FlightMode) -> bool {
    use FlightMode as M;
    matches!(
        mode,
        M::Position | M::Offboard | M::TakeOff | M::Hold | M::Ready | M::Mission | M::Return | M::Land
    )
}

/// Modes in which a vehicle does not let itself be armed; after a landing it leaves them for the last one that is not.
pub(crate) fn prevents_arming(mode: FlightMode) -> bool {
    use FlightMode as M;
    matches!(mode, M::Land | M::Return | M::Descend | M::Termination | M::Mission)
}

/// The name PX4 uses in its texts.
pub(crate) fn px4_name(mode: FlightMode) -> &'static str {
    match mode {
        FlightMode::Manual => "Manual",
        FlightMode::Altitude => "Altitude",
        FlightMode::Position => "Position",
        FlightMode::Acro => "Acro",
        FlightMode::Stabilized => "Stabilized",
        FlightMode::Offboard => "Offboard",
        FlightMode::TakeOff => "Takeoff",
        FlightMode::Hold | FlightMode::Ready => "Hold",
        FlightMode::Mission => "Mission",
        FlightMode::Return => "Return",
        FlightMode::Land => "Land",
        FlightMode::Descend => "Descend",
        FlightMode::Termination => "Termination",
        FlightMode::Unknown => "Unknown",
    }
}
