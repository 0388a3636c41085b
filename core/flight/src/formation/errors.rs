//! Why a formation or a transition cannot be made.

use thiserror::Error;

/// Why a formation or a transition cannot be made.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum FormationError {
    /// A formation needs at least one vehicle.
    #[error("a formation needs at least one vehicle")]
    NoMembers,
    /// The spacing is not a positive finite number.
    #[error("spacing {spacing_m} m: it must be a finite number above zero")]
    InvalidSpacing {
        /// What was given.
        spacing_m: f64,
    },
    /// The altitude step is not finite.
    #[error("altitude step {altitude_step_m} m: it must be a finite number")]
    InvalidAltitudeStep {
        /// What was given.
        altitude_step_m: f64,
    },
    /// The altitude step brings slots of a shape that has heights of its own too close together.
    #[error(
        "altitude step {altitude_step_m} m: it brings slots of this shape within {distance_m:.1} m of each other (heights counted \
         by two thirds), {least_m:.1} m are needed"
    )]
    AltitudeStepTooClose {
        /// What was given.
        altitude_step_m: f64,
        /// What the smallest separation would be, in metres.
        distance_m: f64,
        /// What it must be, in metres.
        least_m: f64,
    },
    /// The rotation is not finite.
    #[error("rotation {rotation_deg}°: it must be a finite number")]
    InvalidRotation {
        /// What was given.
        rotation_deg: f64,
    },
    /// The scale is not a positive finite number.
    #[error("scale {scale}: it must be a finite number above zero")]
    InvalidScale {
        /// What was given.
        scale: f64,
    },
    /// The arc is not above 0 and at most 360 degrees.
    #[error("arc of {arc_deg}°: it must be above 0° and at most 360°")]
    InvalidArc {
        /// What was given.
        arc_deg: f64,
    },
    /// A box without layers.
    #[error("a box needs at least one layer")]
    NoLayers,
    /// The turns of a helix are too close above each other, or not a number apart.
    #[error("pitch {pitch_m} m: a helix needs at least {least_m:.1} m between its turns")]
    InvalidPitch {
        /// What was given.
        pitch_m: f64,
        /// The least that keeps vehicles out of each other's downwash, in metres.
        least_m: f64,
    },
    /// A free shape without offsets.
    #[error("a free shape needs its offsets")]
    NoOffsets,
    /// A free shape with fewer offsets than vehicles.
    #[error("{members} members, but only {offsets} offsets")]
    TooFewOffsets {
        /// Members of the formation.
        members: usize,
        /// Offsets given.
        offsets: usize,
    },
    /// Two offsets of a free shape are at one place.
    #[error(
        "offsets {first} and {second} (counted from 0) are {distance_m:.2} m apart; at least {least_m} m are needed"
    )]
    OffsetsTooClose {
        /// The one's place in the list, from 0.
        first: usize,
        /// The other's.
        second: usize,
        /// How far apart they are, in metres.
        distance_m: f64,
        /// The least, in metres.
        least_m: f64,
    },
    /// The shape is so large that its offsets are no numbers any more.
    #[error("the formation is too large to be counted with")]
    TooLarge,
    /// A motion limit is not a positive finite number.
    #[error("{limit} = {value}: it must be a finite number above zero")]
    InvalidLimit {
        /// Which limit.
        limit: &'static str,
        /// What was given.
        value: f64,
    },
    /// An offset is not finite.
    #[error("the offset of member {index} is not finite")]
    NotFinite {
        /// Its place in the list, from 0.
        index: usize,
    },
    /// A list that must have one entry for each member has another number of them.
    #[error("{members} members, but {entries} entries of {list}")]
    ListDoesNotFit {
        /// Which list.
        list: &'static str,
        /// Members, the leader included.
        members: usize,
        /// Entries of the list.
        entries: usize,
    },
    /// Fewer slots than members.
    #[error("{members} members, but {slots} slots")]
    NotEnoughSlots {
        /// Members, the leader included.
        members: usize,
        /// Slots, the leader's included.
        slots: usize,
    },
    /// No way into the slots was found that keeps the asked distance.
    #[error("no way into the slots keeps {limit_m:.1} m between the vehicles; the best found comes to {best_m:.1} m")]
    NoSafeTransition {
        /// The largest smallest distance of all ways tried, in metres.
        best_m: f64,
        /// The distance asked for in metres.
        limit_m: f64,
    },
}
