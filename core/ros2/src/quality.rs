//! Quality of service of everything that is said and heard. No writer waits: what a reader does not take in time is dropped and counted.
//!
//! Must never do: make a writer that blocks. One stalled reader would hold up all vehicles.

use ros2_client::qos::{Durability, History, QosProfile, Reliability, WhenFull};

const BASE: QosProfile = QosProfile::subscription_default();
const RELIABLE: Reliability = Reliability::Reliable {
    when_full: WhenFull::Fail,
};

const fn kept(profile: QosProfile, depth: usize) -> QosProfile {
    profile.history(History::KeepLast { depth })
}

/// Poses and odometry.
#[must_use]
pub const fn motion(reliable: bool) -> QosProfile {
    let profile = kept(BASE, 20);
    if reliable {
        profile.reliability(RELIABLE)
    } else {
        profile
    }
}

/// Transforms: what listens for them asks for it reliably.
#[must_use]
pub const fn transforms() -> QosProfile {
    kept(BASE, 100).reliability(RELIABLE)
}

/// What is told now and then.
#[must_use]
pub const fn status() -> QosProfile {
    kept(BASE, 10).reliability(RELIABLE)
}

/// What who comes later is told too.
#[must_use]
pub const fn latched() -> QosProfile {
    kept(BASE, 1)
        .reliability(RELIABLE)
        .durability(Durability::TransientLocal)
}

/// Pictures.
#[must_use]
pub const fn pictures() -> QosProfile {
    kept(BASE, 2)
}

/// Velocities: only the newest matters, whoever sends it and however.
#[must_use]
pub const fn velocities() -> QosProfile {
    kept(BASE, 1)
}

/// Requests and answers of services.
#[must_use]
pub const fn services() -> QosProfile {
    kept(BASE, 10).reliability(RELIABLE)
}
