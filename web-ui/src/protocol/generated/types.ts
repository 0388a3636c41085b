// Made from the Rust types by `SKEIN_REGENERATE=1 cargo test -p skein-api --test generated`. Do not edit.

/**
 * It was taken up; how it goes on comes as events.
 */
export type Accepted = { 
/**
 * Always true.
 */
accepted: boolean, };

/**
 * A supervised actor or plugin instance.
 */
export type ActorHealth = { 
/**
 * Name in the supervision tree, for example `vehicle-3`.
 */
name: string, 
/**
 * Running, restarting after back-off, or given up.
 */
status: ActorStatus, 
/**
 * How many times it was started.
 */
incarnation: Incarnation, 
/**
 * The last error that ended it; empty if none did.
 */
last_error: string, 
/**
 * Since when it has this status.
 */
since: NodeTime, };

/**
 * What a supervised actor is doing.
 */
export type ActorStatus = "running" | "restarting" | "given_up";

/**
 * Battery, as reported.
 */
export type Battery = { 
/**
 * Remaining charge, 0..=1.
 */
remaining: number | null, 
/**
 * Voltage in volts.
 */
voltage_v: number | null, 
/**
 * Current in amperes.
 */
current_a: number | null, };

/**
 * What a client may say on the stream as text.
 */
export type ClientMessage = { "type": "rate", 
/**
 * Frames per second, 1 to 50.
 */
rate_hz: number, };

/**
 * A command and whom it is for.
 */
export type CommandBody = { 
/**
 * Whom it is for.
 */
targets: Targets, 
/**
 * The command.
 */
command: VehicleCommand, };

/**
 * One command as an operator gave it; outcomes refer to it.
 */
export type CommandId = number;

/**
 * How a command goes on.
 */
export type CommandProgress = { "progress": "executing" } | { "progress": "done" } | { "progress": "refused", 
/**
 * Why.
 */
refusal: Refusal, };

/**
 * What became of a command at one vehicle: taken up (how it goes on comes as events), or refused.
 */
export type CommandReceipt = { 
/**
 * The vehicle.
 */
vehicle: VehicleId, 
/**
 * The command's id; events about its progress carry it.
 */
id: CommandId, 
/**
 * Why it was refused; absent if it was taken up.
 */
refusal: Refusal | null, };

/**
 * What became of a command, vehicle by vehicle.
 */
export type CommandReceipts = { 
/**
 * One for each vehicle it was for.
 */
receipts: Array<CommandReceipt>, };

/**
 * Every answer that is not a success.
 */
export type ErrorBody = { 
/**
 * What went wrong.
 */
error: ErrorDetail, };

/**
 * What went wrong.
 */
export type ErrorDetail = { 
/**
 * A word for programs. For refusals the same as the refusal's `reason`.
 */
code: string, 
/**
 * A sentence for people.
 */
message: string, 
/**
 * Facts that go with the code: the refusal itself, the place in the body, what would be allowed. May be null.
 */
detail: unknown, };

/**
 * What kind of thing happened.
 */
export type EventKind = { "kind": "adopted" } | { "kind": "not_adopted" } | { "kind": "link_lost" } | { "kind": "link_regained" } | { "kind": "autopilot_rebooted" } | { "kind": "flight_state", 
/**
 * The new state.
 */
state: FlightState, } | { "kind": "command", 
/**
 * Which.
 */
id: CommandId, 
/**
 * Its name.
 */
command: string, 
/**
 * How.
 */
progress: CommandProgress, } | { "kind": "refused", 
/**
 * Why.
 */
refusal: Refusal, } | { "kind": "formation" } | { "kind": "supervision", 
/**
 * Name in the supervision tree.
 */
actor: string, 
/**
 * What it is doing now.
 */
status: ActorStatus, } | { "kind": "stream" } | { "kind": "status_text" } | { "kind": "notice" };

/**
 * Events after a given one.
 */
export type EventList = { 
/**
 * Oldest first.
 */
events: Array<EventRecord>, 
/**
 * How many between the given one and the first of the list are no longer kept.
 */
missed: number, };

/**
 * One thing that happened.
 */
export type EventRecord = { 
/**
 * Grows by one with every event of this node.
 */
seq: number, 
/**
 * When.
 */
time: NodeTime, 
/**
 * About which vehicle, if about one.
 */
vehicle: VehicleId | null, 
/**
 * How urgent.
 */
severity: Severity, 
/**
 * What.
 */
kind: EventKind, 
/**
 * One sentence for the operator.
 */
text: string, };

/**
 * A fault to inject, where the configuration permits it.
 */
export type Fault = { "fault": "plugin_panic", 
/**
 * The vehicle.
 */
vehicle: VehicleId, } | { "fault": "plugin_hang", 
/**
 * The vehicle.
 */
vehicle: VehicleId, } | { "fault": "vehicle_actor", 
/**
 * The vehicle.
 */
vehicle: VehicleId, } | { "fault": "coordinator" };

/**
 * The fence, for display. The gate in the node keeps it, not the browser.
 */
export type FenceInfo = { 
/**
 * Corners as metres north and east of the swarm's origin.
 */
polygon_m: Array<[number, number]>, 
/**
 * Lowest height above the swarm's origin in metres.
 */
floor_m: number, 
/**
 * Greatest height above the swarm's origin in metres.
 */
ceiling_m: number, };

/**
 * What is said of the fleet at a slow rate: everything that is not in the binary frame.
 */
export type FleetInfo = { 
/**
 * The swarm's common frame, once known.
 */
frame: SwarmFrame | null, 
/**
 * Vehicles by ascending id.
 */
vehicles: Array<VehicleInfo>, 
/**
 * Vehicles that are heard but not flown, and why.
 */
unadopted: Array<UnadoptedVehicle>, 
/**
 * The formation being flown, if any.
 */
formation: FormationSnapshot | null, 
/**
 * Actors of the node under supervision.
 */
actors: Array<ActorHealth>, 
/**
 * The fence, if there is one.
 */
fence: FenceInfo | null, 
/**
 * Whether faults may be injected here.
 */
faults_enabled: boolean, };

/**
 * The fleet at one moment.
 */
export type FleetSnapshot = { 
/**
 * When it was made, on the node's clock.
 */
time: NodeTime, 
/**
 * Grows with every snapshot.
 */
sequence: number, 
/**
 * The swarm's common frame, once known.
 */
frame: SwarmFrame | null, 
/**
 * Adopted vehicles by ascending id.
 */
vehicles: Array<VehicleSnapshot>, 
/**
 * Vehicles that are heard but not flown, and why.
 */
unadopted: Array<UnadoptedVehicle>, 
/**
 * The formation being flown, if any.
 */
formation: FormationSnapshot | null, 
/**
 * Actors of the node under supervision.
 */
actors: Array<ActorHealth>, };

/**
 * The autopilot's flight mode, in words that fit PX4 and its peers.
 */
export type FlightMode = "unknown" | "manual" | "altitude" | "position" | "acro" | "stabilized" | "offboard" | "ready" | "take_off" | "hold" | "mission" | "return" | "land" | "descend" | "termination";

/**
 * Where a vehicle stands in its flight, as its UAV-model plugin decides it.
 */
export type FlightState = "idle" | "arming" | "taking_off" | "holding" | "going_to" | "following" | "leading" | "returning" | "landing" | "pilot_control" | "faulted";

/**
 * The formation, if one is flown.
 */
export type FormationAnswer = { 
/**
 * Null if none is flown.
 */
formation: FormationSnapshot | null, };

/**
 * What a change of formation will look like.
 */
export type FormationReceipt = { 
/**
 * Who leads.
 */
leader: VehicleId, 
/**
 * Who takes part, leader first.
 */
members: Array<VehicleId>, 
/**
 * How long the change takes in seconds.
 */
duration_s: number, 
/**
 * Smallest distance between any two vehicles on the way, in metres.
 */
planned_min_distance_m: number, };

/**
 * A formation as an operator asks for it.
 */
export type FormationRequest = { 
/**
 * The shape.
 */
shape: Shape, 
/**
 * Distance between neighbours in metres.
 */
spacing_m: number, 
/**
 * Heading; automatic if left out.
 */
heading: HeadingRequest, 
/**
 * Each next slot is this much higher, in metres; 0 = all level.
 */
altitude_step_m: number, 
/**
 * Who leads; the present leader, or else the lowest id, if left out.
 */
leader: VehicleId | null, 
/**
 * Who takes part; every available vehicle in the air if left out.
 */
members: Array<VehicleId> | null, };

/**
 * The formation being flown.
 */
export type FormationSnapshot = { 
/**
 * What was asked for, with the defaults filled in.
 */
request: FormationRequest, 
/**
 * Who leads.
 */
leader: VehicleId, 
/**
 * Who takes part, leader first.
 */
members: Array<VehicleId>, 
/**
 * The leader's route, if one is being flown.
 */
route: Route | null, 
/**
 * Whether the leader has come to the end of its route.
 */
route_finished: boolean, 
/**
 * When all are to be in their slots.
 */
settled_at: NodeTime, 
/**
 * Smallest distance between any two vehicles that the plan of the change foresees, in metres.
 */
planned_min_distance_m: number, 
/**
 * Intent version of the last change.
 */
intent_version: number, };

/**
 * A place on Earth: WGS 84 degrees and metres above mean sea level.
 */
export type Geodetic = { 
/**
 * Latitude in degrees, north positive.
 */
latitude_deg: number, 
/**
 * Longitude in degrees, east positive.
 */
longitude_deg: number, 
/**
 * Altitude above mean sea level in metres.
 */
altitude_amsl_m: number, };

/**
 * Satellite navigation, as reported.
 */
export type Gnss = { 
/**
 * Kind of fix.
 */
fix: GnssFix, 
/**
 * Satellites used.
 */
satellites: number, 
/**
 * Horizontal dilution or accuracy as reported, in metres where known.
 */
horizontal_accuracy_m: number | null, };

/**
 * Kind of satellite fix.
 */
export type GnssFix = "unknown" | "none" | "two_d" | "three_d" | "dgps" | "rtk_float" | "rtk_fixed";

/**
 * How the heading of a formation is chosen, as an operator asks for it.
 */
export type HeadingRequest = { "kind": "auto" } | { "kind": "course" } | { "kind": "fixed", 
/**
 * Heading in degrees clockwise from north.
 */
heading_deg: number, };

/**
 * How the node is, with the facts.
 */
export type Health = { 
/**
 * In one word.
 */
status: HealthStatus, 
/**
 * Node time: how long the node has been running, in microseconds.
 */
time: NodeTime, 
/**
 * Age of the newest picture of the fleet, in seconds.
 */
snapshot_age_s: number, 
/**
 * How many vehicles are flown by this node.
 */
vehicles: number, 
/**
 * How many of them are heard.
 */
vehicles_connected: number, 
/**
 * How many are heard but not flown.
 */
vehicles_unadopted: number, 
/**
 * Actors and model instances that are not running.
 */
not_running: Array<ActorHealth>, };

/**
 * How the node is.
 */
export type HealthStatus = "ok" | "degraded" | "stalled";

/**
 * How many times an actor or plugin instance has been started, from 1. A message that carries an older one is stale.
 */
export type Incarnation = number;

/**
 * Whether the vehicle stands on the ground, as its own detector says.
 */
export type LandedState = "unknown" | "on_ground" | "in_air" | "taking_off" | "landing";

/**
 * State of the link to one vehicle, measured by this node.
 */
export type LinkHealth = { 
/**
 * Frames arrive. False from the moment the link is declared lost until it is regained.
 */
connected: boolean, 
/**
 * When the last frame of this vehicle arrived.
 */
last_heard: NodeTime, 
/**
 * Share of frames lost on the way here, 0..=1, over the last seconds, from the sequence numbers.
 */
loss: number, 
/**
 * Round-trip time in seconds, smoothed (TIMESYNC or command acknowledgement).
 */
round_trip_s: number | null, 
/**
 * Autopilot clock minus node clock in seconds.
 */
clock_offset_s: number | null, 
/**
 * Frames per second received.
 */
receive_rate_hz: number, 
/**
 * Setpoints per second sent; 0 when not streaming.
 */
setpoint_rate_hz: number, };

/**
 * A moment on the node's monotonic clock, in microseconds since the node started.
 */
export type NodeTime = number;

/**
 * A plugin that was found, for screens.
 */
export type PluginInfo = { 
/**
 * Its name.
 */
name: string, 
/**
 * Its version.
 */
version: string, 
/**
 * What it is for.
 */
description: string, 
/**
 * The file it was loaded from.
 */
path: string, 
/**
 * JSON Schema of its configuration, as text.
 */
config_schema_json: string, };

/**
 * Plugins that were found.
 */
export type PluginList = { 
/**
 * Those that can be used.
 */
plugins: Array<PluginInfo>, 
/**
 * Files that look like plugins and were not taken, and why.
 */
problems: Array<string>, };

/**
 * A position in the swarm's common frame: metres north, east and down of its origin.
 */
export type PositionNed = { 
/**
 *First axis, in metres.
 */
north_m: number, 
/**
 *Second axis, in metres.
 */
east_m: number, 
/**
 *Third axis, in metres.
 */
down_m: number, };

/**
 * A typed refusal. Its display text is the sentence an operator reads.
 */
export type Refusal = { "reason": "unknown_vehicle", 
/**
 * The id asked for.
 */
vehicle: VehicleId, } | { "reason": "link_lost", 
/**
 * Its id.
 */
vehicle: VehicleId, } | { "reason": "wrong_state", 
/**
 * The state the vehicle is in.
 */
state: FlightState, 
/**
 * The command's name.
 */
command: string, } | { "reason": "pilot_in_control" } | { "reason": "not_ready_to_arm", 
/**
 * What the autopilot says.
 */
detail: string, } | { "reason": "autopilot", 
/**
 * The result of the acknowledgement, for example `temporarily_rejected`.
 */
result: string, 
/**
 * Status text sent beside it, empty if none came.
 */
text: string, } | { "reason": "timed_out", 
/**
 * What was waited for.
 */
what: string, 
/**
 * For how long, in seconds.
 */
after_s: number, } | { "reason": "superseded" } | { "reason": "outside_fence", 
/**
 * Which limit, with value and limit.
 */
detail: string, } | { "reason": "too_fast", 
/**
 * Asked speed in metres per second.
 */
speed_m_s: number, 
/**
 * The limit in metres per second.
 */
limit_m_s: number, } | { "reason": "too_close", 
/**
 * The other vehicle.
 */
other: VehicleId, 
/**
 * Predicted distance in metres.
 */
distance_m: number, 
/**
 * The limit in metres.
 */
limit_m: number, } | { "reason": "invalid_value", 
/**
 * Which value and what would be right.
 */
detail: string, } | { "reason": "no_swarm_frame" } | { "reason": "no_position" } | { "reason": "not_enough_vehicles", 
/**
 * Available.
 */
have: number, 
/**
 * Needed.
 */
need: number, } | { "reason": "stale_incarnation", 
/**
 * What the message carried.
 */
got: Incarnation, 
/**
 * What is running.
 */
current: Incarnation, } | { "reason": "duplicate_system_id", 
/**
 * The system id.
 */
system_id: number, } | { "reason": "not_running", 
/**
 * Which part.
 */
what: string, } | { "reason": "not_permitted", 
/**
 * What and why.
 */
detail: string, };

/**
 * A leader's route in the swarm frame, flown with rounded corners at one speed.
 */
export type Route = { 
/**
 * Corners to pass, then the end. The route starts where the leader is.
 */
waypoints: Array<PositionNed>, 
/**
 * Speed along it in metres per second.
 */
speed_m_s: number, 
/**
 * Radius of the rounded corners in metres.
 */
corner_radius_m: number, };

/**
 * A route for the leader.
 */
export type RouteBody = { 
/**
 * The route.
 */
route: Route, };

/**
 * What the server says on the stream as text. Readers skip types they do not know.
 */
export type ServerMessage = { "type": "hello", 
/**
 * Version of these messages and of the binary frame.
 */
protocol: number, 
/**
 * Version of the program.
 */
version: string, 
/**
 * Name of the node.
 */
node: string, } | { "type": "fleet" } & FleetInfo | { "type": "event" } & EventRecord | { "type": "gap", 
/**
 * How many.
 */
missed: number, } | { "type": "rate", 
/**
 * Frames per second.
 */
rate_hz: number, } | { "type": "error", 
/**
 * Why.
 */
error: ErrorDetail, };

/**
 * How urgent a notice is.
 */
export type Severity = "info" | "advisory" | "warning" | "critical";

/**
 * The outline of a formation.
 */
export type Shape = "line" | "column" | "wedge" | "circle" | "grid";

/**
 * The swarm's one common frame: north-east-down about a geodetic origin that all members share.
 */
export type SwarmFrame = { 
/**
 * The shared origin.
 */
origin: Geodetic, };

/**
 * MAVLink system id: 1..=255, unique on one link only.
 */
export type SystemId = number;

/**
 * Whom a command is for.
 */
export type Targets = "all" | { "vehicles": Array<VehicleId> };

/**
 * A vehicle that is heard but not flown.
 */
export type UnadoptedVehicle = { 
/**
 * Its system id.
 */
system_id: SystemId, 
/**
 * The endpoint it is heard on.
 */
endpoint: string, 
/**
 * Why it is not flown, one sentence.
 */
why: string, };

/**
 * What an operator, the coordinator or another program may ask of one vehicle.
 */
export type VehicleCommand = { "command": "arm" } | { "command": "disarm" } | { "command": "take_off", 
/**
 * Height above the launch place in metres.
 */
height_m: number, } | { "command": "land" } | { "command": "land_at", 
/**
 * The landing spot in the swarm frame; its height is that of the ground.
 */
spot: PositionNed, } | { "command": "hold" } | { "command": "return" } | { "command": "go_to", 
/**
 * The place in the swarm frame.
 */
position: PositionNed, 
/**
 * Yaw on the way and there, in radians; unchanged if left out.
 */
yaw_rad: number | null, 
/**
 * Speed in metres per second; the model's cruise speed if left out.
 */
speed_m_s: number | null, };

/**
 * A vehicle of the swarm, unique over all links. By default equal to its MAVLink system id.
 */
export type VehicleId = number;

/**
 * What changes seldom about one vehicle.
 */
export type VehicleInfo = { 
/**
 * The swarm's id for it.
 */
id: VehicleId, 
/**
 * Its name.
 */
name: string, 
/**
 * MAVLink system id on its link.
 */
system_id: SystemId, 
/**
 * Name of the UAV-model plugin that flies it.
 */
plugin: string, 
/**
 * Version of that plugin.
 */
plugin_version: string, 
/**
 * Why it is in its flight state; may be empty.
 */
state_detail: string, 
/**
 * Launch place.
 */
home: Geodetic | null, 
/**
 * Its actor.
 */
actor: ActorHealth, 
/**
 * Its UAV-model plugin instance.
 */
model: ActorHealth, };

/**
 * One vehicle as the swarm sees it: telemetry in the common frame. What peers, plugins and screens read.
 */
export type VehicleKinematics = { 
/**
 * Position in the swarm frame.
 */
position: PositionNed, 
/**
 * Velocity.
 */
velocity: VelocityNed, 
/**
 * Yaw in radians, clockwise from north.
 */
yaw_rad: number, 
/**
 * When it was measured.
 */
measured: NodeTime, };

/**
 * All vehicles at one moment.
 */
export type VehicleList = { 
/**
 * When.
 */
time: NodeTime, 
/**
 * Those that are flown, by ascending id.
 */
vehicles: Array<VehicleSnapshot>, 
/**
 * Those that are heard but not flown.
 */
unadopted: Array<UnadoptedVehicle>, };

/**
 * One vehicle at one moment.
 */
export type VehicleSnapshot = { 
/**
 * The swarm's id for it.
 */
id: VehicleId, 
/**
 * Its name from the adoption rule.
 */
name: string, 
/**
 * MAVLink system id on its link.
 */
system_id: SystemId, 
/**
 * Name of the UAV-model plugin that flies it.
 */
plugin: string, 
/**
 * Version of that plugin.
 */
plugin_version: string, 
/**
 * Flight state as the model decides it.
 */
flight_state: FlightState, 
/**
 * Why it is in that state; may be empty.
 */
state_detail: string, 
/**
 * Autopilot mode.
 */
mode: FlightMode, 
/**
 * Motors armed.
 */
armed: boolean, 
/**
 * On the ground or in the air.
 */
landed: LandedState, 
/**
 * Whether the autopilot would arm; `None` until it says.
 */
ready_to_arm: boolean | null, 
/**
 * Place on Earth.
 */
global: Geodetic | null, 
/**
 * Position, velocity, yaw in the swarm frame.
 */
kinematics: VehicleKinematics | null, 
/**
 * Roll in radians.
 */
roll_rad: number, 
/**
 * Pitch in radians.
 */
pitch_rad: number, 
/**
 * Launch place.
 */
home: Geodetic | null, 
/**
 * Battery.
 */
battery: Battery, 
/**
 * Satellite navigation.
 */
gnss: Gnss, 
/**
 * Link measured by this node.
 */
link: LinkHealth, 
/**
 * Seconds since the last frame was heard.
 */
age_s: number, 
/**
 * Where its task wants it now.
 */
slot: PositionNed | null, 
/**
 * Distance to that place in metres.
 */
tracking_error_m: number | null, 
/**
 * Whether it leads.
 */
is_leader: boolean, 
/**
 * Its actor.
 */
actor: ActorHealth, 
/**
 * Its UAV-model plugin instance.
 */
model: ActorHealth, };

/**
 * A velocity along north, east and down.
 */
export type VelocityNed = { 
/**
 *First axis, in metres per second.
 */
north_m_s: number, 
/**
 *Second axis, in metres per second.
 */
east_m_s: number, 
/**
 *Third axis, in metres per second.
 */
down_m_s: number, };

/**
 * Which program, which version, which node.
 */
export type VersionInfo = { 
/**
 * Always `skein`.
 */
program: string, 
/**
 * Version of the program.
 */
version: string, 
/**
 * Name of the node.
 */
node: string, 
/**
 * Version of the stream's messages and of the binary frame.
 */
protocol: number, };
