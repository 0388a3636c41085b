//! Where vehicles flew, as tracks for maps: one for each vehicle, with time and altitude above the sea.
//!
//! Must never do: draw a line through a place that was not told.

mod gpx;
mod kml;
mod spool;

use crate::told::{Kind, each};
use crate::{ExportError, Exported, Progress, target};
use skein_domain::{Geodetic, VehicleId};
use skein_recording::{Recording, Topic};
use spool::Spool;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::fs::File;
use std::io::{self, BufWriter};
use std::path::Path;

/// A point of a track.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Point {
    at_ns: u64,
    place: Geodetic,
}

/// A vehicle, and its track, which waits in a file of its own: tracks come one after the other, points of all vehicles at once.
struct Track {
    name: String,
    spool: Spool,
}

/// The vehicles in order of their ids.
type Tracks = BTreeMap<VehicleId, Track>;

/// How a format writes.
type Whole = fn(BufWriter<File>, Tracks, &Recording) -> io::Result<BufWriter<File>>;

/// For maps on a globe.
pub fn kml(recording: &Recording, out: &Path, progress: Progress<'_>) -> Result<Exported, ExportError> {
    write(recording, out, progress, kml::SHAPE, kml::whole)
}

/// For maps.
pub fn gpx(recording: &Recording, out: &Path, progress: Progress<'_>) -> Result<Exported, ExportError> {
    write(recording, out, progress, gpx::SHAPE, gpx::whole)
}

fn write(
    recording: &Recording,
    out: &Path,
    progress: Progress<'_>,
    shape: spool::Shape,
    whole: Whole,
) -> Result<Exported, ExportError> {
    let file = target::file(out)?;
    let failed = |error: io::Error| ExportError::write(out, error);
    let (mut tracks, mut names) = (Tracks::new(), BTreeMap::new());
    let mut exported = Exported::default();
    let wants = |topic: &Topic| matches!(topic, Topic::Telemetry(_) | Topic::Fleet);
    let unread = each(recording, wants, progress, |told| {
        match &told.kind {
            Kind::Fleet(fleet) => {
                let named = fleet.vehicles.iter().map(|of| (of.id, of.name.clone()));
                names.extend(named);
            }
            Kind::Telemetry(telemetry) => {
                let Some(place) = telemetry.global.filter(Geodetic::is_valid) else {
                    return Ok(());
                };
                let track = match tracks.entry(telemetry.vehicle) {
                    Entry::Occupied(track) => track.into_mut(),
                    Entry::Vacant(place) => {
                        let spool = Spool::new(shape).map_err(failed)?;
                        place.insert(Track {
                            name: String::new(),
                            spool,
                        })
                    }
                };
                let at_ns = told.at_ns;
                track.spool.add(Point { at_ns, place }).map_err(failed)?;
                exported.count(&format!("vehicle {}", telemetry.vehicle));
            }
            Kind::Setpoint(_) | Kind::Event(_) => {}
        }
        Ok::<_, ExportError>(())
    })?;
    for (vehicle, track) in &mut tracks {
        let named = names.get(vehicle).filter(|name| !name.is_empty());
        track.name = named.cloned().unwrap_or_else(|| format!("vehicle {vehicle}"));
    }
    let file = whole(file, tracks, recording).map_err(failed)?;
    target::finish(out, file)?;
    exported.files.push(out.to_owned());
    Ok(exported.without(unread))
}
