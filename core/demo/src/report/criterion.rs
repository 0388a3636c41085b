//! One criterion: a figure, its limit, whether it is met.

use serde::Serialize;
use std::borrow::Cow;

/// One criterion.
#[derive(Debug, Serialize)]
pub struct Criterion {
    /// What is measured.
    pub name: Cow<'static, str>,
    /// What was measured; `None` if nothing could be.
    pub value: Option<f64>,
    /// What it is compared with.
    pub limit: f64,
    /// `at_most` or `at_least`.
    pub comparison: &'static str,
    /// Unit of both.
    pub unit: &'static str,
    /// Whether it is met. Nothing measured is not met.
    pub met: bool,
}

/// Met by a value up to the limit.
pub fn at_most(name: impl Into<Cow<'static, str>>, value: Option<f64>, limit: f64, unit: &'static str) -> Criterion {
    let value = value.filter(|v| v.is_finite());
    Criterion {
        name: name.into(),
        value,
        limit,
        comparison: "at_most",
        unit,
        met: value.is_some_and(|v| v <= limit),
    }
}

/// Met by a value from the limit on.
pub fn at_least(name: impl Into<Cow<'static, str>>, value: Option<f64>, limit: f64, unit: &'static str) -> Criterion {
    let value = value.filter(|v| v.is_finite());
    Criterion {
        name: name.into(),
        value,
        limit,
        comparison: "at_least",
        unit,
        met: value.is_some_and(|v| v >= limit),
    }
}
