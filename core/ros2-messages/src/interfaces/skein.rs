//! `skein_msgs`: what no standard message has a word for. The definitions for others are in `deploy/ros2/skein_msgs`; a test compares them.
//!
//! Must never do: stand where a standard message exists.

use super::geometry::{Point, Quaternion, Vector3};
use super::standard::Header;
use super::{messages, services};

messages! { "skein_msgs":
    /// How a vehicle is.
    VehicleState {
        header: Header,
        /// The swarm's number for it.
        id: u16,
        /// Its name as configured.
        name: String,
        /// UAV model that flies it.
        model: String,
        /// Where it stands in its flight, one word.
        flight_state: String,
        /// Why; may be empty.
        detail: String,
        /// Mode of the autopilot, one word.
        mode: String,
        /// On the ground or in the air, one word.
        landed: String,
        armed: bool,
        ready_to_arm: bool,
        /// It is heard.
        connected: bool,
        /// It leads the formation.
        leader: bool,
        /// It takes part in the formation.
        in_formation: bool,
        /// How far it is from where its task wants it, in metres; not a number if it has none.
        tracking_error_m: f64,
        /// Why it can do less than it was built for.
        degraded: Vec<String>,
    }
    /// How a gimbal is.
    GimbalState {
        header: Header,
        /// Its name on the vehicle.
        name: String,
        connected: bool,
        /// What it is doing, one word.
        mode: String,
        /// Where it points, in the frame of the header: x along the optical axis, z up.
        orientation: Quaternion,
        /// Yaw and hence the orientation is known.
        orientation_known: bool,
        /// What is wrong with it; empty if nothing.
        fault: String,
    }
    /// The formation that is flown.
    Formation {
        header: Header,
        /// One is.
        active: bool,
        /// Its shape, one word.
        shape: String,
        spacing_m: f64,
        /// A vehicle leads it.
        has_leader: bool,
        leader: u16,
        /// Who takes part, leader first.
        members: Vec<u16>,
        /// Where its anchor is.
        anchor: Point,
        anchor_known: bool,
        /// Smallest distance between two that the plan of the last change foresees, in metres.
        planned_min_distance_m: f64,
        /// The leader has come to the end of its route.
        route_finished: bool,
    }
    /// What [`TakeOff`] is asked.
    TakeOffRequest {
        /// Height above the launch place in metres.
        height_m: f64,
    }
    /// What [`GoTo`] is asked.
    GoToRequest {
        /// Where to, in the frame map.
        position: Point,
        /// `yaw_rad` counts; else the vehicle keeps its yaw.
        set_yaw: bool,
        /// Yaw in radians, counter-clockwise from east.
        yaw_rad: f64,
        /// Speed in metres per second; 0: the model's own.
        speed_m_s: f64,
    }
    /// What [`PointGimbal`] is asked.
    PointGimbalRequest {
        /// Its name on the vehicle; empty: the first.
        gimbal: String,
        /// Frame of the direction: map, or the vehicle's base_link, taken level.
        frame_id: String,
        /// Where to look.
        direction: Vector3,
    }
    /// What a command to one vehicle is answered.
    CommandOutcome {
        /// It was taken up. How it goes on shows in the state.
        success: bool,
        /// The reason of a refusal, one word; empty if there is none.
        code: String,
        /// The reason of a refusal, a sentence; empty if there is none.
        message: String,
        /// Number of the command, as in the events of the node.
        command: u64,
    }
    /// What [`SetFormation`] is asked.
    SetFormationRequest {
        /// line, column, wedge, echelon_left, echelon_right, diamond, circle, arc, square, grid, box, sphere or helix.
        shape: String,
        /// Distance between neighbours in metres.
        spacing_m: f64,
        /// auto, course or fixed; empty: auto.
        heading: String,
        /// For a fixed one: counter-clockwise from east, in radians.
        heading_rad: f64,
        /// Each next place is so much higher, in metres.
        altitude_step_m: f64,
        /// The shape is turned by this, counter-clockwise seen from above, in radians.
        rotation_rad: f64,
        /// The shape is made so many times as large; 0: once.
        scale: f64,
        /// `leader` counts; else the swarm chooses.
        set_leader: bool,
        leader: u16,
        /// Who takes part; empty: all in the air.
        members: Vec<u16>,
    }
    /// What [`Follow`] is asked.
    FollowRequest {
        /// Whom to follow.
        leader: u16,
        /// Who follows, one behind the other.
        followers: Vec<u16>,
        /// Distance between two in metres.
        spacing_m: f64,
    }
    /// What [`SetFormation`] and [`Follow`] are answered.
    FormationOutcome {
        /// It is flown.
        success: bool,
        /// The reason of a refusal, one word; empty if there is none.
        code: String,
        /// The reason of a refusal, a sentence; empty if there is none.
        message: String,
        has_leader: bool,
        leader: u16,
        /// Who takes part, leader first.
        members: Vec<u16>,
        /// How long the change takes in seconds.
        duration_s: f64,
        /// Smallest distance between two on the way, in metres.
        planned_min_distance_m: f64,
    }
}

services! { "skein_msgs":
    /// Arm if need be, climb, hold.
    TakeOff = TakeOffRequest => CommandOutcome,
    /// Fly to a place and hold there.
    GoTo = GoToRequest => CommandOutcome,
    /// Look somewhere with a gimbal.
    PointGimbal = PointGimbalRequest => CommandOutcome,
    /// Fly a formation.
    SetFormation = SetFormationRequest => FormationOutcome,
    /// Some vehicles follow another.
    Follow = FollowRequest => FormationOutcome,
}
