//! Bodies of requests: JSON of exactly the published shape, checked against the schema that is published. What is allowed is the safety
//! gate's to say, not ours.
//!
//! Must never do: refuse what the schema permits, or take what it does not.

mod violation;

use crate::error::ApiError;
use crate::example::Example;
use axum::Json;
use axum::body::Bytes;
use axum::extract::rejection::JsonRejection;
use axum::extract::{FromRequest, Request};
use axum::http::{HeaderMap, header};
use jsonschema::Validator;
use parking_lot::Mutex;
use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde::de::{DeserializeOwned, IgnoredAny};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use skein_domain::payload::Track;
use skein_runtime::Detection;
use std::any::TypeId;
use std::borrow::Cow;
use std::collections::HashMap;
use std::sync::{Arc, LazyLock};
use std::time::Duration;
use tokio::time::timeout;

/// Largest body that is read, in bytes.
pub const MAX_BODY_BYTES: usize = 1024 * 1024;
/// A body has to be there within this time.
const BODY_WITHIN: Duration = Duration::from_secs(10);
/// Up to here every whole number has a floating-point number of its own.
const LARGEST_WHOLE: f64 = 9_007_199_254_740_992.0;

/// A body that was read and is of the published shape.
#[derive(Debug, Clone, Copy)]
pub struct Body<T>(pub T);

impl<T, S> FromRequest<S> for Body<T>
where
    T: DeserializeOwned + JsonSchema + Example + 'static,
    S: Send + Sync,
{
    type Rejection = ApiError;

    async fn from_request(request: Request, state: &S) -> Result<Self, ApiError> {
        if !says_json(request.headers()) {
            return Err(ApiError::NotJson);
        }
        let received = timeout(BODY_WITHIN, Bytes::from_request(request, state)).await;
        let bytes = received.map_err(|_| ApiError::TooSlow)?.map_err(JsonRejection::from)?;
        let understood = understand(&bytes).map_err(|problem| ApiError::Unfit {
            problem: Box::new(problem),
            example: T::example(),
        });
        understood.map(Self)
    }
}

/// What the bytes say, if it is of the published shape.
pub(crate) fn understand<T: DeserializeOwned + JsonSchema + 'static>(bytes: &[u8]) -> Result<T, ApiError> {
    let bytes = with_whole_numbers(bytes);
    // First by the type, whose complaints name what was expected; then what only the schema knows: ranges, lengths, and what the type
    // overlooks, such as a field beside a tag that takes none, or a list in place of an object.
    let Json(value) = Json::<T>::from_bytes(&bytes).map_err(|rejection| not_understood(rejection, &bytes))?;
    let given: Value = serde_json::from_slice(&bytes).map_err(|e| ApiError::Shape { problem: e.to_string() })?;
    match validator::<T>()?.iter_errors(&given).next() {
        Some(error) => Err(violation::of(&error)),
        None => Ok(value),
    }
}

/// The published schema of a type, compiled once.
fn validator<T: JsonSchema + 'static>() -> Result<Arc<Validator>, ApiError> {
    static ALL: LazyLock<Mutex<HashMap<TypeId, Arc<Validator>>>> = LazyLock::new(Mutex::default);
    if let Some(known) = ALL.lock().get(&TypeId::of::<T>()) {
        return Ok(Arc::clone(known));
    }
    let settings = SchemaSettings::draft2020_12().for_deserialize();
    let schema = settings.into_generator().into_root_schema_for::<T>().to_value();
    let built = jsonschema::options().offline().build(&schema);
    let built = Arc::new(built.map_err(|e| ApiError::Shape {
        problem: format!("the schema of this body is none: {e}"),
    })?);
    ALL.lock().insert(TypeId::of::<T>(), Arc::clone(&built));
    Ok(built)
}

/// `3.0` is a whole number to JSON Schema and to whoever writes JavaScript, and none to serde.
fn with_whole_numbers(bytes: &[u8]) -> Cow<'_, [u8]> {
    fn make_whole(value: &mut Value) -> bool {
        match value {
            Value::Number(number) => match number.as_f64() {
                Some(float) if number.is_f64() && float.fract() == 0.0 && float.abs() < LARGEST_WHOLE => {
                    #[expect(clippy::cast_possible_truncation, reason = "it is whole and in range")]
                    let whole = float as i64;
                    *value = whole.into();
                    true
                }
                _ => false,
            },
            Value::Array(items) => items.iter_mut().fold(false, |any, item| make_whole(item) | any),
            Value::Object(fields) => fields.values_mut().fold(false, |any, field| make_whole(field) | any),
            _ => false,
        }
    }
    let Ok(mut value) = serde_json::from_slice::<Value>(bytes) else {
        return Cow::Borrowed(bytes);
    };
    if make_whole(&mut value) {
        Cow::Owned(value.to_string().into_bytes())
    } else {
        Cow::Borrowed(bytes)
    }
}

/// Whether the body says that it is JSON. A foreign page cannot say so without asking first, and is refused then.
fn says_json(headers: &HeaderMap) -> bool {
    let said = headers
        .get(header::CONTENT_TYPE)
        .and_then(|value| value.to_str().ok())
        .unwrap_or_default();
    said.split(';')
        .next()
        .is_some_and(|kind| kind.trim().eq_ignore_ascii_case("application/json"))
}

/// Some mistakes of type are reported as if the text were no JSON (a number where a word is due).
fn not_understood(rejection: JsonRejection, bytes: &[u8]) -> ApiError {
    let is_json = || serde_json::from_slice::<IgnoredAny>(bytes).is_ok();
    match rejection {
        JsonRejection::JsonSyntaxError(error) if is_json() => ApiError::Shape {
            problem: error.body_text(),
        },
        rejection => rejection.into(),
    }
}

/// A command to a payload, as its plugin's command schema has it.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(transparent)]
pub struct PayloadCommandBody(pub Map<String, Value>);

/// Everything that is tracked.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TracksBody {
    /// The tracks.
    pub tracks: Vec<Track>,
}

/// What a radar, a radio direction finder or another sensor has seen.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema, ts_rs::TS)]
#[serde(deny_unknown_fields)]
pub struct DetectionsBody {
    /// Names the sensor: what it names stays the same as long as the source is the same.
    #[schemars(length(min = 1, max = 64), pattern(r"^[^/]+$"))]
    pub source: String,
    /// What it saw.
    #[schemars(length(max = 1000))]
    pub detections: Vec<Detection>,
}

/// What is to change of a track; what is left out stays as it is.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema, ts_rs::TS)]
#[serde(deny_unknown_fields)]
pub struct TrackChangeBody {
    /// What it is called; an empty name takes the name away.
    #[serde(default)]
    #[schemars(length(max = 32))]
    pub name: Option<String>,
    /// Whether it is kept longer when nobody sees it.
    #[serde(default)]
    pub pinned: Option<bool>,
}

#[cfg(test)]
mod tests;
