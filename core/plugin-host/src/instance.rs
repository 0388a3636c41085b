//! One instance of a UAV-model plugin, as its vehicle actor holds it: event batches in, effect batches out.

use crate::entry::PluginBytes;
use crate::runners::{Calls, encode};
use crate::{CallStatistics, Manifest, PluginError};
use skein_domain::exchange::{EFFECT_BATCH_SCHEMA, EVENT_BATCH_SCHEMA, EffectBatch, EventBatch};
use skein_plugin_abi::method;

/// An instance. Dropping it ends it on its thread, without waiting.
#[derive(Debug)]
pub struct Instance(Calls);

impl Instance {
    pub(crate) fn new(calls: Calls) -> Self {
        Self(calls)
    }

    /// Hands a batch of events in and gives what the model wants done. Calls of one instance are made in the order they were begun.
    /// If the future is dropped the call is still made, and its effects are lost.
    pub async fn call(&self, batch: EventBatch) -> Result<EffectBatch, PluginError> {
        let answer = self
            .0
            .invoke(method::HANDLE_EVENTS, EVENT_BATCH_SCHEMA, encode(&batch)?, false)
            .await?;
        self.effects(answer.schema, &answer.bytes)
    }

    /// As [`Self::call`], and takes the snapshot after it in the same visit to the plugin's thread: the snapshot holds everything up
    /// to and with this batch.
    pub async fn call_with_snapshot(&self, batch: EventBatch) -> Result<(EffectBatch, Vec<u8>), PluginError> {
        let answer = self
            .0
            .invoke(method::HANDLE_EVENTS, EVENT_BATCH_SCHEMA, encode(&batch)?, true)
            .await?;
        let effects = self.effects(answer.schema, &answer.bytes)?;
        let snapshot = answer
            .snapshot
            .map_or(Ok(Vec::new()), |snapshot| self.snapshot_bytes(&snapshot))?;
        Ok((effects, snapshot))
    }

    /// The state from which a new instance goes on after this one.
    pub async fn snapshot(&self) -> Result<Vec<u8>, PluginError> {
        let answer = self.0.invoke(method::SNAPSHOT, 0, Vec::new(), false).await?;
        self.snapshot_bytes(&answer.bytes)
    }

    /// Its name in logs.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.0.body.name
    }

    /// What its plugin says of itself.
    #[must_use]
    pub fn manifest(&self) -> &Manifest {
        self.0.body.plugin.manifest()
    }

    /// How long its calls take. Does not wait for a running call.
    #[must_use]
    pub fn statistics(&self) -> CallStatistics {
        self.0.body.times.read(self.0.body.sink.dropped())
    }

    fn effects(&self, schema: u32, answer: &PluginBytes) -> Result<EffectBatch, PluginError> {
        let (bytes, settings) = (answer.bytes(), &self.0.settings);
        if schema != EFFECT_BATCH_SCHEMA {
            return Err(PluginError::Undecodable {
                detail: format!("schema {schema}, not {EFFECT_BATCH_SCHEMA}"),
            });
        }
        if bytes.len() > settings.max_answer_bytes {
            return Err(PluginError::TooLarge {
                len: bytes.len(),
                limit: settings.max_answer_bytes,
            });
        }
        let limit = settings.max_effects;
        let undecodable = |e: minicbor::decode::Error| PluginError::Undecodable { detail: e.to_string() };
        // Counted before they are decoded: each effect takes many times its bytes when decoded.
        let count = announced_effects(bytes).map_err(undecodable)?;
        if count > limit {
            return Err(PluginError::TooManyEffects { count, limit });
        }
        let batch: EffectBatch = minicbor::decode(bytes).map_err(undecodable)?;
        let permitted = &self.manifest().effects;
        match batch
            .effects
            .iter()
            .map(|effect| effect.kind())
            .find(|kind| !permitted.contains(kind))
        {
            Some(effect) => Err(PluginError::NotPermitted { effect }),
            None => Ok(batch),
        }
    }

    fn snapshot_bytes(&self, snapshot: &PluginBytes) -> Result<Vec<u8>, PluginError> {
        let (bytes, limit) = (snapshot.bytes(), self.0.settings.max_snapshot_bytes);
        if bytes.len() > limit {
            return Err(PluginError::TooLarge {
                len: bytes.len(),
                limit,
            });
        }
        Ok(bytes.to_vec())
    }
}

/// How many effects an encoded batch announces. One that does not announce it is not taken.
fn announced_effects(bytes: &[u8]) -> Result<u64, minicbor::decode::Error> {
    let mut decoder = minicbor::Decoder::new(bytes);
    match decoder.array()? {
        Some(0) => Ok(0),
        _ => decoder
            .array()?
            .ok_or_else(|| minicbor::decode::Error::message("a list of effects without a length")),
    }
}
