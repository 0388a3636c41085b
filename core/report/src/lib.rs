//! The report of a flight: from a recording to facts, from facts to one page of HTML that a person who was not there understands. The three
//! things to know: [`Report::of`], [`Finding`], [`html`].
//!
//! Must never do: hold a recording in memory, or say something that was not recorded.
#![forbid(unsafe_code)]

mod curve;
mod facts;
mod nearest;
mod page;
mod reading;
mod verdict;

pub use curve::{Curve, Sample};
pub use facts::{
    About, ActionFacts, Battery, ChartFacts, CommandFacts, EndState, EventFacts, Extreme, Finding, FindingKind, Gap,
    Gaps, LimitFrom, MapFacts, Near, Report, ReportError, Step, VehicleCurves, VehicleFacts, Wholeness, Worst,
    ZoneFacts,
};
pub use page::html;

#[cfg(test)]
mod tests;
