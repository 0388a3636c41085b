//! `[video]`: what is kept of the videos of cameras, where they are sent, and what makes these values wrong.
//!
//! Must never do: look whether anybody receives at an address.

use crate::problem::Problem;
use serde::{Deserialize, Deserializer, Serialize};
use std::net::{Ipv4Addr, SocketAddr};
use std::path::PathBuf;

/// `[video]`
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct VideoSettings {
    /// Folder that videos are recorded into. By default `recordings` beside the configuration file; without one none are recorded.
    pub recordings: Option<PathBuf>,
    /// When its recordings take more, the oldest are removed, in bytes.
    pub keep_bytes: u64,
    /// Cameras that are sent as RTP.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub rtp: Vec<RtpSettings>,
}

impl Default for VideoSettings {
    fn default() -> Self {
        Self {
            recordings: None,
            keep_bytes: 8_000_000_000,
            rtp: Vec::new(),
        }
    }
}

/// `[[video.rtp]]`
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RtpSettings {
    /// Id of the vehicle, of this node or of another one of the swarm.
    pub vehicle: u16,
    /// The camera's name there.
    pub camera: String,
    /// Where it is sent to.
    #[serde(deserialize_with = "address")]
    pub to: SocketAddr,
    /// How large the pictures are.
    #[serde(default)]
    pub quality: RtpQuality,
}

/// How large the pictures are that are sent as RTP.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RtpQuality {
    /// As the camera gives them.
    #[default]
    Main,
    /// At most 320x240 and 10/s.
    Sub,
}

fn address<'de, D: Deserializer<'de>>(from: D) -> Result<SocketAddr, D::Error> {
    let text = String::deserialize(from)?;
    let wrong = |_| {
        serde::de::Error::custom(format!(
            "{text:?} is no address with a port, as \"192.168.1.5:5600\" is one"
        ))
    };
    text.parse().map_err(wrong)
}

impl VideoSettings {
    /// Everything that is wrong with it.
    pub(crate) fn problems(&self, problems: &mut Vec<Problem>) {
        for (at, rtp) in self.rtp.iter().enumerate() {
            let mut wrong = |key: &str, message: &str| {
                problems.push(Problem {
                    key: format!("video.rtp[{at}].{key}"),
                    message: message.into(),
                });
            };
            if rtp.camera.is_empty() {
                wrong("camera", "name the payload as `adopt.payloads` does");
            }
            if rtp.to.port() == 0 {
                wrong("to", "has port 0, at which nobody listens");
            }
            if rtp.to.ip().is_unspecified() || rtp.to.ip() == Ipv4Addr::BROADCAST {
                wrong("to", "name one host, or a multicast group");
            }
            if self.rtp.iter().take(at).any(|earlier| earlier.to == rtp.to) {
                wrong("to", "is there twice: a player takes two streams at one port for one");
            }
        }
    }
}

#[cfg(test)]
mod tests;
