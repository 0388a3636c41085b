//! What a gimbal was asked to do, as it stands in the snapshot.

use crate::attitude::{Direction, Yaw};
use minicbor::{Decode, Encode};
use skein_domain::frames::wrap_angle_rad;
use skein_domain::payload::{GimbalCommand, GimbalMode, GimbalYawFrame};
use skein_domain::{CommandId, Geodetic, NodeTime, Refusal};

/// What the gimbal is to do.
#[derive(Debug, Clone, Copy, PartialEq, Default, Encode, Decode)]
pub(crate) enum Aim {
    /// Nothing.
    #[default]
    #[n(0)]
    Idle,
    /// Look there.
    #[n(1)]
    Angles(#[n(0)] Direction),
    /// Turn.
    #[n(2)]
    Rates(#[n(0)] Rates),
    /// Look at a place while the vehicle moves.
    #[n(3)]
    Place(#[n(0)] Geodetic),
}

/// How fast to turn.
#[derive(Debug, Clone, Copy, PartialEq, Encode, Decode)]
pub(crate) struct Rates {
    /// Upwards, in radians per second.
    #[n(0)]
    pub(crate) pitch_rad_s: f64,
    /// Clockwise, in radians per second.
    #[n(1)]
    pub(crate) yaw_rad_s: f64,
}

/// Where a turn at rates has got to, of a device that is told angles that move.
#[derive(Debug, Clone, Copy, PartialEq, Encode, Decode)]
pub(crate) struct Sweep {
    #[n(0)]
    pub(crate) when: NodeTime,
    #[n(1)]
    pub(crate) direction: Direction,
}

impl Sweep {
    /// Where it is at `now`. A pause longer than this in seconds, as of a restart, is not made up for.
    pub(crate) fn at(&self, now: NodeTime, rates: Rates) -> Direction {
        const PAUSE_MAX_S: f64 = 0.5;
        let dt_s = now.seconds_since(self.when).clamp(0.0, PAUSE_MAX_S);
        let on = |yaw: f64| wrap_angle_rad(yaw + rates.yaw_rad_s * dt_s);
        Direction {
            pitch_rad: self.direction.pitch_rad + rates.pitch_rad_s * dt_s,
            yaw: match self.direction.yaw {
                Yaw::Vehicle(yaw) => Yaw::Vehicle(on(yaw)),
                Yaw::North(yaw) => Yaw::North(on(yaw)),
            },
        }
    }
}

impl Rates {
    /// Stand still.
    pub(crate) const NONE: Self = Self {
        pitch_rad_s: 0.0,
        yaw_rad_s: 0.0,
    };
}

impl Aim {
    /// What a command asks for; `None` if it is about control.
    pub(crate) fn of(command: &GimbalCommand, rate_max_rad_s: f64) -> Result<Option<Self>, Refusal> {
        let finite = |values: &[f64], what: &str| {
            if values.iter().all(|value| value.is_finite()) {
                return Ok(());
            }
            Err(Refusal::invalid(format!("{what} must be finite")))
        };
        Ok(Some(match *command {
            GimbalCommand::Angles {
                pitch_rad,
                yaw_rad,
                yaw_frame,
            } => {
                finite(&[pitch_rad, yaw_rad], "pitch_rad and yaw_rad")?;
                let yaw = match yaw_frame {
                    GimbalYawFrame::Vehicle => Yaw::Vehicle(yaw_rad),
                    GimbalYawFrame::North => Yaw::North(yaw_rad),
                };
                Self::Angles(Direction { pitch_rad, yaw })
            }
            GimbalCommand::Rates { pitch_rad_s, yaw_rad_s } => {
                finite(&[pitch_rad_s, yaw_rad_s], "pitch_rad_s and yaw_rad_s")?;
                let within = |rate: f64| rate.clamp(-rate_max_rad_s, rate_max_rad_s);
                Self::Rates(Rates {
                    pitch_rad_s: within(pitch_rad_s),
                    yaw_rad_s: within(yaw_rad_s),
                })
            }
            GimbalCommand::PointAt { place } => {
                if !place.is_valid() {
                    return Err(Refusal::invalid("place must be a place on Earth"));
                }
                Self::Place(place)
            }
            GimbalCommand::Neutral => Self::Angles(Direction {
                pitch_rad: 0.0,
                yaw: Yaw::Vehicle(0.0),
            }),
            GimbalCommand::TakeControl | GimbalCommand::ReleaseControl => return Ok(None),
        }))
    }

    /// The word of the vocabulary for it.
    pub(crate) fn mode(&self) -> GimbalMode {
        match self {
            Self::Idle => GimbalMode::Idle,
            Self::Angles(_) => GimbalMode::Angles,
            Self::Rates(_) => GimbalMode::Rates,
            Self::Place(_) => GimbalMode::PointAt,
        }
    }
}

/// A command that has not ended yet.
#[derive(Debug, Clone, Copy, PartialEq, Encode, Decode)]
pub(crate) struct Pending {
    #[n(0)]
    pub(crate) id: CommandId,
    #[n(1)]
    pub(crate) begun: NodeTime,
    #[n(2)]
    pub(crate) of: PendingOf,
}

/// What a command that has not ended yet waits for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Encode, Decode)]
#[cbor(index_only)]
pub(crate) enum PendingOf {
    /// That the gimbal looks where it is to look, or turns.
    #[n(0)]
    Aim,
    /// That control is ours.
    #[n(1)]
    Take,
    /// That control is given back.
    #[n(2)]
    Release,
}
