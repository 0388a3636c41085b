//! Telemetry logs as ground stations keep them: MAVLink 2 frames, each with its time before it, a file for each vehicle. They are made of what
//! was recorded; the frames that once came over the air are not.
//!
//! Must never do: fill in what was not recorded; fields that MAVLink has a word for "unknown" for get that.

mod frames;

use crate::told::{Kind, Told, each};
use crate::{ExportError, Exported, Progress, target};
use mavlink::dialects::common::HEARTBEAT_DATA;
use mavlink::{MAVLinkV2MessageRaw, MavHeader, MessageData};
use skein_domain::VehicleId;
use skein_recording::{Recording, Topic, VehicleTelemetry};
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::fs::File;
use std::io::{BufWriter, Write as _};
use std::path::{Path, PathBuf};

/// Component id of an autopilot.
const AUTOPILOT: u8 = 1;
/// What changes seldom is told once in so many nanoseconds, as vehicles themselves do.
const SELDOM_NS: u64 = 950_000_000;

/// Writes a recording as logs.
pub fn write(recording: &Recording, out: &Path, progress: Progress<'_>) -> Result<Exported, ExportError> {
    let folder = target::folder(out)?;
    let base = recording.header().base;
    let begin_ns = base.unix_ns(recording.span().0);
    let mut logs = Logs {
        folder,
        begin_ns,
        open: BTreeMap::new(),
        system_ids: BTreeMap::new(),
        exported: Exported::default(),
    };
    let wants = |topic: &Topic| {
        matches!(
            topic,
            Topic::Telemetry(_) | Topic::Setpoint(_) | Topic::Events | Topic::Fleet
        )
    };
    let unread = each(recording, wants, progress, |told| logs.take(told))?;
    let Logs { open, mut exported, .. } = logs;
    for log in open.into_values() {
        target::finish(&log.path, log.file)?;
        exported.files.push(log.path);
    }
    Ok(exported.without(unread))
}

struct Logs {
    folder: PathBuf,
    begin_ns: u64,
    open: BTreeMap<VehicleId, Log>,
    system_ids: BTreeMap<VehicleId, u8>,
    exported: Exported,
}

/// The log of one vehicle.
struct Log {
    path: PathBuf,
    file: BufWriter<File>,
    header: MavHeader,
    begin_ns: u64,
    /// When what changes seldom was told last.
    seldom_ns: Option<u64>,
    /// The heartbeat that was told last: mode, armed or not.
    heartbeat: Option<HEARTBEAT_DATA>,
    texts: u16,
    frames: u64,
}

impl Logs {
    fn take(&mut self, told: &Told) -> Result<(), ExportError> {
        let vehicle = match &told.kind {
            Kind::Fleet(fleet) => {
                let ids = fleet.vehicles.iter().map(|vehicle| (vehicle.id, vehicle.system_id.0));
                self.system_ids.extend(ids);
                return Ok(());
            }
            Kind::Telemetry(telemetry) => Some(telemetry.vehicle),
            Kind::Setpoint(setpoint) => Some(setpoint.vehicle),
            Kind::Event(event) => event.vehicle,
        };
        // What is of no vehicle has no place in the log of one.
        let Some(vehicle) = vehicle else {
            return Ok(());
        };
        let log = self.log(vehicle)?;
        let before = log.frames;
        match &told.kind {
            Kind::Telemetry(telemetry) => log.telemetry(told, telemetry)?,
            Kind::Setpoint(setpoint) => {
                if let Some(flown) = &setpoint.flown {
                    log.add(told.at_ns, &frames::target(log.up_ms(told.at_ns), flown))?;
                }
            }
            Kind::Event(event) => {
                log.texts = log.texts.wrapping_add(1).max(1);
                for text in frames::texts(event, log.texts) {
                    log.add(told.at_ns, &text)?;
                }
            }
            Kind::Fleet(_) => {}
        }
        let added = log.frames - before;
        *self.exported.counts.entry(format!("vehicle {vehicle}")).or_default() += added;
        Ok(())
    }

    fn log(&mut self, vehicle: VehicleId) -> Result<&mut Log, ExportError> {
        match self.open.entry(vehicle) {
            Entry::Occupied(open) => Ok(open.into_mut()),
            Entry::Vacant(place) => {
                let path = self.folder.join(format!("vehicle-{vehicle}.tlog"));
                let known = self.system_ids.get(&vehicle).copied();
                // Of one without a picture of the fleet the id, as far as MAVLink counts.
                let system_id = known.unwrap_or_else(|| u8::try_from(vehicle.0).unwrap_or(u8::MAX).max(1));
                Ok(place.insert(Log {
                    file: target::file(&path)?,
                    path,
                    header: MavHeader {
                        system_id: system_id.into(),
                        component_id: AUTOPILOT,
                        sequence: 0,
                    },
                    begin_ns: self.begin_ns,
                    seldom_ns: None,
                    heartbeat: None,
                    texts: 0,
                    frames: 0,
                }))
            }
        }
    }
}

impl Log {
    /// Milliseconds since the recording began: when the vehicle was switched on is not recorded.
    fn up_ms(&self, at_ns: u64) -> u32 {
        u32::try_from(at_ns.saturating_sub(self.begin_ns) / 1_000_000).unwrap_or(u32::MAX)
    }

    fn telemetry(&mut self, told: &Told, of: &VehicleTelemetry) -> Result<(), ExportError> {
        let (at_ns, up_ms) = (told.at_ns, self.up_ms(told.at_ns));
        let heartbeat = frames::heartbeat(of);
        let is_due = self
            .seldom_ns
            .is_none_or(|last| at_ns.saturating_sub(last) >= SELDOM_NS);
        // What changed just before the end would else not be in the log: that the vehicle was disarmed, most of all.
        if is_due || self.heartbeat.as_ref() != Some(&heartbeat) {
            self.add(at_ns, &heartbeat)?;
            self.heartbeat = Some(heartbeat);
        }
        if is_due {
            self.seldom_ns = Some(at_ns);
            self.add(at_ns, &frames::system_status(of))?;
            self.add(at_ns, &frames::satellites(u64::from(up_ms) * 1_000, of))?;
        }
        self.add(at_ns, &frames::attitude(up_ms, of))?;
        if let Some(moves) = &of.kinematics {
            self.add(at_ns, &frames::local(up_ms, moves))?;
        }
        if let Some(global) = &of.global {
            self.add(at_ns, &frames::global(up_ms, global, of))?;
        }
        Ok(())
    }

    fn add<D: MessageData>(&mut self, at_ns: u64, message: &D) -> Result<(), ExportError> {
        let mut raw = MAVLinkV2MessageRaw::new();
        raw.serialize_message_data(self.header, message);
        self.header.sequence = self.header.sequence.wrapping_add(1);
        self.frames += 1;
        let time = (at_ns / 1_000).to_be_bytes();
        let written = self
            .file
            .write_all(&time)
            .and_then(|()| self.file.write_all(raw.raw_bytes()));
        written.map_err(|error| ExportError::write(&self.path, error))
    }
}
