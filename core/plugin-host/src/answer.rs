//! What an instance answered, judged: nothing of it is used before all of it was found right.

use crate::entry::PluginBytes;
use crate::frames::{Frame, Pool};
use crate::{Manifest, PluginError, RunnerSettings, SchemaError};
use minicbor::Decoder;
use minicbor::decode::Error;
use parking_lot::Mutex;
use skein_domain::exchange::{EFFECT_BATCH_SCHEMA, Effect};
use std::sync::Arc;

/// What an instance wants done after an event batch, and what it is to go on from after a restart.
#[derive(Debug, Clone)]
pub struct PluginAnswer {
    /// In the order they are to be carried out; without [`Effect::Frame`].
    pub effects: Vec<Effect>,
    /// The frames it gave, in order.
    pub frames: Vec<Arc<Frame>>,
    /// Its snapshot after this batch.
    pub snapshot: Vec<u8>,
}

/// An answer as it came: the schema and the bytes, and the snapshot's if one was asked for.
#[derive(Debug)]
pub(crate) struct RawAnswer {
    pub(crate) schema: u32,
    pub(crate) bytes: AnswerBytes,
    pub(crate) snapshot: Option<AnswerBytes>,
}

/// Bytes of an answer.
#[derive(Debug)]
pub(crate) enum AnswerBytes {
    /// They lie where the plugin put them.
    Plugin(PluginBytes),
    /// They came from another process.
    Received(Vec<u8>),
}

impl AnswerBytes {
    pub(crate) fn bytes(&self) -> &[u8] {
        match self {
            Self::Plugin(bytes) => bytes.bytes(),
            Self::Received(bytes) => bytes,
        }
    }
}

/// Judges the answers of one instance.
#[derive(Debug)]
pub(crate) struct Judge {
    settings: RunnerSettings,
    /// The state and the event that were found right last: most states are reported again as they were.
    last_state: Mutex<String>,
    last_event: Mutex<String>,
}

impl Judge {
    pub(crate) fn new(settings: RunnerSettings) -> Self {
        Self {
            settings,
            last_state: Mutex::default(),
            last_event: Mutex::default(),
        }
    }

    /// A whole answer.
    pub(crate) fn answer(
        &self,
        manifest: &Manifest,
        pool: &Pool,
        answer: &RawAnswer,
    ) -> Result<PluginAnswer, PluginError> {
        let (effects, frames) = self.effects(manifest, pool, answer.schema, answer.bytes.bytes())?;
        let snapshot = answer.snapshot.as_ref().map_or(&[][..], AnswerBytes::bytes);
        Ok(PluginAnswer {
            effects,
            frames,
            snapshot: self.snapshot(snapshot)?,
        })
    }

    /// The effects of a batch and the frames among them, if all of it is right.
    pub(crate) fn effects(
        &self,
        manifest: &Manifest,
        pool: &Pool,
        schema: u32,
        bytes: &[u8],
    ) -> Result<(Vec<Effect>, Vec<Arc<Frame>>), PluginError> {
        let mut effects = self.decode(schema, bytes)?;
        // First of all: their slots come back with these, whatever else is wrong.
        let frames = take_frames(manifest, pool, &mut effects);
        for effect in &effects {
            self.check(manifest, effect)?;
        }
        Ok((effects, frames?))
    }

    /// A snapshot, if it is not too long.
    pub(crate) fn snapshot(&self, bytes: &[u8]) -> Result<Vec<u8>, PluginError> {
        let limit = self.settings.max_snapshot_bytes;
        if bytes.len() > limit {
            return Err(PluginError::TooLarge {
                len: bytes.len(),
                limit,
            });
        }
        Ok(bytes.to_vec())
    }

    fn decode(&self, schema: u32, bytes: &[u8]) -> Result<Vec<Effect>, PluginError> {
        if schema != EFFECT_BATCH_SCHEMA {
            return Err(PluginError::Undecodable {
                detail: format!("schema {schema}, not {EFFECT_BATCH_SCHEMA}"),
            });
        }
        if bytes.len() > self.settings.max_answer_bytes {
            return Err(PluginError::TooLarge {
                len: bytes.len(),
                limit: self.settings.max_answer_bytes,
            });
        }
        let limit = self.settings.max_effects;
        let undecodable = |e: Error| PluginError::Undecodable { detail: e.to_string() };
        // Counted before they are decoded: each effect takes many times its bytes when decoded.
        let (count, decoder) = announced_effects(bytes).map_err(undecodable)?;
        if count > limit {
            return Err(PluginError::TooManyEffects { count, limit });
        }
        let effects = decoder.map_or(Ok(Vec::new()), |decoder| effects(decoder, count));
        effects.map_err(undecodable)
    }

    fn check(&self, manifest: &Manifest, effect: &Effect) -> Result<(), PluginError> {
        let kind = effect.kind();
        if !manifest.effects.contains(&kind) {
            return Err(PluginError::NotPermitted { effect: kind });
        }
        match effect {
            Effect::Report { state_json } => once(&self.last_state, "a state", state_json, |json| {
                manifest.check_state(json)
            }),
            Effect::Occurrence { event_json } => once(&self.last_event, "an event", event_json, |json| {
                manifest.check_event(json)
            }),
            _ => Ok(()),
        }
    }
}

/// Checks a text unless it is the one that was found right last.
fn once(
    last: &Mutex<String>,
    what: &'static str,
    json: &str,
    check: impl FnOnce(&str) -> Result<(), SchemaError>,
) -> Result<(), PluginError> {
    let mut last = last.lock();
    if !last.is_empty() && *last == json {
        return Ok(());
    }
    check(json).map_err(|error| PluginError::SchemaViolation { what, error })?;
    json.clone_into(&mut last);
    Ok(())
}

/// Takes the frames out of the effects. All slots that were given away are taken over, so that none is lost with a batch that is refused
/// for what is in it. One that cannot be decoded, or that nobody waits for any more, keeps its slots until the instance goes.
fn take_frames(manifest: &Manifest, pool: &Pool, effects: &mut Vec<Effect>) -> Result<Vec<Arc<Frame>>, PluginError> {
    if !effects.iter().any(|effect| matches!(effect, Effect::Frame(_))) {
        return Ok(Vec::new());
    }
    let mut frames = Vec::new();
    effects.retain_mut(|effect| match effect {
        Effect::Frame(header) => {
            frames.push(pool.give(std::mem::take(header)));
            false
        }
        _ => true,
    });
    let effect = skein_domain::manifest::EffectKind::Frame;
    if !manifest.effects.contains(&effect) {
        return Err(PluginError::NotPermitted { effect });
    }
    frames.into_iter().collect()
}

/// How many effects an encoded batch announces, and where they begin. One that does not announce it is not taken.
fn announced_effects(bytes: &[u8]) -> Result<(u64, Option<Decoder<'_>>), Error> {
    let mut decoder = Decoder::new(bytes);
    match decoder.array()? {
        Some(0) => Ok((0, None)),
        _ => decoder
            .array()?
            .map(|count| (count, Some(decoder)))
            .ok_or_else(|| Error::message("a list of effects without a length")),
    }
}

/// So many effects. Fields of the batch after them are of a newer version, and not looked at.
fn effects(mut decoder: Decoder<'_>, count: u64) -> Result<Vec<Effect>, Error> {
    let mut effects = Vec::with_capacity(count as usize);
    for _ in 0..count {
        effects.push(decoder.decode()?);
    }
    Ok(effects)
}

#[cfg(test)]
mod tests;
