//! Whether a change of mode was asked for from here. An unasked change out of OFFBOARD is the pilot's, or the autopilot's own
//! failsafe; either way the vehicle is out of the swarm's control.

use skein_domain::{FlightMode, NodeTime};

/// A mode that may come because it was asked for.
#[derive(Debug, Clone, Copy)]
struct Expected {
    mode: FlightMode,
    until: NodeTime,
}

/// A change of mode.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ModeChange {
    /// Before.
    pub from: FlightMode,
    /// Now.
    pub to: FlightMode,
    /// Asked for from here.
    pub commanded: bool,
}

/// Watches one vehicle's mode.
#[derive(Debug, Default)]
pub struct ModeWatch {
    mode: Option<FlightMode>,
    /// Whether the present mode was asked for from here.
    commanded: bool,
    expected: Vec<Expected>,
}

impl ModeWatch {
    /// A command that leads to `mode` was sent; a change to it until `until` is ours.
    pub fn expect(&mut self, mode: FlightMode, until: NodeTime) {
        self.forget(mode);
        self.expected.push(Expected { mode, until });
    }

    /// The command was refused, or what it asked for has been seen.
    pub fn forget(&mut self, mode: FlightMode) {
        self.expected.retain(|expected| expected.mode != mode);
    }

    /// The mode a heartbeat shows. The first one is no change.
    pub fn on_mode(&mut self, now: NodeTime, to: FlightMode) -> Option<ModeChange> {
        self.expected.retain(|expected| expected.until >= now);
        let from = self.mode.replace(to)?;
        if from == to {
            return None;
        }
        let asked = self.expected.iter().any(|expected| expected.mode == to);
        // A take-off ends in HOLD by itself: that was asked for with the take-off.
        let end_of_take_off = from == FlightMode::TakeOff && to == FlightMode::Hold && self.commanded;
        self.commanded = asked || end_of_take_off;
        // Used up: should the autopilot go there again later, it is not our doing.
        self.forget(to);
        Some(ModeChange {
            from,
            to,
            commanded: self.commanded,
        })
    }
}

#[cfg(test)]
mod tests {
    //! Ours, the pilot's, and the end of a take-off.

    use super::*;
    use FlightMode::{Hold, Land, Offboard, Return, TakeOff};

    fn at(seconds: f64) -> NodeTime {
        NodeTime::from_seconds(seconds)
    }

    #[test]
    fn only_what_was_asked_for_in_time_is_commanded() {
        let mut watch = ModeWatch::default();
        assert_eq!(watch.on_mode(at(0.0), Hold), None);
        watch.expect(TakeOff, at(5.0));
        assert!(watch.on_mode(at(1.0), TakeOff).unwrap().commanded);
        assert!(
            watch.on_mode(at(9.0), Hold).unwrap().commanded,
            "the end of our take-off"
        );
        watch.expect(Offboard, at(12.0));
        assert!(watch.on_mode(at(10.0), Offboard).unwrap().commanded);
        assert_eq!(watch.on_mode(at(11.0), Offboard), None);
        let change = watch.on_mode(at(11.5), Return).unwrap();
        assert_eq!(
            change,
            ModeChange {
                from: Offboard,
                to: Return,
                commanded: false
            }
        );
        let back = watch.on_mode(at(11.6), Offboard).unwrap();
        assert!(
            !back.commanded,
            "the expectation was used up: the autopilot came back by itself"
        );
        watch.expect(Land, at(12.0));
        assert!(!watch.on_mode(at(13.0), Land).unwrap().commanded, "too late");
    }

    #[test]
    fn a_pilots_take_off_ends_unasked() {
        let mut watch = ModeWatch::default();
        watch.on_mode(at(0.0), Hold);
        assert!(!watch.on_mode(at(1.0), TakeOff).unwrap().commanded);
        assert!(!watch.on_mode(at(9.0), Hold).unwrap().commanded);
    }
}
