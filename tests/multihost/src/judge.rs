//! Whether a flight went well, by what the simulators of all hosts wrote down.
//!
//! Must never do: believe a node.

use skein_domain::{FormationRequest, PositionNed, Shape};
use skein_flight::formation::slots;
use skein_sim::truth_lines::{TruthLine, VehicleLine};
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

/// What one simulator wrote.
#[derive(Debug)]
pub struct Track {
    host: u8,
    file: PathBuf,
    /// How much of the file is read.
    read: u64,
    samples: Vec<(f64, VehicleLine)>,
}

/// Where two vehicles were nearest to each other.
#[derive(Debug, Clone, PartialEq)]
pub struct Nearest {
    /// Their distance in metres.
    pub distance_m: f64,
    /// When, in seconds since 1970.
    pub time_s: f64,
    /// The two.
    pub hosts: (u8, u8),
    /// Where they were.
    pub places: (PositionNed, PositionNed),
}

impl Track {
    /// Of the vehicle of this host; nothing read yet.
    #[must_use]
    pub fn new(host: u8, file: PathBuf) -> Self {
        Self {
            host,
            file,
            read: 0,
            samples: Vec::new(),
        }
    }

    /// The file.
    #[must_use]
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// Whose it is.
    #[must_use]
    pub fn host(&self) -> u8 {
        self.host
    }

    /// Where the vehicle is, as far as is read.
    #[must_use]
    pub fn last(&self) -> Option<&VehicleLine> {
        self.samples.last().map(|(_, line)| line)
    }

    /// Takes in what was written since.
    pub fn read_on(&mut self) {
        let Ok(mut file) = File::open(&self.file) else { return };
        let mut text = String::new();
        let read = file
            .seek(SeekFrom::Start(self.read))
            .and_then(|_| file.read_to_string(&mut text));
        if read.is_err() {
            return;
        }
        // a line that is not written to its end is read the next time
        let whole = text.rfind('\n').map_or(0, |end| end + 1);
        self.read += whole as u64;
        for line in text.get(..whole).unwrap_or_default().lines() {
            self.add(line);
        }
    }

    fn add(&mut self, line: &str) {
        let line: TruthLine = serde_json::from_str(line).expect("the simulator writes truth");
        if let Some(vehicle) = line.vehicles.into_iter().next_back() {
            self.samples.push((line.time_s, vehicle));
        }
    }

    /// Where it was at a moment between two lines.
    fn at(&self, time_s: f64) -> Option<(PositionNed, bool)> {
        let after = self.samples.partition_point(|(t, _)| *t < time_s);
        let (before_s, before) = self.samples.get(after.checked_sub(1)?)?;
        let (after_s, after) = self.samples.get(after)?;
        let share = (time_s - before_s) / (after_s - before_s).max(1e-9);
        let way = after.position.vector() - before.position.vector();
        let stands = before.touches_ground && after.touches_ground;
        Some((before.position.moved(way * share), stands))
    }

    /// The longest time without a setpoint that its autopilot saw in OFFBOARD, in seconds, and when, apart from these times.
    #[must_use]
    pub fn longest_gap(&self, excused: &[(f64, Option<f64>)]) -> (f64, f64) {
        let counts = |time_s: f64| {
            let is_in =
                |(from, until): &(f64, Option<f64>)| time_s >= *from && until.is_none_or(|until| time_s <= until);
            !excused.iter().any(is_in)
        };
        let counted = self.samples.iter().filter(|(time_s, _)| counts(*time_s));
        let gaps = counted.map(|(time_s, line)| (line.setpoint_gap_s, *time_s));
        gaps.fold((0.0, 0.0), |worst, one| if one.0 > worst.0 { one } else { worst })
    }

    /// How far it was beyond a square about the origin at most, in metres; 0 if it never was.
    #[must_use]
    pub fn outside_m(&self, half_side_m: f64) -> f64 {
        let beyond = |p: &PositionNed| p.north_m.abs().max(p.east_m.abs()) - half_side_m;
        self.samples
            .iter()
            .map(|(_, v)| beyond(&v.position))
            .fold(0.0, f64::max)
    }

    /// Whether it stands on the ground with its motors off.
    #[must_use]
    pub fn is_down(&self) -> bool {
        self.last().is_some_and(|v| v.touches_ground && !v.armed)
    }
}

/// Where any two vehicles, of which one at least was in the air, were nearest.
#[must_use]
pub fn nearest<'a>(tracks: impl Iterator<Item = &'a Track>) -> Option<Nearest> {
    let tracks: Vec<&Track> = tracks.collect();
    let mut nearest: Option<Nearest> = None;
    for (i, a) in tracks.iter().enumerate() {
        for b in tracks.iter().skip(i + 1) {
            for (time_s, at) in &a.samples {
                let Some((other, stands)) = b.at(*time_s) else { continue };
                if at.touches_ground && stands {
                    continue;
                }
                let distance_m = at.position.distance_m(&other);
                if nearest.as_ref().is_none_or(|n| distance_m < n.distance_m) {
                    nearest = Some(Nearest {
                        distance_m,
                        time_s: *time_s,
                        hosts: (a.host, b.host),
                        places: (at.position, other),
                    });
                }
            }
        }
    }
    nearest
}

/// How far these vehicles are from having this shape, whoever has which place and wherever it points: the greatest difference between
/// the distances of any two of them and those of its places, each in order, in metres.
#[must_use]
pub fn shape_error_m(places: &[PositionNed], shape: Shape, spacing_m: f64) -> f64 {
    let Ok(wanted) = slots(&FormationRequest::new(shape, spacing_m), places.len()) else {
        return f64::INFINITY;
    };
    let wanted: Vec<PositionNed> = wanted
        .iter()
        .map(|slot| PositionNed::default().moved(slot.rotated(0.0)))
        .collect();
    let (is, wanted) = (distances(places), distances(&wanted));
    if is.len() != wanted.len() {
        return f64::INFINITY;
    }
    is.iter().zip(wanted).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

fn distances(places: &[PositionNed]) -> Vec<f64> {
    let pairs = places.iter().enumerate();
    let mut all: Vec<f64> = pairs
        .flat_map(|(i, a)| places.iter().skip(i + 1).map(move |b| a.distance_m(b)))
        .collect();
    all.sort_by(f64::total_cmp);
    all
}

#[cfg(test)]
mod tests;
