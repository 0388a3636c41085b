// The words of the JSON side of the wire, as the server's own types spell them (snake_case words, tagged unions).
// Must never hold behaviour: only shapes.

export type FlightMode =
  | 'unknown' | 'manual' | 'altitude' | 'position' | 'acro' | 'stabilized' | 'offboard' | 'ready' | 'take_off' | 'hold'
  | 'mission' | 'return' | 'land' | 'descend' | 'termination';

export type LandedState = 'unknown' | 'on_ground' | 'in_air' | 'taking_off' | 'landing';

export type GnssFix = 'unknown' | 'none' | 'two_d' | 'three_d' | 'dgps' | 'rtk_float' | 'rtk_fixed';

export type FlightState =
  | 'idle' | 'arming' | 'taking_off' | 'holding' | 'going_to' | 'following' | 'leading' | 'returning' | 'landing'
  | 'pilot_control' | 'faulted';

export type Severity = 'info' | 'advisory' | 'warning' | 'critical';

export type Shape = 'line' | 'column' | 'wedge' | 'circle' | 'grid';

export type Geodetic = { latitude_deg: number; longitude_deg: number; altitude_amsl_m: number };

export type PositionNed = { north_m: number; east_m: number; down_m: number };

export type SwarmFrame = { origin: Geodetic };

export type HeadingRequest = { kind: 'auto' } | { kind: 'course' } | { kind: 'fixed'; heading_deg: number };

export type FormationRequest = {
  shape: Shape;
  spacing_m: number;
  heading: HeadingRequest;
  altitude_step_m: number;
  leader: number | null;
  members: number[] | null;
};

export type Route = { waypoints: PositionNed[]; speed_m_s: number; corner_radius_m: number };

export type VehicleCommand =
  | { command: 'arm' }
  | { command: 'disarm' }
  | { command: 'take_off'; height_m: number }
  | { command: 'land' }
  | { command: 'land_at'; spot: PositionNed }
  | { command: 'hold' }
  | { command: 'return' }
  | { command: 'go_to'; position: PositionNed; yaw_rad: number | null; speed_m_s: number | null };

export type Targets = 'all' | { vehicles: number[] };

export type Refusal =
  | { reason: 'unknown_vehicle'; vehicle: number }
  | { reason: 'link_lost'; vehicle: number }
  | { reason: 'wrong_state'; state: FlightState; command: string }
  | { reason: 'pilot_in_control' }
  | { reason: 'not_ready_to_arm'; detail: string }
  | { reason: 'autopilot'; result: string; text: string }
  | { reason: 'timed_out'; what: string; after_s: number }
  | { reason: 'superseded' }
  | { reason: 'outside_fence'; detail: string }
  | { reason: 'too_fast'; speed_m_s: number; limit_m_s: number }
  | { reason: 'too_close'; other: number; distance_m: number; limit_m: number }
  | { reason: 'invalid_value'; detail: string }
  | { reason: 'no_swarm_frame' }
  | { reason: 'no_position' }
  | { reason: 'not_enough_vehicles'; have: number; need: number }
  | { reason: 'stale_incarnation'; got: number; current: number }
  | { reason: 'duplicate_system_id'; system_id: number }
  | { reason: 'not_running'; what: string }
  | { reason: 'not_permitted'; detail: string };

export type CommandProgress =
  | { progress: 'executing' }
  | { progress: 'done' }
  | { progress: 'refused'; refusal: Refusal };

export type CommandReceipt = { vehicle: number; id: number; refusal: Refusal | null };

export type FormationReceipt = {
  leader: number;
  members: number[];
  duration_s: number;
  planned_min_distance_m: number;
};

export type ActorStatus = 'running' | 'restarting' | 'given_up';

export type ActorHealth = {
  name: string;
  status: ActorStatus;
  incarnation: number;
  last_error: string;
  since: number;
};

export type FormationSnapshot = {
  request: FormationRequest;
  leader: number;
  members: number[];
  route: Route | null;
  route_finished: boolean;
  settled_at: number;
  planned_min_distance_m: number;
  intent_version: number;
};

export type UnadoptedVehicle = { system_id: number; endpoint: string; why: string };

export type EventKind =
  | { kind: 'adopted' }
  | { kind: 'not_adopted' }
  | { kind: 'link_lost' }
  | { kind: 'link_regained' }
  | { kind: 'autopilot_rebooted' }
  | { kind: 'flight_state'; state: FlightState }
  | { kind: 'command'; id: number; command: string; progress: CommandProgress }
  | { kind: 'refused'; refusal: Refusal }
  | { kind: 'formation' }
  | { kind: 'supervision'; actor: string; status: ActorStatus }
  | { kind: 'stream' }
  | { kind: 'status_text' }
  | { kind: 'notice' };

/** Microseconds on the node's clock. */
export type NodeTime = number;

export type EventRecord = {
  seq: number;
  time: NodeTime;
  vehicle: number | null;
  severity: Severity;
  kind: EventKind;
  text: string;
};

/** What changes seldom about one vehicle. */
export type VehicleInfo = {
  id: number;
  name: string;
  system_id: number;
  plugin: string;
  plugin_version: string;
  state_detail: string;
  home: Geodetic | null;
  actor: ActorHealth;
  model: ActorHealth;
};

/** A fence as the map can draw it: corners in the swarm frame, limits as heights above its origin. */
export type FenceInfo = { polygon_m: [number, number][]; floor_m: number; ceiling_m: number };

/** Everything that changes seldom: sent whenever it does. */
export type FleetInfo = {
  frame: SwarmFrame | null;
  vehicles: VehicleInfo[];
  unadopted: UnadoptedVehicle[];
  formation: FormationSnapshot | null;
  actors: ActorHealth[];
  fence: FenceInfo | null;
  faults_enabled: boolean;
};

export type Hello = { protocol: number; version: string; node: string };

/** A text message of the stream. */
export type ServerMessage =
  | ({ type: 'hello' } & Hello)
  | ({ type: 'fleet' } & FleetInfo)
  | ({ type: 'event' } & EventRecord)
  | { type: 'gap'; missed: number }
  | { type: 'rate'; rate_hz: number }
  | { type: 'error'; error: ErrorDetail };

/** Body of an answer that is not 2xx. */
export type ErrorDetail = { code: string; message: string; detail: unknown };
export type ErrorBody = { error: ErrorDetail };

/** Events after a given one, and how many between are no longer kept. */
export type EventList = { events: EventRecord[]; missed: number };
