//! A camera: pictures, recordings, zoom, modes, a stream, and a storage that fills up.
//!
//! Must never do: record or take a picture onto a full storage.

/// How a camera is built.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraSettings {
    /// Width of its pictures in pixels.
    pub width_px: u16,
    /// Height of its pictures in pixels.
    pub height_px: u16,
    /// Horizontal field of view at its widest in radians.
    pub field_of_view_rad: f64,
    /// Strongest zoom; 1 is none.
    pub zoom_max: f64,
    /// Size of its storage in mebibytes.
    pub storage_mib: f64,
    /// What is on the storage at the start in mebibytes.
    pub storage_used_mib: f64,
    /// Size of one picture in mebibytes.
    pub picture_mib: f64,
    /// What a recording takes in mebibytes per second.
    pub recording_mib_s: f64,
    /// Shortest time between two pictures in seconds.
    pub picture_interval_min_s: f64,
}

impl Default for CameraSettings {
    fn default() -> Self {
        Self {
            width_px: 1280,
            height_px: 720,
            field_of_view_rad: 70_f64.to_radians(),
            zoom_max: 6.0,
            storage_mib: 4096.0,
            storage_used_mib: 0.0,
            picture_mib: 6.0,
            recording_mib_s: 2.5,
            picture_interval_min_s: 0.5,
        }
    }
}

/// Width of the sensor in millimetres; with the field of view it gives the focal length.
pub const SENSOR_WIDTH_MM: f64 = 6.17;
/// One step of zoom, and the fastest continuous zoom per second, as shares of the range in percent.
const ZOOM_STEP: f64 = 10.0;
const ZOOM_RATE_MAX: f64 = 40.0;
/// How fast the lens turns to a zoom that was asked for, in percent of the range per second.
const ZOOM_TURN: f64 = 80.0;

/// What came of a command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// Done, or begun.
    Accepted,
    /// Not now.
    Rejected,
    /// Not like this.
    Denied,
    /// It was tried.
    Failed,
}

/// A picture that was taken or should have been.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Picture {
    /// Its number from zero; -1 if it failed.
    pub index: i32,
    /// Whether it is on the storage.
    pub taken: bool,
}

/// Pictures at an interval.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Series {
    interval_s: f64,
    next_s: f64,
    /// None: until told to stop.
    left: Option<u32>,
}

/// How zoom is asked for, as MAVLink numbers the ways.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ZoomAsk {
    /// Steps, in or out.
    Step(f64),
    /// Rate from -1 to 1; 0 stops.
    Continuous(f64),
    /// Percent of the range.
    Range(f64),
    /// Focal length in millimetres.
    FocalLength(f64),
    /// Horizontal field of view in degrees.
    FieldOfView(f64),
}

/// A camera.
#[derive(Debug, Clone, PartialEq)]
pub struct Camera {
    /// How it is built.
    pub settings: CameraSettings,
    /// Mode as MAVLink numbers it: 0 pictures, 1 video, 2 survey.
    pub mode: u8,
    /// Pictures taken.
    pub pictures: i32,
    /// The stream runs.
    pub streaming: bool,
    zoom_percent: f64,
    zoom_goal_percent: f64,
    zoom_rate: f64,
    used_mib: f64,
    series: Option<Series>,
    recording_since_s: Option<f64>,
    last_sequence: u32,
    /// Pictures that nobody was told of yet.
    taken: Vec<Picture>,
}

impl Camera {
    /// Switched on: at its widest, idle.
    pub fn new(settings: CameraSettings) -> Self {
        Self {
            settings,
            mode: 0,
            pictures: 0,
            streaming: false,
            zoom_percent: 0.0,
            zoom_goal_percent: 0.0,
            zoom_rate: 0.0,
            used_mib: settings.storage_used_mib.clamp(0.0, settings.storage_mib),
            series: None,
            recording_since_s: None,
            last_sequence: 0,
            taken: Vec::new(),
        }
    }

    /// Lets `dt_s` pass up to `now_s`.
    pub fn step(&mut self, now_s: f64, dt_s: f64) {
        self.turn_lens(dt_s);
        if self.recording_since_s.is_some() {
            self.used_mib += self.settings.recording_mib_s * dt_s;
            if self.used_mib >= self.settings.storage_mib {
                self.used_mib = self.settings.storage_mib;
                self.recording_since_s = None;
            }
        }
        if let Some(mut series) = self.series.filter(|series| now_s >= series.next_s) {
            series.next_s = (series.next_s + series.interval_s).max(now_s);
            series.left = series.left.map(|left| left.saturating_sub(1));
            let taken = self.take();
            self.series = (taken && series.left != Some(0)).then_some(series);
        }
    }

    fn turn_lens(&mut self, dt_s: f64) {
        if self.zoom_rate != 0.0 {
            self.zoom_goal_percent = (self.zoom_goal_percent + self.zoom_rate * ZOOM_RATE_MAX * dt_s).clamp(0.0, 100.0);
        }
        let way = self.zoom_goal_percent - self.zoom_percent;
        self.zoom_percent += way.clamp(-ZOOM_TURN * dt_s, ZOOM_TURN * dt_s);
    }

    fn take(&mut self) -> bool {
        let room = self.used_mib + self.settings.picture_mib <= self.settings.storage_mib;
        let index = if room { self.pictures } else { -1 };
        if room {
            self.used_mib += self.settings.picture_mib;
            self.pictures += 1;
        }
        self.taken.push(Picture { index, taken: room });
        room
    }

    /// Takes pictures: so many (0: until told to stop) at an interval. A single one with a number is taken once, however often it
    /// is asked for.
    pub fn start_pictures(&mut self, now_s: f64, interval_s: f64, count: f64, sequence: f64) -> Outcome {
        if !(count.is_finite() && count >= 0.0) || interval_s < 0.0 {
            return Outcome::Denied;
        }
        let (count, sequence) = (count as u32, sequence as u32);
        if count == 1 && sequence > 0 && sequence == self.last_sequence {
            return Outcome::Accepted;
        }
        if self.series.is_some() {
            return Outcome::Rejected;
        }
        if self.available_mib() < self.settings.picture_mib {
            return Outcome::Failed;
        }
        self.last_sequence = sequence;
        self.series = Some(Series {
            interval_s: interval_s.max(self.settings.picture_interval_min_s),
            next_s: now_s,
            left: (count > 0).then_some(count),
        });
        Outcome::Accepted
    }

    /// Takes no more pictures.
    pub fn stop_pictures(&mut self) -> Outcome {
        self.series = None;
        Outcome::Accepted
    }

    /// Records.
    pub fn start_recording(&mut self, now_s: f64) -> Outcome {
        if self.available_mib() <= 0.0 {
            return Outcome::Failed;
        }
        self.recording_since_s.get_or_insert(now_s);
        Outcome::Accepted
    }

    /// Records no more.
    pub fn stop_recording(&mut self) -> Outcome {
        self.recording_since_s = None;
        Outcome::Accepted
    }

    /// Changes the mode; not while it records.
    pub fn set_mode(&mut self, mode: f64) -> Outcome {
        if ![0.0, 1.0, 2.0].contains(&mode) {
            return Outcome::Denied;
        }
        if self.recording_since_s.is_some() {
            return Outcome::Rejected;
        }
        self.mode = mode as u8;
        Outcome::Accepted
    }

    /// Zooms.
    pub fn zoom(&mut self, ask: ZoomAsk) -> Outcome {
        let factor_percent = |factor: f64| (factor - 1.0) / (self.settings.zoom_max - 1.0).max(1e-6) * 100.0;
        let goal = match ask {
            ZoomAsk::Step(steps) => self.zoom_goal_percent + ZOOM_STEP * steps,
            ZoomAsk::Continuous(rate) if rate.is_finite() => {
                self.zoom_rate = rate.clamp(-1.0, 1.0);
                return Outcome::Accepted;
            }
            ZoomAsk::Range(percent) if (0.0..=100.0).contains(&percent) => percent,
            ZoomAsk::FocalLength(focal_mm) if focal_mm > 0.0 => factor_percent(focal_mm / self.widest_focal_mm()),
            ZoomAsk::FieldOfView(degrees) if degrees > 0.0 && degrees < 180.0 => {
                let half = 0.5 * self.settings.field_of_view_rad;
                factor_percent(half.tan() / (0.5 * degrees.to_radians()).tan())
            }
            _ => return Outcome::Denied,
        };
        if !goal.is_finite() {
            return Outcome::Denied;
        }
        self.zoom_rate = 0.0;
        self.zoom_goal_percent = goal.clamp(0.0, 100.0);
        Outcome::Accepted
    }

    /// Empties the storage, or forgets the numbers of its pictures only.
    pub fn format(&mut self, storage: f64, format: bool, reset_log: bool) -> Outcome {
        if ![0.0, 1.0].contains(&storage) {
            return Outcome::Denied;
        }
        if self.series.is_some() || self.recording_since_s.is_some() {
            return Outcome::Rejected;
        }
        if format {
            self.used_mib = 0.0;
        }
        if format || reset_log {
            self.pictures = 0;
        }
        Outcome::Accepted
    }

    /// As it was when it was switched on; what is on the storage stays.
    pub fn reset_settings(&mut self) -> Outcome {
        if self.recording_since_s.is_some() {
            return Outcome::Rejected;
        }
        (self.mode, self.zoom_goal_percent, self.zoom_rate) = (0, 0.0, 0.0);
        Outcome::Accepted
    }

    /// Pictures since the last call.
    pub fn take_pictures(&mut self) -> Vec<Picture> {
        std::mem::take(&mut self.taken)
    }

    /// The interval of pictures being taken, in seconds.
    pub fn interval_s(&self) -> Option<f64> {
        self.series.map(|series| series.interval_s)
    }

    /// For how long it records, in seconds.
    pub fn recording_s(&self, now_s: f64) -> Option<f64> {
        self.recording_since_s.map(|since_s| now_s - since_s)
    }

    /// Zoom in percent of the range.
    pub fn zoom_percent(&self) -> f64 {
        self.zoom_percent
    }

    /// Zoom as a factor, 1 being the widest.
    pub fn zoom_factor(&self) -> f64 {
        1.0 + self.zoom_percent / 100.0 * (self.settings.zoom_max - 1.0)
    }

    /// Horizontal field of view in radians.
    pub fn field_of_view_rad(&self) -> f64 {
        2.0 * ((0.5 * self.settings.field_of_view_rad).tan() / self.zoom_factor()).atan()
    }

    /// Focal length in millimetres.
    pub fn focal_length_mm(&self) -> f64 {
        self.widest_focal_mm() * self.zoom_factor()
    }

    fn widest_focal_mm(&self) -> f64 {
        0.5 * SENSOR_WIDTH_MM / (0.5 * self.settings.field_of_view_rad).tan()
    }

    /// Room left on the storage in mebibytes.
    pub fn available_mib(&self) -> f64 {
        self.settings.storage_mib - self.used_mib
    }

    /// What is on the storage in mebibytes.
    pub fn used_mib(&self) -> f64 {
        self.used_mib
    }
}

#[cfg(test)]
mod tests;
