//! The fences of a configuration: the polygon of `[safety.fence]`, the zones of `[[safety.zones]]`, and those of the files it names,
//! as one plan. A file is taken whole or not at all.
//!
//! Must never do: guess what a file means that says it wrongly.

mod geojson_file;
mod plan_file;

pub use geojson_file::to_geojson;

use crate::problem::Problem;
use crate::settings::NodeConfig;
use skein_domain::{
    AltitudeReference, BreachAction, FencePlan, FenceZone, Geodetic, MapPoint, SwarmFrame, ZoneKind, ZoneOutline,
};
use skein_safety::{FencePlanError, Fences};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Larger files are not read, in bytes.
const MAX_FILE_BYTES: u64 = 16 * 1024 * 1024;
/// Name of the zone that `[safety.fence]` makes.
const CONFIGURED_FENCE: &str = "fence";

/// What a file said, and what of it was left out.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ImportedFences {
    /// The zones.
    pub plan: FencePlan,
    /// What an operator should know: parts of the file that mean nothing here.
    pub notes: Vec<String>,
}

/// Why the fences of a configuration or of a file cannot be used.
#[derive(Debug, Error)]
pub enum FenceFileError {
    /// The file could not be read.
    #[error("cannot read the fence file {}: {source}", file.display())]
    Unreadable {
        /// Which file.
        file: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The file is too large to be one.
    #[error("the fence file {} has {bytes} bytes, more than {MAX_FILE_BYTES}", file.display())]
    TooLarge {
        /// Which file.
        file: PathBuf,
        /// How large it is.
        bytes: u64,
    },
    /// It is neither GeoJSON nor a plan, or not even JSON.
    #[error("the fence file {} does not parse: {message}", file.display())]
    Unparsable {
        /// Which file.
        file: PathBuf,
        /// The parser's message.
        message: String,
    },
    /// A part of it is wrong.
    #[error("the fence file {}: {part}: {fault}", file.display())]
    Wrong {
        /// Which file.
        file: PathBuf,
        /// Which part, for example `feature 3` (from 0) or `geoFence.circles[1]`.
        part: String,
        /// What is wrong with it.
        fault: FenceFault,
    },
    /// The zones cannot be placed in the swarm's frame.
    #[error("{0}")]
    Zones(#[from] FencePlanError),
}

/// What is wrong with a part of a fence file.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum FenceFault {
    /// A feature without a geometry.
    #[error("it has no geometry")]
    NoGeometry,
    /// A geometry that encloses nothing.
    #[error("a {geometry} is no zone: Polygon, MultiPolygon, or Point with \"radius_m\"")]
    Geometry {
        /// What it is.
        geometry: String,
    },
    /// A polygon without a ring.
    #[error("the polygon has no ring")]
    NoRing,
    /// An exclusion with a hole: whether flying in the hole is allowed is not for an exclusion to say.
    #[error("an exclusion cannot have holes")]
    HoleInExclusion,
    /// A value is missing.
    #[error("\"{key}\" is missing")]
    Missing {
        /// Its key.
        key: &'static str,
    },
    /// A value is not what it must be.
    #[error("\"{key}\" is {found}, it must be {expected}")]
    Value {
        /// Its key.
        key: &'static str,
        /// What stands there.
        found: String,
        /// What would be right.
        expected: &'static str,
    },
    /// The zone makes no sense.
    #[error("{0}")]
    Zone(#[from] FencePlanError),
}

impl NodeConfig {
    /// All zones, those of the files included, with notes on what was left out of files.
    ///
    /// # Errors
    /// When a file cannot be read or is wrong.
    pub fn fence_plan(&self) -> Result<ImportedFences, FenceFileError> {
        let mut all = ImportedFences::default();
        if let Some(fence) = &self.safety.fence {
            all.plan.zones.push(FenceZone {
                name: CONFIGURED_FENCE.to_owned(),
                kind: ZoneKind::Inclusion,
                outline: ZoneOutline::LocalPolygon {
                    corners_m: fence.polygon_m.clone(),
                },
                floor_m: Some(fence.floor_m),
                ceiling_m: Some(fence.ceiling_m),
                altitude_reference: AltitudeReference::Origin,
                action: BreachAction::Hold,
            });
        }
        all.plan.zones.extend(self.safety.zones.iter().cloned());
        for file in &self.safety.fence_files {
            let imported = read_fence_file(file)?;
            all.plan.zones.extend(imported.plan.zones);
            all.plan.breach_return = imported.plan.breach_return.or(all.plan.breach_return);
            let named = |note: String| format!("{}: {note}", file.display());
            all.notes.extend(imported.notes.into_iter().map(named));
        }
        Ok(all)
    }

    /// The zones in the swarm's frame.
    ///
    /// # Errors
    /// When a file cannot be read or is wrong, or a zone cannot be placed.
    pub fn fences(&self) -> Result<Fences, FenceFileError> {
        let frame = self.swarm.origin.map(SwarmFrame::new);
        Ok(Fences::from_plan(&self.fence_plan()?.plan, frame.as_ref())?)
    }

    /// What is wrong with the fences that can be seen without reading a file.
    pub(crate) fn fence_problems(&self, problems: &mut Vec<Problem>) {
        let mut problem = |key: String, message: String| problems.push(Problem { key, message });
        let plan = FencePlan {
            zones: self.safety.zones.clone(),
            breach_return: None,
        };
        let needs_origin = plan.needs_origin() || !self.safety.fence_files.is_empty();
        if needs_origin && self.swarm.origin.is_none() {
            let key = if plan.needs_origin() {
                "safety.zones"
            } else {
                "safety.fence_files"
            };
            let message = "zones on the map, and heights above the sea, need swarm.origin to be given";
            problem(key.to_owned(), message.to_owned());
            return;
        }
        let frame = self.swarm.origin.filter(Geodetic::is_valid).map(SwarmFrame::new);
        for (i, zone) in self.safety.zones.iter().enumerate() {
            let alone = FencePlan {
                zones: vec![zone.clone()],
                breach_return: None,
            };
            if let Err(error) = Fences::from_plan(&alone, frame.as_ref()) {
                problem(format!("safety.zones[{i}]"), reason(&error));
            }
        }
    }
}

/// Reads a GeoJSON file or a `.plan` of QGroundControl; which of them it is, its content says.
///
/// # Errors
/// When it cannot be read or any part of it is wrong.
pub fn read_fence_file(file: &Path) -> Result<ImportedFences, FenceFileError> {
    let unreadable = |source| FenceFileError::Unreadable {
        file: file.to_owned(),
        source,
    };
    let bytes = std::fs::metadata(file).map_err(unreadable)?.len();
    if bytes > MAX_FILE_BYTES {
        return Err(FenceFileError::TooLarge {
            file: file.to_owned(),
            bytes,
        });
    }
    parse_fences(&std::fs::read_to_string(file).map_err(unreadable)?, file)
}

/// The same from a text; `file` is what errors and nameless zones are named after.
///
/// # Errors
/// As [`read_fence_file`], but for reading.
pub fn parse_fences(text: &str, file: &Path) -> Result<ImportedFences, FenceFileError> {
    let unparsable = |message: String| FenceFileError::Unparsable {
        file: file.to_owned(),
        message,
    };
    let value: serde_json::Value = serde_json::from_str(text).map_err(|e| unparsable(e.to_string()))?;
    let stem = file.file_stem().map_or_else(|| "zone".into(), |s| s.to_string_lossy());
    let imported = if value.get("fileType").is_some() || value.get("geoFence").is_some() {
        plan_file::parse(&value, &stem)
    } else {
        geojson_file::parse(value, &stem)
    };
    imported.map_err(|refused| match refused {
        Refused::NotThat(message) => unparsable(message),
        Refused::Part(part, fault) => FenceFileError::Wrong {
            file: file.to_owned(),
            part,
            fault,
        },
    })
}

/// Why a text was refused; the file is added where it is known.
enum Refused {
    /// It is not of the format at all.
    NotThat(String),
    /// A part of it is wrong.
    Part(String, FenceFault),
}

/// Whether a zone is one, seen from itself: whether it is near to the swarm is judged later.
fn checked(zone: FenceZone) -> Result<FenceZone, FenceFault> {
    let origin = match &zone.outline {
        ZoneOutline::Polygon { corners } => corners.first().copied(),
        ZoneOutline::Circle { centre, .. } => Some(*centre),
        ZoneOutline::LocalPolygon { .. } | ZoneOutline::LocalCircle { .. } => None,
    };
    let frame = origin.filter(MapPoint::is_valid).map(|p| {
        SwarmFrame::new(Geodetic {
            latitude_deg: p.latitude_deg,
            longitude_deg: p.longitude_deg,
            altitude_amsl_m: 0.0,
        })
    });
    let alone = FencePlan {
        zones: vec![zone],
        breach_return: None,
    };
    // A zone whose first corner is no place has no frame, but is found out before it needs one.
    Fences::from_plan(&alone, frame.as_ref())?;
    alone.zones.into_iter().next().ok_or(FenceFault::NoGeometry)
}

/// What is wrong, without the place in a list of one.
fn reason(error: &FencePlanError) -> String {
    match error {
        FencePlanError::Zone { source, .. } => source.to_string(),
        FencePlanError::Outline { source, .. } => source.to_string(),
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests;
