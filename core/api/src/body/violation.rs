//! A complaint of the schema as one of ours: where, what, and what would be right.
//!
//! Must never do: quote a whole body back.

use crate::error::ApiError;
use jsonschema::ValidationError;
use jsonschema::error::ValidationErrorKind as Kind;
use serde_json::Value;

/// A complaint is cut at this length in bytes: it quotes what was checked.
const MAX_PROBLEM_BYTES: usize = 300;

/// What is wrong, in words.
pub(super) fn of(error: &ValidationError<'_>) -> ApiError {
    let error = innermost(error);
    let field = place(&error.instance_path().to_string());
    match error.kind() {
        Kind::AdditionalProperties { unexpected } => ApiError::UnknownField {
            field: inside(&field, unexpected.first().map_or("", String::as_str)),
        },
        Kind::Type { .. } => ApiError::Shape {
            problem: format!("{field}: {}", shortened(type_said(error))),
        },
        kind => ApiError::OutOfRange {
            field,
            problem: shortened(range_said(kind).unwrap_or_else(|| error.to_string())),
        },
    }
}

/// Of alternatives that all do not fit, what is against the one that was meant: the one whose tag fits.
fn innermost<'e>(error: &'e ValidationError<'e>) -> &'e ValidationError<'e> {
    let (Kind::OneOfNotValid { context } | Kind::AnyOf { context }) = error.kind() else {
        return error;
    };
    let is_tag =
        |e: &ValidationError<'_>| matches!(e.kind(), Kind::Constant { .. } | Kind::Enum { .. } | Kind::Type { .. });
    let meant = context.iter().find(|against| !against.iter().any(is_tag));
    let is_of_no_kind = |against: &&Vec<ValidationError<'_>>| {
        let first = against.first();
        first.is_some_and(|e| matches!(e.kind(), Kind::Type { .. }) && e.instance_path() == error.instance_path())
    };
    let meant = meant.or_else(|| context.first().filter(is_of_no_kind));
    meant.and_then(|against| against.first()).map_or(error, innermost)
}

fn type_said(error: &ValidationError<'_>) -> String {
    match error.instance().as_ref() {
        Value::Array(_) => "a list stands where none belongs".to_owned(),
        _ => error.to_string(),
    }
}

fn range_said(kind: &Kind) -> Option<String> {
    Some(match kind {
        Kind::Minimum { limit } => format!("at least {limit}"),
        Kind::Maximum { limit } => format!("at most {limit}"),
        Kind::ExclusiveMinimum { limit } => format!("above {limit}"),
        Kind::MinItems { limit } => format!("at least {limit} entries"),
        Kind::MaxItems { limit } => format!("at most {limit} entries"),
        Kind::UniqueItems => "the same is there twice".to_owned(),
        _ => return None,
    })
}

/// `/route/waypoints/3/north_m` as `route.waypoints[3].north_m`.
fn place(pointer: &str) -> String {
    let place = pointer.split('/').skip(1).fold(String::new(), |place, part| {
        if part.bytes().all(|byte| byte.is_ascii_digit()) && !part.is_empty() {
            format!("{place}[{part}]")
        } else {
            inside(&place, part)
        }
    });
    if place.is_empty() { "body".to_owned() } else { place }
}

fn inside(place: &str, field: &str) -> String {
    if place.is_empty() || place == "body" {
        field.to_owned()
    } else {
        format!("{place}.{field}")
    }
}

fn shortened(mut text: String) -> String {
    if text.len() > MAX_PROBLEM_BYTES {
        text.truncate(text.floor_char_boundary(MAX_PROBLEM_BYTES));
        text.push('…');
    }
    text
}
