//! The JSON Schemas of a plugin, compiled once when it is loaded.
//!
//! Must never do: fetch what a schema refers to.

use crate::SchemaError;
use jsonschema::Validator;
use serde_json::Value;

/// No schema of a plugin is longer, in bytes.
const MAX_SCHEMA_BYTES: usize = 256 << 10;
/// A reason is cut at this length in bytes: it quotes what was checked.
const MAX_REASON_BYTES: usize = 400;

/// One schema.
#[derive(Debug)]
pub(crate) struct Schema(Validator);

impl Schema {
    /// Compiles. The error says what is wrong with the schema of `what`.
    pub(crate) fn compile(what: &str, json: &str) -> Result<Self, String> {
        if json.len() > MAX_SCHEMA_BYTES {
            return Err(format!("the schema of {what} has {} bytes", json.len()));
        }
        let value: Value = serde_json::from_str(json).map_err(|e| format!("the schema of {what} is not JSON: {e}"))?;
        if !value.is_object() {
            return Err(format!("the schema of {what} is not a JSON object"));
        }
        jsonschema::options()
            .offline()
            .build(&value)
            .map(Self)
            .map_err(|e| format!("the schema of {what} is none: {e}"))
    }

    /// Whether a text is as the schema has it.
    pub(crate) fn check(&self, json: &str) -> Result<(), SchemaError> {
        let value: Value = serde_json::from_str(json).map_err(|e| SchemaError::NotJson { detail: e.to_string() })?;
        self.0.validate(&value).map_err(|e| SchemaError::Violated {
            path: e.instance_path().to_string(),
            reason: shortened(e.to_string()),
        })
    }
}

fn shortened(mut text: String) -> String {
    if text.len() > MAX_REASON_BYTES {
        text.truncate(text.floor_char_boundary(MAX_REASON_BYTES));
        text.push('…');
    }
    text
}

/// All schemas of a plugin.
#[derive(Debug)]
pub(crate) struct Schemas {
    pub(crate) config: Schema,
    pub(crate) command: Option<Schema>,
    pub(crate) state: Option<Schema>,
    pub(crate) event: Option<Schema>,
}

/// Checks against a schema that may not be there.
pub(crate) fn check(schema: Option<&Schema>, json: &str) -> Result<(), SchemaError> {
    schema.ok_or(SchemaError::NoSchema)?.check(json)
}
