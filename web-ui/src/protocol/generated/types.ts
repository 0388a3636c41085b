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
 * Which alerts an operator has seen.
 */
export type AcknowledgeBody = { 
/**
 * Their numbers.
 */
events: number[], };

/**
 * What came of it.
 */
export type Acknowledged = { 
/**
 * How many of them are alerts that are still kept and that nobody had seen before.
 */
alerts: number, };

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
 * One trigger that lasts.
 */
export type Alarm = { 
/**
 * Which.
 */
trigger: Trigger, 
/**
 * The newest value, in `unit`.
 */
value: number, 
/**
 * The limit it went beyond, in `unit`.
 */
limit: number, 
/**
 * Unit of both.
 */
unit: string, 
/**
 * Since when.
 */
since: NodeTime, 
/**
 * The reaction of the step it has come to.
 */
reaction: Reaction, 
/**
 * Why nothing is done about it; absent if something is.
 */
report_only: ReportOnly | null, };

/**
 * What floor and ceiling of a zone count from.
 */
export type AltitudeReference = "origin" | "amsl";

/**
 * An archive with a version for one kind of processor.
 */
export type ArchiveInfo = { 
/**
 * SHA-256 of the whole archive.
 */
digest: string, 
/**
 * As it was packed.
 */
version: string, 
/**
 * For which processor.
 */
architecture: string, 
/**
 * Its size.
 */
bytes: number, 
/**
 * The size of what is in it.
 */
unpacked_bytes: number, };

/**
 * A vehicle that was asked to keep a track in view, and what it answered.
 */
export type AskedObserver = { 
/**
 * From which side it is to look: the bearing from the track to the vehicle, in radians clockwise from north.
 */
bearing_rad: number, 
/**
 * Its answer.
 */
receipt: CommandReceipt, };

/**
 * Who was asked to keep a track in view.
 */
export type AskedObserverList = { 
/**
 * The track.
 */
track: number, 
/**
 * Each with its answer; some or all may be refusals.
 */
asked: Array<AskedObserver>, };

/**
 * A log on an autopilot's own card.
 */
export type AutopilotLog = { 
/**
 * Its number there. It may be another one after the autopilot has restarted or a log was deleted.
 */
number: number, 
/**
 * Its size in bytes.
 */
size_bytes: number, 
/**
 * When it was written last, in seconds since 1970 by the autopilot's clock; absent if that had no time.
 */
written_unix_s: number | null, };

/**
 * Logs on an autopilot's card.
 */
export type AutopilotLogList = { 
/**
 * By their numbers.
 */
logs: Array<AutopilotLog>, };

/**
 * What is changed of a vehicle's setpoints at a moment, to keep it off others or inside of a fence.
 */
export type Avoidance = { 
/**
 * How far the flown velocity is from the wanted one, in metres per second.
 */
by_m_s: number, 
/**
 * Because of whom, in words; absent if because of a fence.
 */
because: string | null, 
/**
 * How far that is away now, in metres.
 */
distance_m: number | null, 
/**
 * How near the wanted velocity would have come, in metres.
 */
predicted_m: number | null, 
/**
 * Whether the distance can be kept. If not, the vehicle is kept as far away as it can be.
 */
feasible: boolean, };

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
 * What a vehicle does that is where a zone does not let it be.
 */
export type BreachAction = "warn" | "hold" | "return" | "land";

/**
 * Where a vehicle that has left a fence is to come back to, as some ground stations let operators set.
 */
export type BreachReturn = { 
/**
 * The place.
 */
place: MapPoint, 
/**
 * Height above the swarm's origin in metres, if given.
 */
height_m: number | null, };

/**
 * What a camera can be asked.
 */
export type CameraCommand = { "command": "take_pictures", 
/**
 * How many; 0 until told to stop.
 */
count: number, 
/**
 * Time between two, in seconds.
 */
interval_s: number, } | { "command": "stop_pictures" } | { "command": "start_recording" } | { "command": "stop_recording" } | { "command": "zoom", 
/**
 * The factor.
 */
factor: number, } | { "command": "set_mode", 
/**
 * The mode.
 */
mode: CameraMode, } | { "command": "start_stream", 
/**
 * Its number, from 1.
 */
stream: number, } | { "command": "stop_stream", 
/**
 * Its number, from 1.
 */
stream: number, };

/**
 * The mode of a camera.
 */
export type CameraMode = "picture" | "video" | "survey";

/**
 * Where a camera was and looked when it took a frame.
 */
export type CameraPose = { 
/**
 * Position in the swarm frame.
 */
position: PositionNed, 
/**
 * Roll of the picture in radians.
 */
roll_rad: number, 
/**
 * Pitch of the optical axis in radians, upwards positive.
 */
pitch_rad: number, 
/**
 * Yaw of the optical axis in radians, clockwise from north.
 */
yaw_rad: number, 
/**
 * Horizontal field of view in radians.
 */
field_of_view_rad: number, };

/**
 * The state of a camera.
 */
export type CameraState = { 
/**
 * It is heard, or its source delivers.
 */
connected: boolean, 
/**
 * Who made it.
 */
vendor: string, 
/**
 * What it is.
 */
model: string, 
/**
 * Mode.
 */
mode: CameraMode, 
/**
 * Pictures are being taken at an interval.
 */
capturing: boolean, 
/**
 * Pictures taken so far.
 */
pictures: number, 
/**
 * It records.
 */
recording: boolean, 
/**
 * For how long, in seconds.
 */
recording_s: number, 
/**
 * Zoom factor, 1 being the widest.
 */
zoom: number | null, 
/**
 * Room left on its storage in mebibytes.
 */
storage_free_mib: number | null, 
/**
 * Size of its storage in mebibytes.
 */
storage_total_mib: number | null, 
/**
 * Width of its pictures in pixels.
 */
width_px: number | null, 
/**
 * Height of its pictures in pixels.
 */
height_px: number | null, 
/**
 * Horizontal field of view in radians at the present zoom.
 */
field_of_view_rad: number | null, 
/**
 * Frames it has given since it was started.
 */
frames: number, 
/**
 * Streams it offers.
 */
streams: Array<CameraStream>, 
/**
 * What is wrong with it; empty if nothing.
 */
fault: string, };

/**
 * One video stream of a camera.
 */
export type CameraStream = { 
/**
 * Its number, from 1.
 */
stream: number, 
/**
 * Name.
 */
name: string, 
/**
 * Where it can be read.
 */
uri: string, 
/**
 * It runs.
 */
running: boolean, 
/**
 * Frames per second.
 */
rate_hz: number, 
/**
 * Width in pixels.
 */
width_px: number, 
/**
 * Height in pixels.
 */
height_px: number, };

/**
 * Where one camera is and looks.
 */
export type CameraView = { 
/**
 * The vehicle that carries it.
 */
vehicle: VehicleId, 
/**
 * Its name on the vehicle.
 */
payload: string, 
/**
 * Where it is and looks, in the swarm frame.
 */
pose: CameraPose, 
/**
 * Width of its pictures in pixels.
 */
width_px: number, 
/**
 * Height of its pictures in pixels.
 */
height_px: number, 
/**
 * How this is known.
 */
known_from: ViewSource, 
/**
 * Seconds since it was so.
 */
age_s: number, };

/**
 * Where the cameras of all vehicles look, as far as that is known.
 */
export type CameraViewList = { 
/**
 * Now, on the node's clock.
 */
time: NodeTime, 
/**
 * One for each camera of which it is known where it looks, by vehicle.
 */
views: Array<CameraView>, };

/**
 * What a client may say on the stream as text.
 */
export type ClientMessage = { "type": "rate", 
/**
 * Frames per second, 1 to 50.
 */
rate_hz: number, } | { "type": "stick", 
/**
 * The vehicle.
 */
vehicle: VehicleId, 
/**
 * Forward in metres per second.
 */
forward_m_s: number, 
/**
 * To the right in metres per second.
 */
right_m_s: number, 
/**
 * Up in metres per second.
 */
up_m_s: number, 
/**
 * Turning clockwise as seen from above, in radians per second.
 */
yaw_rate_rad_s: number, };

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
 * One place from which vehicles are commanded: a page in a browser, a program.
 */
export type Console = { 
/**
 * Tells it from all others; drawn by the console itself.
 */
id: string, 
/**
 * What people call who sits there.
 */
name: string, };

/**
 * What a console wants with vehicles.
 */
export type ControlAction = { "action": "take" } | { "action": "request" } | { "action": "release" } | { "action": "hand_over", 
/**
 * Its id.
 */
to: string, };

/**
 * What a console wants with which vehicles.
 */
export type ControlBody = { 
/**
 * Which.
 */
targets: Targets, 
/**
 * Who.
 */
console: Console, 
/**
 * What.
 */
action: ControlAction, };

/**
 * What came of it at one vehicle.
 */
export type ControlReceipt = { 
/**
 * The vehicle.
 */
vehicle: VehicleId, 
/**
 * Why not, if so.
 */
refusal: Refusal | null, };

/**
 * What came of it, vehicle by vehicle.
 */
export type ControlReceipts = { 
/**
 * One for each vehicle it was for.
 */
receipts: Array<ControlReceipt>, };

/**
 * A console that asks for a vehicle which another one has.
 */
export type ControlRequest = { 
/**
 * Who asks.
 */
console: Console, 
/**
 * Since when.
 */
since: NodeTime, };

/**
 * Who has control authority over which vehicles.
 */
export type ControlState = { 
/**
 * When.
 */
time: NodeTime, 
/**
 * Those that somebody has, by ascending id.
 */
vehicles: Array<VehicleControl>, };

/**
 * Which node is to coordinate.
 */
export type CoordinatorBody = { 
/**
 * Its number.
 */
node: NodeId, };

/**
 * Whether a vehicle can host the coordinator, and how gladly.
 */
export type CoordinatorCapability = { 
/**
 * It can, as things stand.
 */
capable: boolean, 
/**
 * The greatest takes over first.
 */
priority: number, };

/**
 * The operator's dead-man's switch.
 */
export type DeadMan = { 
/**
 * How it stands.
 */
state: DeadManState, 
/**
 * After how many seconds without a sign of life vehicles in the air begin to react; absent if they never do.
 */
warns_after_s: number | null, };

/**
 * How a dead-man's switch stands.
 */
export type DeadManState = "off" | "unheard" | "heard" | "silent";

/**
 * What became of detections that were told.
 */
export type Detected = { 
/**
 * So many were taken.
 */
taken: number, 
/**
 * So many were not, because too much waits already.
 */
refused: number, };

/**
 * A direction from a place.
 */
export type DetectedBearing = { 
/**
 * Where the sensor is, in the swarm frame.
 */
origin: PositionNed, 
/**
 * How well that is known: one standard deviation along each axis, in metres; half a metre if left out.
 */
origin_error_m: number | null, 
/**
 * Clockwise from north, in radians.
 */
azimuth_rad: number, 
/**
 * Above the horizon, in radians.
 */
elevation_rad: number, 
/**
 * One standard deviation of the direction, in radians.
 */
error_rad: number, };

/**
 * Something that a radar, a radio direction finder or another sensor has seen once. It says a position or a bearing, and not both.
 */
export type Detection = { 
/**
 * What the sensor calls the thing, if it follows it; what it names once it must not use for another thing soon.
 */
id: number | null, 
/**
 * How long ago that was, in seconds.
 */
age_s: number, 
/**
 * What it is taken for, for example `drone`.
 */
class: string | null, 
/**
 * How sure that is, 0..=1; 1 if left out.
 */
score: number | null, 
/**
 * Where it is, in the swarm frame.
 */
position: PositionNed | null, 
/**
 * Covariance of the position along north, east and down, in square metres: north-north, north-east, north-down, east-east, east-down, down-down. Five
 * metres along each axis if left out.
 */
covariance_m2: [number, number, number, number, number, number] | null, 
/**
 * In which direction it is.
 */
bearing: DetectedBearing | null, };

/**
 * What a radar, a radio direction finder or another sensor has seen.
 */
export type DetectionsBody = { 
/**
 * Names the sensor: what it names stays the same as long as the source is the same.
 */
source: string, 
/**
 * What it saw.
 */
detections: Array<Detection>, };

/**
 * The state of a detector: what it found in the last picture that it has looked at. A detector may say more beside it.
 */
export type DetectorState = { 
/**
 * The vehicle's camera whose picture it was; empty if it has but one.
 */
camera: string, 
/**
 * When the picture was taken, on the node's clock.
 */
time: NodeTime, 
/**
 * Width of the picture in pixels; 0 if the detector does not say.
 */
width_px: number, 
/**
 * Height of the picture in pixels; 0 if the detector does not say.
 */
height_px: number, 
/**
 * Where the camera was and looked, as the picture's header said; without it nobody knows in which direction a finding is.
 */
pose: CameraPose | null, 
/**
 * What is in it.
 */
findings: Array<Finding>, };

/**
 * The key of the second step.
 */
export type EmergencyKey = { 
/**
 * To be given with the stop itself. Good for any number of vehicles until its time is over.
 */
key: string, 
/**
 * For how long it is good, in seconds.
 */
valid_s: number, };

/**
 * The second step of the emergency stop.
 */
export type EmergencyStopBody = { 
/**
 * The key of the first step.
 */
key: string, 
/**
 * Whose motors are stopped.
 */
targets: Targets, };

/**
 * What came and went over one endpoint since the node began.
 */
export type EndpointReport = { 
/**
 * Its name.
 */
name: string, 
/**
 * The local address, once it is bound; absent for serial lines.
 */
address: string | null, 
/**
 * Bytes received.
 */
bytes_in: number, 
/**
 * Frames received whole.
 */
frames_in: number, 
/**
 * Bytes sent.
 */
bytes_out: number, 
/**
 * Frames sent.
 */
frames_out: number, 
/**
 * Frames that came damaged: a wrong checksum, cut off, or with values that mean nothing.
 */
damaged: number, 
/**
 * Frames with a vehicle's system id from another place than the vehicle's.
 */
foreign: number, 
/**
 * Frames of systems that this node does not fly.
 */
unadopted: number, 
/**
 * Frames that could not be sent.
 */
dropped: number, };

/**
 * How urgent it is, in order of urgency.
 */
export type EnergyLevel = "ok" | "replan_soon" | "return_now" | "land_now";

/**
 * A vehicle's charge against its way home. Shares are of a full battery.
 */
export type EnergyState = { 
/**
 * What is left, 0..=1.
 */
remaining: number, 
/**
 * What the way home and the landing there cost, with the allowance for the model's error; absent if it cannot get home against
 * the wind at all.
 */
needed_home: number | null, 
/**
 * What must be left after landing.
 */
reserve: number, 
/**
 * What is left over: remaining less needed and reserve; negative when the reserve is touched. Less the reserve only, if home
 * cannot be reached.
 */
margin: number, 
/**
 * Time until empty at the present consumption, in seconds.
 */
endurance_s: number, 
/**
 * Time until it must return, if it goes on as now, in seconds; 0 if it must already.
 */
return_in_s: number, 
/**
 * How urgent it is.
 */
level: EnergyLevel, 
/**
 * The consumption is this vehicle's own; false while it is still the configured one.
 */
learned: boolean, 
/**
 * Speed over the ground on the way home in metres per second; 0 if it cannot get home against the wind.
 */
ground_speed_home_m_s: number, };

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
detail: unknown, 
/**
 * With the refusal of a body: one that would be taken.
 */
example?: unknown, };

/**
 * What becomes of a vehicle when one of its payloads has failed too often.
 */
export type Escalation = "degrade" | "hold" | "return";

/**
 * What kind of thing happened.
 */
export type EventKind = { "kind": "adopted" } | { "kind": "not_adopted" } | { "kind": "link_lost" } | { "kind": "link_regained" } | { "kind": "autopilot_rebooted" } | { "kind": "taken_over", 
/**
 * By its autopilot's own failsafe; else by a pilot or another ground station.
 */
failsafe: boolean, 
/**
 * The mode that was left.
 */
from: FlightMode, 
/**
 * The mode it is in now.
 */
to: FlightMode, } | { "kind": "flight_state", 
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
refusal: Refusal, } | { "kind": "failsafe", 
/**
 * What.
 */
event: FailsafeEvent, } | { "kind": "avoidance" } | { "kind": "fences" } | { "kind": "preflight" } | { "kind": "emergency_stop" } | { "kind": "parameter", 
/**
 * Its name.
 */
name: string, } | { "kind": "formation" } | { "kind": "trajectory" } | { "kind": "supervision", 
/**
 * Name in the supervision tree.
 */
actor: string, 
/**
 * What it is doing now.
 */
status: ActorStatus, } | { "kind": "stream" } | { "kind": "track", 
/**
 * Its number.
 */
track: number, } | { "kind": "status_text" } | { "kind": "occurrence", 
/**
 * The payload's name on the vehicle; absent for the UAV model.
 */
payload: string | null, 
/**
 * What it tells.
 */
event: unknown, } | { "kind": "payload", 
/**
 * Its name on the vehicle.
 */
payload: string, } | { "kind": "plugin", 
/**
 * Its name.
 */
plugin: string, } | { "kind": "swarm" } | { "kind": "overrun", 
/**
 * By how much, in seconds.
 */
by_s: number, } | { "kind": "overrun_ended" } | { "kind": "recorder" } | { "kind": "acknowledged", 
/**
 * Their numbers, at this node.
 */
events: number[], } | { "kind": "notice" };

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
 * On which other node of the swarm; absent if on this one.
 */
node: NodeId | null, 
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
 * One thing that the failsafe policy of a vehicle noticed or did.
 */
export type FailsafeEvent = { 
/**
 * What it says.
 */
kind: FailsafeEventKind, 
/**
 * Because of what.
 */
trigger: Trigger, 
/**
 * The measured value, in `unit`.
 */
value: number, 
/**
 * The limit that it is beyond, in `unit`.
 */
limit: number, 
/**
 * Unit of value and limit: `s`, `m`, or empty.
 */
unit: string, 
/**
 * Since when it has been so.
 */
since: NodeTime, 
/**
 * When this was decided.
 */
at: NodeTime, 
/**
 * The reaction of this step; of an `ordered` one what is to be done.
 */
reaction: Reaction, 
/**
 * Why nothing is done about it; absent if something is.
 */
report_only: ReportOnly | null, 
/**
 * The sentence an operator reads.
 */
reason: string, };

/**
 * What an event of the failsafe policy says.
 */
export type FailsafeEventKind = "raised" | "escalated" | "ordered" | "effective" | "ineffective" | "cleared" | "ended" | "taken_up";

/**
 * How far the failsafe policy of a vehicle has come, for screens.
 */
export type FailsafeState = { 
/**
 * What lasts, in the order of the written table.
 */
alarms: Array<Alarm>, 
/**
 * What it is under; nothing if it flies freely.
 */
order: Order | null, };

/**
 * A fault to inject, where the configuration permits it. A plugin is the vehicle's UAV model, or with a name its payload.
 */
export type Fault = { "fault": "plugin_panic", 
/**
 * The vehicle.
 */
vehicle: VehicleId, 
/**
 * The payload; the UAV model if left out.
 */
payload: string | null, } | { "fault": "plugin_hang", 
/**
 * The vehicle.
 */
vehicle: VehicleId, 
/**
 * The payload; the UAV model if left out.
 */
payload: string | null, } | { "fault": "plugin_kill", 
/**
 * The vehicle.
 */
vehicle: VehicleId, 
/**
 * The payload; the UAV model if left out.
 */
payload: string | null, } | { "fault": "vehicle_actor", 
/**
 * The vehicle.
 */
vehicle: VehicleId, } | { "fault": "coordinator" } | { "fault": "coordinator_away", 
/**
 * It is away; false lets it come back.
 */
away: boolean, };

/**
 * The fences in force.
 */
export type FenceAnswer = { 
/**
 * As they were described.
 */
plan: FencePlan, 
/**
 * Vehicles in the air that are outside of them now, and what they do about it stands with each fence.
 */
outside: Array<VehicleId>, };

/**
 * A file with fences.
 */
export type FenceFileBody = { 
/**
 * Its name, for messages and for zones without a name.
 */
name: string | null, 
/**
 * Its text: GeoJSON, or a plan of QGroundControl.
 */
text: string, };

/**
 * All zones of a swarm. A vehicle may be where at least one inclusion zone is (anywhere, if there is none) and no exclusion zone.
 */
export type FencePlan = { 
/**
 * The zones.
 */
zones: Array<FenceZone>, 
/**
 * Where to come back to.
 */
breach_return: BreachReturn | null, };

/**
 * Fences to be put in force.
 */
export type FencePlanBody = { 
/**
 * All zones; none to fly without a fence.
 */
plan: FencePlan, };

/**
 * One zone.
 */
export type FenceZone = { 
/**
 * Name shown to people and in refusals.
 */
name: string, 
/**
 * To be stayed in or kept out of.
 */
kind: ZoneKind, 
/**
 * Its outline.
 */
outline: ZoneOutline, 
/**
 * Lowest height in metres; without one it reaches down without end.
 */
floor_m: number | null, 
/**
 * Greatest height in metres; without one it reaches up without end.
 */
ceiling_m: number | null, 
/**
 * What the two count from.
 */
altitude_reference: AltitudeReference, 
/**
 * What becomes of a vehicle that is where it must not be.
 */
action: BreachAction, };

/**
 * Something found in a picture. Pixels count from the picture's left upper corner.
 */
export type Finding = { 
/**
 * What it is taken for, for example `uav`.
 */
class: string, 
/**
 * How sure that is, 0..=1.
 */
score: number, 
/**
 * Middle of the box around it, in pixels from the left.
 */
center_x_px: number, 
/**
 * Middle of the box around it, in pixels from the top.
 */
center_y_px: number, 
/**
 * Width of the box in pixels.
 */
width_px: number, 
/**
 * Height of the box in pixels.
 */
height_px: number, 
/**
 * Names the same thing in later pictures; empty if it is not followed from one to the next.
 */
id: string, 
/**
 * Standard deviation of the middle in pixels; 0 if the detector does not say.
 */
error_px: number, 
/**
 * Seconds since it was last found in a picture: 0 if it was found in this one, more if it is only thought to be there.
 */
coasted_s: number, 
/**
 * What else it may be: the score of each class, 0..=1. Empty if the detector knows but one.
 */
classes: { [key in string]: number }, };

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
 * Whether faults may be injected here.
 */
faults_enabled: boolean, 
/**
 * Whether an operator has to give signs of life, and does.
 */
dead_man: DeadMan, 
/**
 * What an operator is asked after the node ended in flight and has started again.
 */
resume: ResumeQuestion | null, 
/**
 * Whether flights are recorded.
 */
recorder: RecorderStatus, };

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
actors: Array<ActorHealth>, 
/**
 * What is tracked: what was told, and what the swarm made of what its sensors saw.
 */
tracks: Array<TrackEstimate>, 
/**
 * The swarm this node is part of, if it is part of one.
 */
swarm: SwarmSnapshot | null, 
/**
 * What an operator is asked after this node ended in flight and has started again.
 */
resume: ResumeQuestion | null, };

/**
 * Limits of one vehicle's flight. The slowest member decides how fast a formation goes.
 */
export type FlightLimits = { 
/**
 * Largest horizontal speed in metres per second.
 */
max_speed_m_s: number, 
/**
 * Largest climb rate in metres per second.
 */
max_climb_m_s: number, 
/**
 * Largest descent rate in metres per second.
 */
max_descent_m_s: number, 
/**
 * Largest acceleration in metres per second squared.
 */
max_acceleration_m_s2: number, 
/**
 * Smallest radius of a turn at its speed in metres; 0 for one that can turn on the spot.
 */
min_turn_radius_m: number, 
/**
 * How long it can stay in the air with a full battery, in seconds, if known.
 */
endurance_s: number | null, 
/**
 * It carries a camera that looks out of the formation: its slot is chosen so that nobody flies in its view.
 */
keeps_view: boolean, };

/**
 * Recordings on this node.
 */
export type FlightList = { 
/**
 * The newest first.
 */
flights: Array<RecordedFlight>, };

/**
 * The autopilot's flight mode, in words that fit PX4 and its peers.
 */
export type FlightMode = "unknown" | "manual" | "altitude" | "position" | "acro" | "stabilized" | "offboard" | "ready" | "take_off" | "hold" | "mission" | "return" | "land" | "descend" | "termination";

/**
 * Where a vehicle stands in its flight, as its UAV-model plugin decides it.
 */
export type FlightState = "idle" | "arming" | "taking_off" | "holding" | "going_to" | "following" | "leading" | "returning" | "landing" | "pilot_control" | "faulted";

/**
 * From where a vehicle would go into which place of a formation, in metres about the swarm's origin. With a turning formation or a
 * detour around another vehicle the way itself is no straight line.
 */
export type ForeseenWay = { 
/**
 * The vehicle.
 */
vehicle: VehicleId, 
/**
 * Where it is.
 */
from: PositionNed, 
/**
 * Where its place is while the anchor stands where it is.
 */
to: PositionNed, };

/**
 * What a formation's slots are relative to.
 */
export type FormationAnchor = { "kind": "leader" } | { "kind": "path", 
/**
 * The route. It begins where the formation is anchored now: at its first waypoint if it is not anchored yet.
 */
route: Route, } | { "kind": "reference", 
/**
 * Its name, as in the list of references.
 */
name: string, } | { "kind": "place", 
/**
 * The place in the swarm frame.
 */
position: PositionNed, 
/**
 * Heading of the formation there in degrees clockwise from north; the present one if left out.
 */
heading_deg: number | null, };

/**
 * The formation, if one is flown.
 */
export type FormationAnswer = { 
/**
 * Null if none is flown.
 */
formation: FormationSnapshot | null, };

/**
 * Who works out where each vehicle should be.
 */
export type FormationControl = "slots" | "distances" | "bearings";

/**
 * How a change of formation would go if it were begun now.
 */
export type FormationForecast = { 
/**
 * What would be answered.
 */
receipt: FormationReceipt, 
/**
 * Where the formation would look while its anchor stands where it is, in radians clockwise from north.
 */
heading_rad: number, 
/**
 * Who would take which place, leader first.
 */
ways: Array<ForeseenWay>, };

/**
 * Where the places of a formation would be.
 */
export type FormationPreview = { 
/**
 * The places relative to the anchor, the leader's first if a vehicle leads.
 */
slots: Array<OffsetFrd>, 
/**
 * Smallest distance between two of them in metres; null for one alone.
 */
smallest_distance_m: number | null, 
/**
 * From each place, where a camera can look without another vehicle in its picture.
 */
views: Array<SlotView>, 
/**
 * How many of the vehicles carry a camera that is to look out of the formation.
 */
looking: number, 
/**
 * Who would take which place, how long it takes and how close they come on the way, if it were begun now; null if it would be refused.
 */
forecast: FormationForecast | null, 
/**
 * Why it would be refused now: members that are not in the air, a place outside of the fence.
 */
refusal: Refusal | null, };

/**
 * What a change of formation will look like.
 */
export type FormationReceipt = { 
/**
 * Who leads; nobody if it is anchored to something else than a vehicle.
 */
leader: VehicleId | null, 
/**
 * Who takes part, leader first.
 */
members: Array<VehicleId>, 
/**
 * How long the change takes in seconds.
 */
duration_s: number, 
/**
 * Smallest distance between any two vehicles on the way, in metres; null for one alone.
 */
planned_min_distance_m: number | null, 
/**
 * How fast it can go as a whole, in metres per second.
 */
max_speed_m_s: number, 
/**
 * Members that carry a camera and whose places leave it no free view, neither ahead nor outwards.
 */
view_blocked: Array<VehicleId>, };

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
 * The shape is turned by this about its anchor, in degrees clockwise seen from above.
 */
rotation_deg: number, 
/**
 * The shape is made so many times as large, spacing and altitudes included.
 */
scale: number, 
/**
 * For an arc: how much of the circle, in degrees; 180 if left out.
 */
arc_deg: number | null, 
/**
 * For a box: how many layers; as near to a cube as the number allows if left out.
 */
layers: number | null, 
/**
 * For a helix: height gained in one turn, in metres; twice the spacing if left out.
 */
pitch_m: number | null, 
/**
 * For a free shape: the places relative to the anchor, the leader's first. At least as many as vehicles take part.
 */
offsets: Array<OffsetFrd> | null, 
/**
 * What the slots are relative to; the leader if left out.
 */
anchor: FormationAnchor, 
/**
 * Who works out the places; the coordinator if left out.
 */
control: FormationControl, 
/**
 * Who leads; the present leader, or else the first that can in the configured order, if left out.
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
 * Who leads; nobody if it is anchored to something else than a vehicle.
 */
leader: VehicleId | null, 
/**
 * The anchor at this moment.
 */
anchor: PositionNed | null, 
/**
 * Its members keep their places by their neighbours now.
 */
keeps_itself: boolean, 
/**
 * How fast it can go as a whole, in metres per second.
 */
max_speed_m_s: number, 
/**
 * Who takes part, leader first.
 */
members: Array<VehicleId>, 
/**
 * Members that carry a camera and whose places leave it no free view, neither ahead nor outwards.
 */
view_blocked: Array<VehicleId>, 
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
 * Smallest distance between any two vehicles that the plan of the change foresees, in metres; null for one alone.
 */
planned_min_distance_m: number | null, 
/**
 * Intent version of the last change.
 */
intent_version: number, };

/**
 * What is known of a frame beside its bytes. The bytes stay where they are: `id` names them.
 */
export type FrameHeader = { 
/**
 * Names the bytes at the boundary they cross; the host's and only good there.
 */
id: number, 
/**
 * Counts the frames of one source, from 1.
 */
sequence: number, 
/**
 * When it was taken, on the node's clock.
 */
time: NodeTime, 
/**
 * Width in pixels.
 */
width_px: number, 
/**
 * Height in pixels.
 */
height_px: number, 
/**
 * Bytes per row; 0 where rows have no meaning.
 */
stride_bytes: number, 
/**
 * How to read the bytes.
 */
format: PixelFormat, 
/**
 * Number of bytes.
 */
len: number, 
/**
 * Where the camera was and looked, if known.
 */
pose: CameraPose | null, 
/**
 * The camera that took it, by its name on the vehicle: the host fills it in for who is shown the frame.
 */
camera: string, };

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
 * What a gimbal can be asked.
 */
export type GimbalCommand = { "command": "angles", 
/**
 * Pitch in radians about the horizon, upwards positive.
 */
pitch_rad: number, 
/**
 * Yaw in radians, clockwise from the zero of `yaw_frame`.
 */
yaw_rad: number, 
/**
 * What the yaw counts from.
 */
yaw_frame: GimbalYawFrame, } | { "command": "rates", 
/**
 * Upwards positive, in radians per second.
 */
pitch_rad_s: number, 
/**
 * Clockwise positive, in radians per second.
 */
yaw_rad_s: number, } | { "command": "point_at", 
/**
 * The place.
 */
place: Geodetic, } | { "command": "neutral" } | { "command": "take_control" } | { "command": "release_control" };

/**
 * What a gimbal is doing.
 */
export type GimbalMode = "idle" | "angles" | "rates" | "point_at";

/**
 * Who steers a gimbal.
 */
export type GimbalOwner = { "kind": "unknown" } | { "kind": "nobody" } | { "kind": "us" } | { "kind": "other", 
/**
 * Its system id.
 */
system_id: number, 
/**
 * Its component id.
 */
component_id: number, };

/**
 * The state of a gimbal.
 */
export type GimbalState = { 
/**
 * It is heard.
 */
connected: boolean, 
/**
 * What it is doing.
 */
mode: GimbalMode, 
/**
 * Who steers it.
 */
owner: GimbalOwner, 
/**
 * Roll in radians about the horizon.
 */
roll_rad: number, 
/**
 * Pitch in radians about the horizon, upwards positive.
 */
pitch_rad: number, 
/**
 * Yaw in radians from the vehicle's nose, clockwise.
 */
yaw_vehicle_rad: number, 
/**
 * Yaw in radians from north, clockwise; absent while the vehicle's own is not known.
 */
yaw_north_rad: number | null, 
/**
 * Where it is to point: pitch and yaw as last asked for, yaw from north.
 */
wanted_pitch_rad: number | null, 
/**
 * See `wanted_pitch_rad`.
 */
wanted_yaw_north_rad: number | null, 
/**
 * The place it keeps pointing at.
 */
place: Geodetic | null, 
/**
 * Lowest pitch it can reach, in radians.
 */
pitch_min_rad: number | null, 
/**
 * Highest pitch it can reach, in radians.
 */
pitch_max_rad: number | null, 
/**
 * What it is, in words.
 */
model: string, 
/**
 * It looks elsewhere than it is wanted and comes no nearer, though it could reach it. Its fault says so too.
 */
not_following: boolean, 
/**
 * What is wrong with it; empty if nothing.
 */
fault: string, };

/**
 * The frame of a gimbal's yaw. Roll and pitch are always about the horizon.
 */
export type GimbalYawFrame = "vehicle" | "north";

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
 * A version that did not stay, and why.
 */
export type GoneBack = { 
/**
 * Which.
 */
from: VersionLabel, 
/**
 * Why.
 */
why: string, };

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
not_running: Array<ActorHealth>, 
/**
 * Whether flights are recorded.
 */
recorder: RecorderStatus, };

/**
 * How the node is.
 */
export type HealthStatus = "ok" | "degraded" | "stalled";

/**
 * What a file with fences says.
 */
export type ImportedFencePlan = { 
/**
 * The zones.
 */
plan: FencePlan, 
/**
 * What was left out, and why.
 */
notes: Array<string>, };

/**
 * How many times an actor or plugin instance has been started, from 1. A message that carries an older one is stale.
 */
export type Incarnation = number;

/**
 * What became of one instance in an exchange of versions.
 */
export type InstanceUpgrade = { 
/**
 * Its name in the supervision tree.
 */
name: string, 
/**
 * Whether it has its former state; absent if it did not come up.
 */
restored: Restored | null, 
/**
 * Why it did not come up; the old version flies on then.
 */
error: string | null, };

/**
 * Where a plugin instance runs.
 */
export type Isolation = "in_process" | "child";

/**
 * How an item stands.
 */
export type ItemStatus = "not_applicable" | "green" | "amber" | "red";

/**
 * The planned way of one vehicle.
 */
export type JourneyPlan = { 
/**
 * The vehicle.
 */
vehicle: VehicleId, 
/**
 * How long it takes in seconds.
 */
duration_s: number, 
/**
 * How long the way is, in metres.
 */
length_m: number, 
/**
 * When it passes each of its waypoints, in seconds after the start.
 */
passes_s: Array<number>, 
/**
 * Its largest speed in metres per second: never exceeded, and reached to within a few in a thousand.
 */
max_speed_m_s: number, 
/**
 * Its largest acceleration in metres per second squared.
 */
max_acceleration_m_s2: number, };

/**
 * The way of one vehicle.
 */
export type JourneyRequest = { 
/**
 * The vehicle.
 */
vehicle: VehicleId, 
/**
 * The places it passes, in the swarm's frame; it stops at the last.
 */
waypoints: Array<PositionNed>, };

/**
 * Whether the vehicle stands on the ground, as its own detector says.
 */
export type LandedState = "unknown" | "on_ground" | "in_air" | "taking_off" | "landing";

/**
 * Whom a node obeys.
 */
export type LeaderStateKind = "nobody" | "led" | "awaiting" | "unled";

/**
 * A vehicle that was not taken back after a restart of the node.
 */
export type LeftVehicle = { 
/**
 * Which.
 */
vehicle: VehicleId, 
/**
 * Why.
 */
why: string, };

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
 * The links of this node at one moment. Rates follow from two answers: the counters only grow as long as the node runs.
 */
export type LinkReport = { 
/**
 * Now, on the node's clock.
 */
time: NodeTime, 
/**
 * Its MAVLink endpoints, by name.
 */
endpoints: Array<EndpointReport>, 
/**
 * Every vehicle's link, by ascending id.
 */
vehicles: Array<VehicleLinkReport>, };

/**
 * How far the fetching of a log has come.
 */
export type LogFetch = { 
/**
 * Which log.
 */
log: AutopilotLog, 
/**
 * Bytes that are there.
 */
received_bytes: number, 
/**
 * How it ended, if it has.
 */
end: LogFetchEnd | null, };

/**
 * The log of a vehicle that is being fetched, or was last.
 */
export type LogFetchAnswer = { 
/**
 * How far it has come; null if none was since the node started.
 */
fetch: LogFetch | null, };

/**
 * How the fetching of a log ended.
 */
export type LogFetchEnd = { "end": "fetched", 
/**
 * Its file there.
 */
file: string, } | { "end": "broken_off", 
/**
 * Why.
 */
why: string, };

/**
 * A place on the ground: WGS 84 degrees.
 */
export type MapPoint = { 
/**
 * Latitude in degrees, north positive.
 */
latitude_deg: number, 
/**
 * Longitude in degrees, east positive.
 */
longitude_deg: number, };

/**
 * One computer of the swarm: a run of the program with its own state. Random, and kept over restarts.
 */
export type NodeId = number;

/**
 * What a node does in its swarm.
 */
export type NodeRole = "vehicle_host" | "coordinator" | "gateway" | "observer";

/**
 * Another node.
 */
export type NodeSnapshot = { 
/**
 * Its number.
 */
node: NodeId, 
/**
 * Its name.
 */
name: string, 
/**
 * What it does.
 */
roles: Array<NodeRole>, 
/**
 * Version of its program.
 */
version: string, 
/**
 * How long ago it was heard, in seconds.
 */
heard_s: number, 
/**
 * The term it obeys.
 */
obeys: TermSnapshot | null, 
/**
 * The vehicles it flies.
 */
vehicles: Array<VehicleId>, 
/**
 * Its swarm frame is another one: it takes no orders from here.
 */
other_frame: boolean, 
/**
 * Round trip to it in seconds.
 */
round_trip_s: number | null, 
/**
 * Its clock less this node's, in seconds.
 */
clock_offset_s: number | null, 
/**
 * How far off that may be, in seconds.
 */
clock_error_s: number | null, 
/**
 * What it tells of its clock does not fit to when it comes.
 */
clock_fault: boolean, 
/**
 * What is received of it, in bytes per second.
 */
received_bytes_per_s: number, 
/**
 * Share of what it sent to all that did not come here, 0..=1, over the last ten seconds; absent if it does not tell what it sends.
 */
loss: number | null, };

/**
 * A moment on the node's monotonic clock, in microseconds since the node started; of a node in a swarm, since long before, so that it can
 * tell of what others did before it was there.
 */
export type NodeTime = number;

/**
 * One node of a roll-out.
 */
export type NodeUpgrade = { 
/**
 * Its number.
 */
node: NodeId, 
/**
 * What it is called.
 */
name: string, 
/**
 * How far it is.
 */
progress: NodeUpgradeState, 
/**
 * Its versions, as it last told.
 */
versions: NodeVersions | null, };

/**
 * How far one node is.
 */
export type NodeUpgradeState = { "state": "waiting" } | { "state": "sending", 
/**
 * So much is there.
 */
sent_bytes: number, 
/**
 * Of so much.
 */
of_bytes: number, } | { "state": "unpacking" } | { "state": "starting" } | { "state": "on_trial" } | { "state": "confirmed" } | { "state": "gone_back", 
/**
 * Why.
 */
why: string, } | { "state": "refused", 
/**
 * Why.
 */
refusal: UpgradeRefusal, } | { "state": "not_reachable", 
/**
 * What happened.
 */
why: string, } | { "state": "lost", 
/**
 * For how long, in seconds.
 */
silent_s: number, } | { "state": "skipped" };

/**
 * The versions of one node.
 */
export type NodeVersions = { 
/**
 * Its processor, as `x86_64` or `aarch64`.
 */
architecture: string, 
/**
 * What it runs.
 */
runs: VersionLabel, 
/**
 * What it runs has not confirmed itself yet.
 */
on_trial: boolean, 
/**
 * What is to be started next, on trial.
 */
pending: VersionLabel | null, 
/**
 * What it ran before.
 */
before: VersionLabel | null, 
/**
 * The last version that went back.
 */
gone_back: GoneBack | null, 
/**
 * Why the last swap was broken off before it began.
 */
broken_off: UpgradeRefusal | null, 
/**
 * A version on trial has so long to confirm itself, in seconds.
 */
confirm_within_s: number, };

/**
 * How a track is to be kept in view.
 */
export type ObserveRequest = { 
/**
 * By these vehicles; by the best placed ones if left out.
 */
vehicles: Array<VehicleId> | null, 
/**
 * By so many, where no vehicles are named; two if left out.
 */
count: number | null, 
/**
 * Horizontal distance to keep, in metres; each model's own if left out.
 */
stand_off_m: number | null, };

/**
 * Who could keep a track in view.
 */
export type ObserverList = { 
/**
 * The track.
 */
track: number, 
/**
 * Vehicles whose model can observe, the best placed first; those that cannot be asked come last, with the reason.
 */
observers: Array<ObserverProposal>, };

/**
 * How well a vehicle is placed to keep something in view.
 */
export type ObserverProposal = { 
/**
 * Which.
 */
vehicle: VehicleId, 
/**
 * How well: 0..=1, the greatest is the best. Of nearness, charge, a camera on a gimbal, and being free.
 */
score: number, 
/**
 * How far it is from the track, in metres; null if its place is not known.
 */
distance_m: number | null, 
/**
 * Charge that is left, 0..=1; null if not known.
 */
battery: number | null, 
/**
 * It is in the air.
 */
flies: boolean, 
/**
 * It has a camera on a gimbal.
 */
gimbal_camera: boolean, 
/**
 * What it is doing already, in words; null if nothing.
 */
busy: string | null, 
/**
 * Why it cannot be asked, in words; null if it can.
 */
unfit: string | null, };

/**
 * A place relative to a formation's anchor: metres forward, right and down of it.
 */
export type OffsetFrd = { 
/**
 *First axis, in metres.
 */
forward_m: number, 
/**
 *Second axis, in metres.
 */
right_m: number, 
/**
 *Third axis, in metres.
 */
down_m: number, };

/**
 * The reaction that a vehicle is under.
 */
export type Order = { 
/**
 * What is to be done.
 */
reaction: Reaction, 
/**
 * Because of what.
 */
trigger: Trigger, 
/**
 * Since when it has been ordered.
 */
ordered_at: NodeTime, 
/**
 * Since when it has been seen to take effect, if it does.
 */
effective_at: NodeTime | null, 
/**
 * All triggers are over: it stays until an operator or the coordinator takes the vehicle up again.
 */
recovered: boolean, };

/**
 * Red items of the preflight report that an operator takes upon himself.
 */
export type OverrideBody = { 
/**
 * Whose items; those of the swarm if left out.
 */
vehicle: VehicleId | null, 
/**
 * Ids of the items.
 */
items: Array<string>, 
/**
 * Why.
 */
reason: string, 
/**
 * For how long, in seconds.
 */
valid_s: number, };

/**
 * One parameter as it is known.
 */
export type Parameter = { 
/**
 * Its name.
 */
name: string, 
/**
 * Its value, as the autopilot said last.
 */
value: ParameterValue, 
/**
 * The value it had before it was first written here, if that is another one.
 */
changed_from: ParameterValue | null, };

/**
 * A value for a parameter.
 */
export type ParameterBody = { 
/**
 * The value; a whole number where the parameter is one.
 */
value: number, };

/**
 * The parameters of a vehicle, as far as they are known.
 */
export type ParameterList = { 
/**
 * How the reading of all stands.
 */
reading: ParameterReading, 
/**
 * How many of them were read.
 */
read: number, 
/**
 * How many there are, once the autopilot has said so.
 */
total: number | null, 
/**
 * Grows with every change of a value. To be given with the next request, for what has changed since.
 */
revision: number, 
/**
 * All that is known is here, and nothing else is known any more; otherwise only what has changed.
 */
whole: boolean, 
/**
 * By ascending name.
 */
parameters: Array<Parameter>, };

/**
 * How the reading of all parameters stands.
 */
export type ParameterReading = { "state": "not_begun" } | { "state": "reading" } | { "state": "complete" } | { "state": "ended", 
/**
 * Why.
 */
why: string, };

/**
 * A parameter that was written.
 */
export type ParameterReceipt = { 
/**
 * Its name.
 */
name: string, 
/**
 * Its value now, as the autopilot says.
 */
value: ParameterValue, 
/**
 * Its value before.
 */
before: ParameterValue | null, };

/**
 * A parameter's value with its type. What it counts (metres, seconds, choices) only the autopilot knows.
 */
export type ParameterValue = { "type": "integer", "value": number } | { "type": "real", "value": number | null };

/**
 * What changes seldom about one payload. Its state is in its vehicle's snapshot.
 */
export type PayloadInfo = { 
/**
 * Its name on the vehicle.
 */
name: string, 
/**
 * What it is.
 */
kind: PayloadKind, 
/**
 * Name of its plugin.
 */
plugin: string, 
/**
 * Version of that plugin.
 */
version: string, 
/**
 * Where the plugin runs.
 */
isolation: Isolation, 
/**
 * Its plugin instance.
 */
health: ActorHealth, 
/**
 * How many of its starts followed a failure.
 */
restarts: number, 
/**
 * Whether it has given a frame.
 */
has_frame: boolean, };

/**
 * What a payload is.
 */
export type PayloadKind = "gimbal" | "camera" | "radio" | "detector";

/**
 * What a vehicle carries.
 */
export type PayloadList = { 
/**
 * By name.
 */
payloads: Array<PayloadSnapshot>, };

/**
 * `[[adopt.payloads]]`, and what the API takes to attach one at run time.
 */
export type PayloadRule = { 
/**
 * Its name on the vehicle.
 */
name: string, 
/**
 * Payload plugin.
 */
plugin: string, 
/**
 * Where the plugin runs.
 */
isolation: Isolation, 
/**
 * How its device is reached if not over the vehicle's MAVLink: `udp://ADDRESS:PORT` or `serial:///dev/ttyUSB0?baud=115200`.
 */
transport: string | null, 
/**
 * What happens when it has failed too often.
 */
on_failure: Escalation, 
/**
 * Configuration handed to the plugin.
 */
config: Record<string, unknown>, };

/**
 * One payload at one moment.
 */
export type PayloadSnapshot = { 
/**
 * Its name on the vehicle.
 */
name: string, 
/**
 * What it is.
 */
kind: PayloadKind, 
/**
 * Its actor.
 */
actor: ActorHealth, 
/**
 * Its plugin instance.
 */
plugin: PluginHealth, 
/**
 * What it reports of itself, as its state schema has it; absent while it does not run.
 */
state: unknown, 
/**
 * Why its transport does not work; empty if it does or has none.
 */
transport_fault: string, 
/**
 * The last frame it gave.
 */
frame: FrameHeader | null, };

/**
 * How the bytes of a frame are to be read.
 */
export type PixelFormat = "gray8" | "rgb8" | "jpeg" | "h264";

/**
 * A plugin instance under supervision.
 */
export type PluginHealth = { 
/**
 * Name in the supervision tree, for example `model-3` or `payload-3-gimbal`.
 */
name: string, 
/**
 * The plugin.
 */
plugin: string, 
/**
 * Its version.
 */
version: string, 
/**
 * Where it runs.
 */
isolation: Isolation, 
/**
 * Its process, if it has one of its own.
 */
process_id: number | null, 
/**
 * Running, restarting after back-off, or given up.
 */
status: ActorStatus, 
/**
 * How many times it was started.
 */
incarnation: Incarnation, 
/**
 * How many of its starts followed a failure.
 */
restarts: number, 
/**
 * The last error that ended it; empty if none did.
 */
last_error: string, 
/**
 * Since when it has this status.
 */
since: NodeTime, 
/**
 * Calls of this incarnation.
 */
calls: number, 
/**
 * Half of them were no slower, in microseconds.
 */
call_p50_us: number, 
/**
 * All but one in a hundred were no slower, in microseconds.
 */
call_p99_us: number, };

/**
 * A plugin that was found, for screens.
 */
export type PluginInfo = { 
/**
 * Its name.
 */
name: string, 
/**
 * The active version.
 */
version: string, 
/**
 * What it is.
 */
kind: string, 
/**
 * What it is for.
 */
description: string, 
/**
 * The file it was loaded from.
 */
path: string, 
/**
 * SHA-256 of the file, in hexadecimal.
 */
sha256: string, 
/**
 * The effects it may return.
 */
effects: Array<string>, 
/**
 * JSON Schema of its configuration, as text.
 */
config_schema_json: string, 
/**
 * JSON Schema of its commands, as text.
 */
command_schema_json: string | null, 
/**
 * JSON Schema of the state it reports, as text.
 */
state_schema_json: string | null, 
/**
 * JSON Schema of the events it tells, as text.
 */
event_schema_json: string | null, 
/**
 * All loaded versions, oldest first.
 */
versions: Array<string>, 
/**
 * A loaded version that is not active yet.
 */
candidate: string | null, 
/**
 * The version that a roll back would go to.
 */
previous: string | null, 
/**
 * Names of the instances it has in the supervision tree.
 */
instances: Array<string>, };

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
 * The reports of the swarm and of all its vehicles.
 */
export type PreflightAnswer = { 
/**
 * What concerns all of them.
 */
swarm: PreflightReport, 
/**
 * Each vehicle, by ascending id.
 */
vehicles: Array<PreflightReport>, 
/**
 * Overrides that hold.
 */
overrides: Array<PreflightOverride>, };

/**
 * One thing looked at.
 */
export type PreflightItem = { 
/**
 * Its id: what an override names. Those of plugins begin with the plugin's name and a slash.
 */
id: string, 
/**
 * A few words for people.
 */
title: string, 
/**
 * How it stands.
 */
status: ItemStatus, 
/**
 * The value as text, with its unit.
 */
value: string, 
/**
 * The value as a number, in `unit`, if it is one.
 */
number: number | null, 
/**
 * Unit of number and limit; empty if they have none.
 */
unit: string, 
/**
 * What the number is held against, in `unit`.
 */
limit: number | null, 
/**
 * Why it stands so, or why it matters.
 */
why: string, 
/**
 * It keeps from arming, and a permitted operator may take that upon himself. Filled in when the report is finished, whoever made
 * the item.
 */
may_be_overridden: boolean, };

/**
 * Red items that a person takes upon themselves. Recorded when it is given and when it is used.
 */
export type PreflightOverride = { 
/**
 * Who.
 */
operator: string, 
/**
 * Why; must not be empty.
 */
reason: string, 
/**
 * Ids of the items.
 */
items: Array<string>, 
/**
 * For which vehicle; absent: for items of the swarm.
 */
vehicle: VehicleId | null, 
/**
 * When it was given.
 */
given_at: NodeTime, 
/**
 * For how long it holds, in seconds.
 */
valid_s: number, };

/**
 * What was found before arming one vehicle, or for the swarm.
 */
export type PreflightReport = { 
/**
 * The vehicle; absent for the swarm.
 */
vehicle: VehicleId | null, 
/**
 * Item by item.
 */
items: Array<PreflightItem>, 
/**
 * When it was looked at.
 */
made_at: NodeTime, };

/**
 * What a radio can be asked, where the device allows it.
 */
export type RadioCommand = { "command": "set_channel", 
/**
 * Its number as the device counts.
 */
channel: number, } | { "command": "set_power", 
/**
 * In decibels over a milliwatt.
 */
power_dbm: number, };

/**
 * The state of a radio link.
 */
export type RadioState = { 
/**
 * It is heard.
 */
connected: boolean, 
/**
 * What the figures come from: `radio_status`, `nl80211`.
 */
source: string, 
/**
 * Signal strength here, in decibels over a milliwatt.
 */
rssi_dbm: number | null, 
/**
 * Signal strength at the far end, in decibels over a milliwatt.
 */
remote_rssi_dbm: number | null, 
/**
 * Noise here, in decibels over a milliwatt.
 */
noise_dbm: number | null, 
/**
 * Signal over noise in decibels, of the weaker end.
 */
snr_db: number | null, 
/**
 * Share of packets lost, 0..=1.
 */
loss: number | null, 
/**
 * Time a packet takes, in seconds.
 */
latency_s: number | null, 
/**
 * Data rate in bits per second.
 */
throughput_bit_s: number | null, 
/**
 * Channel.
 */
channel: number | null, 
/**
 * Transmission power in decibels over a milliwatt.
 */
power_dbm: number | null, 
/**
 * Distance to the ground station in metres.
 */
distance_m: number | null, 
/**
 * Distance at which the link is expected to fail, in metres, from how it fell off so far.
 */
range_m: number | null, 
/**
 * Time until the vehicle is out of range if it goes on as now, in seconds.
 */
out_of_range_in_s: number | null, 
/**
 * It is about to leave the range.
 */
warning: boolean, 
/**
 * What is wrong with it; empty if nothing.
 */
fault: string, };

/**
 * What is done about a trigger, in order of strength: of two the greater wins.
 */
export type Reaction = "warn" | "hold" | "return" | "land" | "release";

/**
 * What is wanted of the reading of all parameters.
 */
export type ReadingAction = "begin" | "anew" | "stop";

/**
 * What is to be done about the reading of all parameters.
 */
export type ReadingBody = { 
/**
 * What.
 */
action: ReadingAction, };

/**
 * A recording of a flight, or of vehicles that stood.
 */
export type RecordedFlight = { 
/**
 * The file's name. One that ends with `_ground.mcap` is of vehicles that stood.
 */
file: string, 
/**
 * Name of the node that recorded it.
 */
node: string, 
/**
 * When it begins, in seconds since 1970 by the clock of that node's computer.
 */
begun_unix_s: number, 
/**
 * How long it is, in seconds.
 */
seconds: number, 
/**
 * Its size in bytes.
 */
bytes: number, 
/**
 * Logs of autopilots that lie beside it, by their files' names.
 */
logs: Array<string>, 
/**
 * It was ended. One that was not is being written, or was cut off with its program.
 */
finished: boolean, };

/**
 * What the recorder does.
 */
export type RecorderStatus = { 
/**
 * Whether flights are recorded.
 */
state: RecorderWord, 
/**
 * The file that is written.
 */
file: string | null, 
/**
 * Somebody was armed since it was begun.
 */
in_flight: boolean, 
/**
 * Why they are not recorded.
 */
why: string | null, 
/**
 * The file of the last flight that has ended since the node started.
 */
last_flight: string | null, };

/**
 * Whether flights are recorded.
 */
export type RecorderWord = "off" | "recording" | "interrupted";

/**
 * Things that formations may be anchored to.
 */
export type ReferenceList = { 
/**
 * The references by name.
 */
references: Array<ReferenceSnapshot>, };

/**
 * Where a reference is, as it is told.
 */
export type ReferenceReport = { 
/**
 * Its position in the swarm frame.
 */
position: PositionNed, 
/**
 * Its velocity, if it is known; else it is worked out from the positions.
 */
velocity: VelocityNed | null, 
/**
 * Where it points in radians clockwise from north, if it is known.
 */
heading_rad: number | null, };

/**
 * A reference as screens see it.
 */
export type ReferenceSnapshot = { 
/**
 * Its name.
 */
name: string, 
/**
 * As last told.
 */
report: ReferenceReport, 
/**
 * How long ago, in seconds.
 */
age_s: number, 
/**
 * Told too long ago to be followed.
 */
stale: boolean, };

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
detail: string, } | { "reason": "not_supported", 
/**
 * What cannot be done, and by what.
 */
detail: string, } | { "reason": "unknown_payload", 
/**
 * The vehicle.
 */
vehicle: VehicleId, 
/**
 * The name asked for.
 */
payload: string, } | { "reason": "unknown_track", 
/**
 * The number asked for.
 */
track: number, } | { "reason": "preflight", 
/**
 * Ids of the items.
 */
items: Array<string>, } | { "reason": "unknown_reference", 
/**
 * The name asked for.
 */
name: string, } | { "reason": "clock", 
/**
 * Which, and what would be right.
 */
detail: string, } | { "reason": "no_control_authority", 
/**
 * The vehicle.
 */
vehicle: VehicleId, 
/**
 * What the other is called.
 */
holder: string, } | { "reason": "not_sent", 
/**
 * What happened instead, and what will be done.
 */
detail: string, };

/**
 * Whether what is shown is a recorded flight.
 */
export type ReplayAnswer = { 
/**
 * Where it is; null for a node that flies.
 */
replay: ReplayState | null, };

/**
 * What is asked of a replay. What is left out stays as it is.
 */
export type ReplayChange = { 
/**
 * Go to this moment, in seconds from the beginning of the recording; what is after its end is its end.
 */
position_s?: number, 
/**
 * Show so many recorded seconds in a second.
 */
rate?: number, 
/**
 * Go on, or stand still.
 */
playing?: boolean, };

/**
 * Where a replay is.
 */
export type ReplayState = { 
/**
 * Name of the recording's file.
 */
file: string, 
/**
 * Name of the node that recorded it.
 */
node: string, 
/**
 * When the recording begins, in seconds since 1970 by the clock of that node's computer.
 */
begun_unix_s: number, 
/**
 * The same moment on that node's clock.
 */
begin: NodeTime, 
/**
 * How long the recording is, in seconds.
 */
duration_s: number, 
/**
 * How far into it what is shown now is, in seconds.
 */
position_s: number, 
/**
 * Recorded seconds that are shown in a second.
 */
rate: number, 
/**
 * It goes on.
 */
playing: boolean, 
/**
 * Grows whenever it goes to another moment: what was known of the vehicles before holds no more then.
 */
jumps: number, 
/**
 * It was ended. One that was not was being written when it was opened, or was cut off with its program.
 */
finished: boolean, 
/**
 * The recording has been gone through: the timeline is whole.
 */
indexed: boolean, };

/**
 * Why a trigger is reported and nothing is done about it.
 */
export type ReportOnly = "on_ground" | "pilot_in_control" | "warn_only" | "overruled" | "landing";

/**
 * Restarts of plugin instances.
 */
export type RestartList = { 
/**
 * Oldest first.
 */
restarts: Array<RestartRecord>, };

/**
 * One restart of a plugin instance after a failure.
 */
export type RestartRecord = { 
/**
 * When it ran again.
 */
time: NodeTime, 
/**
 * Its name in the supervision tree.
 */
name: string, 
/**
 * Where it runs.
 */
isolation: Isolation, 
/**
 * From the failure, or the end of the back-off, until it had its state again, in seconds.
 */
took_s: number, 
/**
 * The deliberate wait before, in seconds.
 */
backoff_s: number, 
/**
 * Whether it has the state of the one before it.
 */
restored: Restored, };

/**
 * Whether a restarted instance has the state of the one before it.
 */
export type Restored = "fresh" | "exactly" | "differently";

/**
 * The answer to what an operator is asked after a restart in flight.
 */
export type ResumeBody = { 
/**
 * The vehicles that were taken back fly on; if not, they go on holding, and what was flown is forgotten.
 */
fly_on: boolean, };

/**
 * Whether vehicles that were taken back after a restart of the node are to fly on.
 */
export type ResumeQuestion = { 
/**
 * They hold where they are.
 */
vehicles: Array<VehicleId>, 
/**
 * Those that were not taken back.
 */
left: Array<LeftVehicle>, 
/**
 * A formation is flown on; else what each of them was commanded.
 */
formation: boolean, 
/**
 * Since when it is asked.
 */
since: NodeTime, };

/**
 * A roll-out: one node after the other.
 */
export type Rollout = { 
/**
 * What it is for.
 */
kind: RolloutKind, 
/**
 * Who began it.
 */
operator: string, 
/**
 * Nodes, in ascending order.
 */
nodes: Array<NodeUpgrade>, 
/**
 * How it ended; absent while it goes on.
 */
ended: RolloutEnd | null, };

/**
 * Which nodes a roll-out is for.
 */
export type RolloutBody = { 
/**
 * Their numbers; all others of the swarm if left out.
 */
nodes: Array<NodeId> | null, 
/**
 * The node that is asked too, as the last one.
 */
this_node: boolean, };

/**
 * How a roll-out ended.
 */
export type RolloutEnd = { "end": "done" } | { "end": "stopped", 
/**
 * Why.
 */
why: string, };

/**
 * What a roll-out is for.
 */
export type RolloutKind = "upgrade" | "back";

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
 * What became of putting a route on a vehicle.
 */
export type RouteUpload = { "is": "sending", 
/**
 * So many points.
 */
points: number, } | { "is": "held", 
/**
 * So many points.
 */
points: number, } | { "is": "failed", 
/**
 * Why.
 */
refusal: Refusal, };

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
node: string, } | { "type": "fleet" } & FleetInfo | { "type": "safety", 
/**
 * By ascending id.
 */
vehicles: Array<VehicleSafety>, } | { "type": "control", 
/**
 * Those that somebody has, by ascending id.
 */
vehicles: Array<VehicleControl>, } | { "type": "tracks" } & TrackList | { "type": "swarm" } & SwarmSnapshot | { "type": "replay" } & ReplayState | { "type": "event" } & EventRecord | { "type": "gap", 
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
 * The outline of a formation. What "forward" and "right" mean is the formation's heading.
 */
export type Shape = "line" | "column" | "wedge" | "echelon_left" | "echelon_right" | "diamond" | "circle" | "arc" | "square" | "grid" | "box" | "sphere" | "helix" | "free";

/**
 * Where a camera can look from a place of a formation, without another place within 30 degrees of that direction.
 */
export type SlotView = "ahead" | "outward" | "blocked";

/**
 * What is supervised for one payload.
 */
export type SupervisedPayload = { 
/**
 * Its name on the vehicle.
 */
name: string, 
/**
 * What it is.
 */
kind: PayloadKind, 
/**
 * Its actor.
 */
actor: ActorHealth, 
/**
 * Its plugin instance.
 */
plugin: PluginHealth, 
/**
 * Why its transport does not work; empty if it does or has none.
 */
transport_fault: string, };

/**
 * What is supervised for one vehicle.
 */
export type SupervisedVehicle = { 
/**
 * The swarm's id for it.
 */
id: VehicleId, 
/**
 * The node of the swarm that flies it; absent for this node's own without a swarm.
 */
node: NodeId | null, 
/**
 * Its name from the adoption rule.
 */
name: string, 
/**
 * Its actor.
 */
actor: ActorHealth, 
/**
 * Its UAV-model plugin instance.
 */
model: PluginHealth, 
/**
 * What it carries, by name.
 */
payloads: Array<SupervisedPayload>, 
/**
 * Why it can do less than it was built for; empty if nothing is amiss.
 */
degraded: Array<string>, };

/**
 * The supervision tree: the node's actors, and below every vehicle its actor, its model and what it carries.
 */
export type SupervisionTree = { 
/**
 * Now, on the node's clock: what every `since` is to be told by.
 */
time: NodeTime, 
/**
 * Actors of the node itself.
 */
actors: Array<ActorHealth>, 
/**
 * By ascending id.
 */
vehicles: Array<SupervisedVehicle>, };

/**
 * The swarm's one common frame: north-east-down about a geodetic origin that all members share.
 */
export type SwarmFrame = { 
/**
 * The shared origin.
 */
origin: Geodetic, };

/**
 * The swarm as one of its nodes knows it.
 */
export type SwarmSnapshot = { 
/**
 * The swarm's id.
 */
swarm: string, 
/**
 * This node's number.
 */
node: NodeId, 
/**
 * Its name.
 */
name: string, 
/**
 * What it does.
 */
roles: Array<NodeRole>, 
/**
 * Whom it obeys.
 */
leader_state: LeaderStateKind, 
/**
 * The term it obeys.
 */
term: TermSnapshot | null, 
/**
 * How long the obeyed coordinator has been silent, in seconds, if it is.
 */
silent_s: number | null, 
/**
 * It coordinates.
 */
acting: boolean, 
/**
 * It hears no other node, though it did.
 */
cut_off: boolean, 
/**
 * The other nodes, by number.
 */
nodes: Array<NodeSnapshot>, 
/**
 * What it sends, in bytes per second.
 */
sent_bytes_per_s: number, 
/**
 * What it may send at this moment, in bytes per second.
 */
limit_bytes_per_s: number, 
/**
 * Datagrams that were not of this swarm, or changed on the way.
 */
strangers: number, 
/**
 * Datagrams that had been there before.
 */
replayed: number, 
/**
 * The transport says that it is down: why.
 */
transport_fault: string | null, 
/**
 * If the others are reached in two ways at once: each of them.
 */
ways: Array<WaySnapshot>, };

/**
 * MAVLink system id: 1..=255, unique on one link only.
 */
export type SystemId = number;

/**
 * What is looked at.
 */
export type Target = { "kind": "place", 
/**
 * Where.
 */
position: PositionNed, } | { "kind": "vehicle", 
/**
 * Which.
 */
vehicle: VehicleId, } | { "kind": "track", 
/**
 * The track's number.
 */
track: number, };

/**
 * Whom a command is for.
 */
export type Targets = "all" | { "vehicles": Array<VehicleId> };

/**
 * A term of the leadership.
 */
export type TermSnapshot = { 
/**
 * Grows with every change of the coordinator.
 */
number: number, 
/**
 * The node that coordinates in it.
 */
coordinator: NodeId, };

/**
 * What happened in a recording, for a screen.
 */
export type Timeline = { 
/**
 * The recording has been gone through. Until then there are no marks.
 */
complete: boolean, 
/**
 * By their time.
 */
marks: Array<TimelineMark>, 
/**
 * So many more there were, which nothing is shown of.
 */
left_out: number, };

/**
 * Something that happened.
 */
export type TimelineMark = { 
/**
 * When, in seconds from the beginning of the recording.
 */
position_s: number, 
/**
 * How urgent.
 */
severity: Severity, 
/**
 * About which vehicle, if about one.
 */
vehicle: VehicleId | null, 
/**
 * Who did it, if it was an operator or a program; empty if nobody says who.
 */
who: string | null, 
/**
 * One sentence.
 */
text: string, };

/**
 * What is to change of a track; what is left out stays as it is.
 */
export type TrackChangeBody = { 
/**
 * What it is called; an empty name takes the name away.
 */
name: string | null, 
/**
 * Whether it is kept longer when nobody sees it.
 */
pinned: boolean | null, };

/**
 * Something tracked, with all that is known of it.
 */
export type TrackEstimate = { 
/**
 * What an operator calls it; empty if nobody named it.
 */
name: string, 
/**
 * What it is most likely; empty if nobody says.
 */
class: string, 
/**
 * What it may be: the score of each class, 0..=1.
 */
classes: { [key in string]: number }, 
/**
 * Covariance of its position along north, east and down, in square metres: north-north, north-east, north-down, east-east, east-down,
 * down-down. Null if nobody says.
 */
covariance_m2: [number, number, number, number, number, number] | null, 
/**
 * An operator wants it kept.
 */
pinned: boolean, 
/**
 * Its range is only guessed from how large it looks: one camera alone has seen it so far.
 */
guessed_range: boolean, 
/**
 * How sure it is that something is there at all, 0..=1, from how surely it is seen again and again. What was told is sure.
 */
confidence: number, 
/**
 * Since it began, in seconds.
 */
age_s: number, 
/**
 * When it was last seen, on the node's clock.
 */
seen: NodeTime, 
/**
 * Who sees it now: `VEHICLE/CAMERA`, or the source that tells of it over the API.
 */
sensors: Array<string>, 
/**
 * Who says that it is there.
 */
source: TrackSource, 
/**
 * Its number.
 */
track: number, 
/**
 * Where it was at `time`.
 */
position: PositionNed, 
/**
 * Its velocity at `time`.
 */
velocity: VelocityNed, 
/**
 * When that was, on the node's clock.
 */
time: NodeTime, 
/**
 * Standard deviation of the position in metres, along the direction in which it is known worst; null if nobody says.
 */
error_m: number | null, };

/**
 * What is tracked.
 */
export type TrackList = { 
/**
 * Now, on the node's clock.
 */
time: NodeTime, 
/**
 * The tracks: those that were told last, and those that the swarm made of what its sensors saw.
 */
tracks: Array<TrackEstimate>, };

/**
 * Who says that something is there.
 */
export type TrackSource = "told" | "fused";

/**
 * Trajectories that have ended.
 */
export type TrajectoriesEnded = { 
/**
 * Whose.
 */
vehicles: Array<VehicleId>, };

/**
 * What is made as small as possible along a trajectory.
 */
export type TrajectoryKind = "jerk" | "snap";

/**
 * How trajectories are getting on.
 */
export type TrajectoryList = { 
/**
 * Now, on the node's clock: what a start is to be told by.
 */
time: NodeTime, 
/**
 * By ascending vehicle.
 */
trajectories: Array<TrajectoryStatus>, };

/**
 * One reason against a plan.
 */
export type TrajectoryObjection = { 
/**
 * Whose way it is about; absent if about all of them.
 */
vehicle: VehicleId | null, 
/**
 * The reason.
 */
refusal: Refusal, };

/**
 * Ways planned together.
 */
export type TrajectoryPlan = { 
/**
 * When all begin, on the node's clock.
 */
start: NodeTime, 
/**
 * How long after the plan was made that is, in seconds.
 */
starts_in_s: number, 
/**
 * When the last of them arrives, in seconds after the start.
 */
duration_s: number, 
/**
 * None of them comes nearer than this to another or to anything that stands in the air, in metres: a proven lower bound. Heights
 * count by less, as the separation filter counts them. Absent if there is nothing to come near to.
 */
min_distance_m: number | null, 
/**
 * Which two come that near.
 */
nearest: [VehicleId, VehicleId] | null, 
/**
 * One by one.
 */
vehicles: Array<JourneyPlan>, };

/**
 * How a vehicle is getting on with its trajectory.
 */
export type TrajectoryProgress = { "is": "waiting" } | { "is": "flying" } | { "is": "flown" } | { "is": "ended", 
/**
 * Why.
 */
why: string, };

/**
 * Ways that are planned together: all start at one time and pass their k-th waypoints at one time, as slowly as the slowest needs.
 */
export type TrajectoryRequest = { 
/**
 * Who flies where.
 */
vehicles: Array<JourneyRequest>, 
/**
 * How smooth.
 */
kind: TrajectoryKind, 
/**
 * When it begins.
 */
start: TrajectoryStart, 
/**
 * No faster than this, in metres per second; as fast as vehicles and gate permit if left out.
 */
max_speed_m_s: number | null, 
/**
 * The ways are put on the vehicles' autopilots as missions as well. They are flown by setpoints all the same.
 */
upload: boolean, };

/**
 * When all begin, on the node's clock.
 */
export type TrajectoryStart = { "when": "soon" } | { "when": "in", 
/**
 * Seconds.
 */
in_s: number, } | { "when": "at", 
/**
 * Microseconds since the node started, as in `GET /api/v1/health`.
 */
time: NodeTime, };

/**
 * A vehicle's trajectory and how it is getting on.
 */
export type TrajectoryStatus = { 
/**
 * The vehicle.
 */
vehicle: VehicleId, 
/**
 * When it begins, on the node's clock.
 */
start: NodeTime, 
/**
 * As planned.
 */
plan: JourneyPlan, 
/**
 * The waypoints.
 */
waypoints: Array<PositionNed>, 
/**
 * How many of them it has passed.
 */
passed: number, 
/**
 * Seconds since the start; negative before it.
 */
elapsed_s: number, 
/**
 * How it is getting on.
 */
progress: TrajectoryProgress, 
/**
 * The route on its autopilot; absent if none was asked for.
 */
upload: RouteUpload | null, };

/**
 * What may go wrong with one vehicle in flight.
 */
export type Trigger = "link_loss" | "gnss_loss" | "gnss_disagreement" | "tracking_error" | "stale_estimate" | "clock_fault" | "fence_breach" | "coordinator_loss" | "operator_dead_man" | "energy";

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
 * What became of an exchange of versions.
 */
export type UpgradeReceipt = { 
/**
 * The plugin.
 */
name: string, 
/**
 * The version before.
 */
from: string, 
/**
 * The version asked for.
 */
to: string, 
/**
 * Its instances.
 */
instances: Array<InstanceUpgrade>, 
/**
 * One did not come up: all are back to the version before.
 */
rolled_back: boolean, };

/**
 * Why a version is not taken, not started, or not sent.
 */
export type UpgradeRefusal = { "reason": "not_accepted" } | { "reason": "no_state_folder" } | { "reason": "armed", 
/**
 * Which.
 */
vehicle: VehicleId, } | { "reason": "not_heard", 
/**
 * Which.
 */
vehicle: VehicleId, } | { "reason": "coordinates", 
/**
 * Which.
 */
vehicle: VehicleId, } | { "reason": "architecture", 
/**
 * What the archive is for.
 */
archive: string, 
/**
 * What the node is.
 */
node: string, } | { "reason": "no_archive", 
/**
 * What the node is.
 */
node: string, } | { "reason": "damaged", 
/**
 * What is wrong.
 */
detail: string, } | { "reason": "no_room", 
/**
 * What would be needed.
 */
needed_bytes: number, 
/**
 * What is free.
 */
free_bytes: number, } | { "reason": "unknown", 
/**
 * Which was asked for.
 */
digest: string, } | { "reason": "nothing_before" } | { "reason": "busy", 
/**
 * What.
 */
what: string, } | { "reason": "no_nodes" } | { "reason": "unknown_node", 
/**
 * Which.
 */
node: NodeId, } | { "reason": "storage", 
/**
 * How.
 */
detail: string, };

/**
 * Everything about upgrades at one node.
 */
export type UpgradeReport = { 
/**
 * The versions of the node that is asked.
 */
this_node: NodeVersions, 
/**
 * Archives that it keeps for a roll-out, one for each kind of processor.
 */
archives: Array<ArchiveInfo>, 
/**
 * The last roll-out that was begun at it since it started.
 */
rollout: Rollout | null, };

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
speed_m_s: number | null, } | { "command": "observe", 
/**
 * What is to be kept in view.
 */
target: Target, 
/**
 * Horizontal distance to keep in metres; the model's own if left out.
 */
stand_off_m: number | null, 
/**
 * Height above the target to keep in metres; if left out the present one, or the one that a camera without a gimbal needs.
 */
height_m: number | null, 
/**
 * From which side: the bearing from the target to the vehicle, in radians clockwise from north; the nearest side if left out.
 */
bearing_rad: number | null, } | { "command": "look_at", 
/**
 * What is to be looked at.
 */
target: Target, } | { "command": "stop_observing" } | { "command": "steer" };

/**
 * Who has control authority over a vehicle.
 */
export type VehicleControl = { 
/**
 * The vehicle.
 */
vehicle: VehicleId, 
/**
 * Who has it.
 */
console: Console, 
/**
 * Since when.
 */
since: NodeTime, 
/**
 * That console is heard. If not, anybody may relieve it.
 */
is_heard: boolean, 
/**
 * Who asks for it, the first first.
 */
requests: Array<ControlRequest>, };

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
 * The node of the swarm that flies it, in a swarm of several nodes.
 */
node: NodeId | null, 
/**
 * Its name.
 */
name: string, 
/**
 * It is simulated, for all its node knows; who does not say so is real.
 */
simulated: boolean, 
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
model: ActorHealth, 
/**
 * What it carries, by name.
 */
payloads: Array<PayloadInfo>, 
/**
 * Why it can do less than it was built for; empty if nothing is amiss.
 */
degraded: Array<string>, };

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
 * How one vehicle is heard.
 */
export type VehicleLinkReport = { 
/**
 * The swarm's id for it.
 */
id: VehicleId, 
/**
 * Its name from the adoption rule.
 */
name: string, 
/**
 * The node of the swarm that flies it, and has measured this; absent for this node's own without a swarm.
 */
node: NodeId | null, 
/**
 * Seconds since something of it was heard.
 */
age_s: number, 
/**
 * The link that flies it.
 */
link: LinkHealth, 
/**
 * Both links, the preferred one first, where it has two.
 */
ways: Array<VehicleWay>, };

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
 * What is wrong with a vehicle, or done to keep it safe. Rounded: what hardly changes is not told again.
 */
export type VehicleSafety = { 
/**
 * The swarm's id for it.
 */
id: VehicleId, 
/**
 * What is wrong with it in flight and what is done about it; absent if nothing is.
 */
failsafe: FailsafeState | null, 
/**
 * Its charge against its way home; absent as long as one of them is not known.
 */
energy: EnergyState | null, 
/**
 * What is changed of its setpoints at this moment; absent if nothing.
 */
avoiding: Avoidance | null, 
/**
 * Its motors were stopped in an emergency.
 */
stopped: boolean, };

/**
 * One vehicle at one moment.
 */
export type VehicleSnapshot = { 
/**
 * The swarm's id for it.
 */
id: VehicleId, 
/**
 * The node of the swarm that flies it; absent for this node's own without a swarm.
 */
node: NodeId | null, 
/**
 * Its name from the adoption rule.
 */
name: string, 
/**
 * It is simulated, for all its node knows; who does not say so is real.
 */
simulated: boolean, 
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
 * Its two links, the preferred one first, where it has two; known at the node that flies it.
 */
ways: Array<VehicleWay>, 
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
model: PluginHealth, 
/**
 * What the model reports of itself, as its state schema has it.
 */
model_state: unknown, 
/**
 * What is changed of its setpoints at this moment; absent if nothing.
 */
avoiding: Avoidance | null, 
/**
 * What is wrong with it in flight and what is done about it; absent if nothing is.
 */
failsafe: FailsafeState | null, 
/**
 * Its charge against its way home; absent as long as one of them is not known.
 */
energy: EnergyState | null, 
/**
 * Its motors were stopped in an emergency.
 */
stopped: boolean, 
/**
 * What it can do, if its model says.
 */
limits: FlightLimits | null, 
/**
 * Whether it can host the coordinator; absent if its model does not say.
 */
capability: CoordinatorCapability | null, 
/**
 * What it carries, by name.
 */
payloads: Array<PayloadSnapshot>, 
/**
 * Why it can do less than it was built for; empty if nothing is amiss.
 */
degraded: Array<string>, };

/**
 * One of two links to one vehicle.
 */
export type VehicleWay = { 
/**
 * What it goes over: `MAVLink` or `DDS`.
 */
name: string, 
/**
 * It carries commands and setpoints now; the other one is heard only.
 */
flies: boolean, 
/**
 * How it is.
 */
link: LinkHealth, };

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

/**
 * A version of the program, by name and content.
 */
export type VersionLabel = { 
/**
 * As it was packed; of the installed package, as it was built.
 */
version: string, 
/**
 * SHA-256 of its archive; absent for the installed package.
 */
digest: string | null, };

/**
 * What a viewer is told as text.
 */
export type VideoMessage = { "type": "state" } & VideoStreamView | { "type": "pong", 
/**
 * The ping's number.
 */
id: number, 
/**
 * Now, in microseconds of the node's clock.
 */
time_us: number, } | { "type": "error", 
/**
 * Why.
 */
reason: string, };

/**
 * A video that is or was recorded.
 */
export type VideoRecording = { 
/**
 * The file's name. Beside it lies one with `.jsonl`: where the vehicle was and how its payloads stood, ten times a second.
 */
file: string, 
/**
 * Its vehicle.
 */
vehicle: VehicleId, 
/**
 * The camera's name there.
 */
payload: string, 
/**
 * Its size in bytes.
 */
bytes: number, 
/**
 * How long it is, in seconds, while it is being recorded; 0 after that.
 */
seconds: number, 
/**
 * It is being recorded.
 */
running: boolean, };

/**
 * A recording that was begun or ended.
 */
export type VideoRecordingAnswer = { 
/**
 * The file's name.
 */
file: string, 
/**
 * How long it is so far, in seconds.
 */
seconds: number, };

/**
 * What is and was recorded on this node.
 */
export type VideoRecordingList = { 
/**
 * The recordings, the newest first.
 */
recordings: Array<VideoRecording>, };

/**
 * What a viewer may say.
 */
export type VideoRequest = { "type": "ping", 
/**
 * Comes back with the answer.
 */
id: number, } | { "type": "key" } | { "type": "seen", 
/**
 * Median in seconds.
 */
p50_s: number, 
/**
 * 99th percentile in seconds.
 */
p99_s: number, };

/**
 * How the video of a camera is, in one word.
 */
export type VideoStateWord = "live" | "starting" | "stalled" | "no_key_picture" | "no_pictures" | "failed";

/**
 * The cameras and how their video is.
 */
export type VideoStreamList = { 
/**
 * One for each camera, by vehicle.
 */
streams: Array<VideoStreamView>, };

/**
 * How the video of a camera is.
 */
export type VideoStreamView = { 
/**
 * The vehicle that carries it.
 */
vehicle: VehicleId, 
/**
 * Its name on the vehicle.
 */
payload: string, 
/**
 * How it is.
 */
state: VideoStateWord, 
/**
 * What is wrong, in words; empty if nothing is.
 */
reason: string, 
/**
 * The H.264 codec after RFC 6381, as `avc1.42c01f`; empty while it is not known.
 */
codec: string, 
/**
 * Width in pixels; 0 while it is not known.
 */
width_px: number, 
/**
 * Height in pixels; 0 while it is not known.
 */
height_px: number, 
/**
 * Pictures per second that the camera gives.
 */
rate_hz: number, 
/**
 * Bytes per second of a camera that encodes; 0 of one that gives pixels.
 */
bytes_per_s: number, 
/**
 * Share of the pictures that were lost on their way here, 0 to 1.
 */
lost: number, 
/**
 * Seconds since the last picture came; none if none ever did.
 */
age_s: number | null, 
/**
 * How many look at it.
 */
viewers: number, };

/**
 * How it is known where a camera looks.
 */
export type ViewSource = "frame" | "gimbal";

/**
 * One of two ways to the others.
 */
export type WaySnapshot = { 
/**
 * The transport.
 */
name: string, 
/**
 * It takes what is sent.
 */
up: boolean, 
/**
 * Why it does not.
 */
fault: string | null, 
/**
 * What goes over it, in bytes per second.
 */
sent_bytes_per_s: number, 
/**
 * What comes over it, in bytes per second.
 */
received_bytes_per_s: number, 
/**
 * How long ago something last came over it, in seconds, if anything ever did.
 */
heard_s: number | null, };

/**
 * Whether a zone is to be stayed in or kept out of.
 */
export type ZoneKind = "inclusion" | "exclusion";

/**
 * The outline of a zone.
 */
export type ZoneOutline = { "shape": "polygon", 
/**
 * Its corners; the first may be repeated at the end.
 */
corners: Array<MapPoint>, } | { "shape": "circle", 
/**
 * Its middle.
 */
centre: MapPoint, 
/**
 * Its radius in metres.
 */
radius_m: number, } | { "shape": "local_polygon", 
/**
 * Its corners as `[north_m, east_m]`.
 */
corners_m: Array<[number, number]>, } | { "shape": "local_circle", 
/**
 * Its middle as `[north_m, east_m]`.
 */
centre_m: [number, number], 
/**
 * Its radius in metres.
 */
radius_m: number, };
