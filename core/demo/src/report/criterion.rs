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

/// Something measured that is to be judged.
pub struct Measured {
    name: Cow<'static, str>,
    value: Option<f64>,
}

/// A figure; `None` if it could not be measured.
pub fn measured(name: impl Into<Cow<'static, str>>, value: Option<f64>) -> Measured {
    Measured {
        name: name.into(),
        value: value.filter(|v| v.is_finite()),
    }
}

/// A number of things.
pub fn counted(name: impl Into<Cow<'static, str>>, count: usize) -> Measured {
    measured(name, Some(count as f64))
}

/// Met by what has happened.
pub fn happened(name: impl Into<Cow<'static, str>>, happened: bool) -> Criterion {
    counted(name, usize::from(happened)).at_least(1.0, "")
}

impl Measured {
    /// Met by a value up to the limit.
    pub fn at_most(self, limit: f64, unit: &'static str) -> Criterion {
        self.judged("at_most", limit, unit, |value| value <= limit)
    }

    /// Met by a value from the limit on.
    pub fn at_least(self, limit: f64, unit: &'static str) -> Criterion {
        self.judged("at_least", limit, unit, |value| value >= limit)
    }

    fn judged(
        self,
        comparison: &'static str,
        limit: f64,
        unit: &'static str,
        meets: impl Fn(f64) -> bool,
    ) -> Criterion {
        Criterion {
            met: self.value.is_some_and(meets),
            name: self.name,
            value: self.value,
            limit,
            comparison,
            unit,
        }
    }
}
