//! The wind that the way home is reckoned with: what the vehicle reports, or else an assumption to be on the safe side.
//!
//! Must never do: be more favourable than what is known.

use skein_domain::{EnergySettings, VelocityNed};

/// A wind for reckoning.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Wind {
    /// As reported: where the air moves to.
    Reported {
        /// Northward in metres per second.
        north_m_s: f64,
        /// Eastward in metres per second.
        east_m_s: f64,
    },
    /// Not known: this much from ahead, wherever one flies.
    Assumed {
        /// Headwind in metres per second.
        headwind_m_s: f64,
    },
}

impl Wind {
    /// The reported wind if there is a usable one, else the configured assumption.
    #[must_use]
    pub fn known_or_assumed(reported: Option<&VelocityNed>, settings: &EnergySettings) -> Self {
        match reported {
            Some(wind) if wind.north_m_s.is_finite() && wind.east_m_s.is_finite() => Self::Reported {
                north_m_s: wind.north_m_s,
                east_m_s: wind.east_m_s,
            },
            _ => Self::Assumed {
                headwind_m_s: settings.assumed_wind_m_s.max(0.0),
            },
        }
    }

    /// Speed over the ground in metres per second that an airspeed gives along a bearing (radians clockwise from north), with
    /// `gust_m_s` more from ahead. `None` if the wind is stronger: one does not get there.
    ///
    /// The nose points so far into the wind that the drift across is made up for; what is left of the airspeed, and the wind along
    /// the way, is the speed over the ground (the wind triangle).
    #[must_use]
    pub fn ground_speed_m_s(&self, airspeed_m_s: f64, bearing_rad: f64, gust_m_s: f64) -> Option<f64> {
        let (along_m_s, across_m_s) = match *self {
            Self::Reported { north_m_s, east_m_s } => {
                let (sin, cos) = bearing_rad.sin_cos();
                (north_m_s * cos + east_m_s * sin, east_m_s * cos - north_m_s * sin)
            }
            Self::Assumed { headwind_m_s } => (-headwind_m_s, 0.0),
        };
        let forward_squared = airspeed_m_s * airspeed_m_s - across_m_s * across_m_s;
        if !(airspeed_m_s > 0.0 && forward_squared > 0.0) {
            return None;
        }
        let speed_m_s = forward_squared.sqrt() + along_m_s - gust_m_s.max(0.0);
        (speed_m_s >= SLOWEST_M_S && speed_m_s.is_finite()).then_some(speed_m_s)
    }
}

/// Getting on slower than this over the ground is not getting there, in metres per second.
pub(crate) const SLOWEST_M_S: f64 = 0.5;

#[cfg(test)]
mod tests;
