//! A part of a recording, as a recording of its own.
//!
//! Whoever begins to read in the middle needs what holds there: all gates and the whole audit up to there go along, and the last picture of the
//! fleet and of the clocks. They are recorded at the beginning of the part, and keep the time at which they happened.
//!
//! Must never do: break the audit's chain.

use crate::rewrite::Rewriter;
use crate::{ExportError, Progress, Rewritten, origin};
use skein_domain::NodeTime;
use skein_recording::{Damage, Message, Recording, Select, Topic};
use std::collections::BTreeMap;
use std::path::Path;

/// So many messages lie between two reports of progress.
const REPORT_EVERY: u64 = 2_000;

/// Writes what was recorded between two moments, in seconds from the beginning.
///
/// # Errors
/// When that is no part of it, or the file cannot be made.
pub fn cut(
    recording: &Recording,
    from_s: f64,
    until_s: f64,
    out: &Path,
    progress: Progress<'_>,
) -> Result<Rewritten, ExportError> {
    let (first, last) = recording.span();
    let length_s = last.seconds_since(first);
    // Comparisons with what is no number are false.
    if !(from_s >= 0.0 && until_s > from_s && from_s <= length_s) {
        return Err(ExportError::NoPart {
            from_s,
            until_s,
            length_s,
        });
    }
    let (from, until) = (first.plus_seconds(from_s), first.plus_seconds(until_s));
    let how = [
        ("file", recording.path().display().to_string()),
        ("from_s", from_s.to_string()),
        ("until_s", until_s.to_string()),
    ];
    let mut writer = Rewriter::create(out, recording.header(), "skein.cut", how)?;
    let mut damage = Vec::new();
    carry(recording, from, &mut writer, &mut damage)?;
    let select = Select {
        foreign: true,
        ..Select::default().from(from).until(until)
    };
    let part_s = until.min(last).seconds_since(from).max(1e-6);
    for (count, message) in (0_u64..).zip(recording.messages(select)) {
        let Some(message) = known(message, &mut damage) else {
            continue;
        };
        if count.is_multiple_of(REPORT_EVERY) {
            progress(message.recorded.seconds_since(from) / part_s);
        }
        writer.write(&message.name, message.recorded, message.at, &message.bytes)?;
    }
    let messages = writer.finish()?;
    progress(1.0);
    Ok(Rewritten { messages, damage })
}

/// Damage is noted; topics of other programs are left out.
fn known(message: Result<Message, Damage>, damage: &mut Vec<Damage>) -> Option<Message> {
    match message {
        Ok(message) => origin::parse(&message.name).is_some().then_some(message),
        Err(damaged) => {
            damage.push(damaged);
            None
        }
    }
}

/// Carries in what holds at the beginning.
fn carry(
    recording: &Recording,
    from: NodeTime,
    writer: &mut Rewriter,
    damage: &mut Vec<Damage>,
) -> Result<(), ExportError> {
    let holds = |topic: &Topic| matches!(topic, Topic::Audit | Topic::Gate | Topic::Fleet | Topic::Clock);
    let select = Select {
        foreign: true,
        ..Select::only(holds).until(from)
    };
    let mut last: BTreeMap<String, Message> = BTreeMap::new();
    for message in recording.messages(select) {
        let Some(message) = known(message, damage) else {
            continue;
        };
        match origin::parse(&message.name) {
            Some((_, Topic::Audit | Topic::Gate)) => {
                writer.write(&message.name, from, message.at, &message.bytes)?;
            }
            Some((_, Topic::Fleet | Topic::Clock)) => {
                last.insert(message.name.to_string(), message);
            }
            _ => {}
        }
    }
    for message in last.values() {
        writer.write(&message.name, from, message.at, &message.bytes)?;
    }
    Ok(())
}
