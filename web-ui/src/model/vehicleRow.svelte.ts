// One vehicle as the list shows it. Refreshed a few times a second from the live arrays; a field that did not change wakes no
// DOM. Numbers are already text here: formatting happens once per tick, not per component.

import { FLAG } from '../protocol/frame';
import type { FlightMode, FlightState, GnssFix, VehicleControl, VehicleInfo, VehicleSafety } from '../protocol/types';
import { FLIGHT_MODES, FLIGHT_STATES, GNSS_FIXES, LANDED_STATES } from '../protocol/words';
import type { Fleet } from '../telemetry/fleet';
import { ageText, classify } from '../telemetry/staleness';
import type { Staleness } from '../telemetry/staleness';
import { pluginSummary } from './pluginWords';
import { LEVEL, problemsOf, worst } from './severity';
import type { Level } from './severity';
import { percentText, returnText, safetyProblems } from './vehicleSafety';
import { t } from '../language/language.svelte';
import { errorText, figureText } from '../language/units.svelte';

/** What stands where a value is not known. */
export const UNKNOWN = '–';

export class VehicleRow {
  present = $state(true);
  simulated = $state(false);
  name = $state('');
  plugin = $state('');
  stateDetail = $state('');
  flightState = $state<FlightState>('idle');
  mode = $state<FlightMode>('unknown');
  fix = $state<GnssFix>('unknown');
  staleness = $state<Staleness>('live');
  age = $state('');
  armed = $state(false);
  airborne = $state(false);
  leader = $state(false);
  readyToArm = $state(false);
  level = $state<Level>(LEVEL.normal);
  problems = $state('');
  /** What the failsafe policy, the energy and the avoidance say of it; null until they are known. */
  safety = $state.raw<VehicleSafety | null>(null);
  /** Its motors were stopped in an emergency. */
  stopped = $state(false);
  /** Charge that the way home costs, reserve included, and the time until it must return. */
  neededHome = $state(UNKNOWN);
  returnIn = $state(UNKNOWN);
  /** Percent in whole numbers, or null. */
  battery = $state<number | null>(null);
  voltage = $state(UNKNOWN);
  satellites = $state(0);
  loss = $state(0);
  roundTrip = $state(UNKNOWN);
  setpointRate = $state(UNKNOWN);
  height = $state(UNKNOWN);
  speed = $state(UNKNOWN);
  trackingError = $state(UNKNOWN);
  /** Height above the launch place for the map; NaN if not known. Not reactive: the map draws when it is woken. */
  heightM = NaN;
  /** For sorting and for charts, NaN if not known. Not reactive either. */
  speedMS = NaN;
  errorM = NaN;
  ageMs = 0;
  returnS = NaN;
  actorRestarts = $state(0);
  modelRestarts = $state(0);
  /** How its plugins are, in a few words. */
  pluginsText = $state(UNKNOWN);
  pluginsLevel = $state<Level>(LEVEL.normal);
  /** The node that flies it; null without a swarm. */
  node = $state<number | null>(null);
  /** Its clock does not fit: an alarm of the failsafe policy says so. */
  clockTrouble = $state(false);

  /** The name of who has control authority over it, empty if nobody has; and whether that is this page. */
  holder = $state('');
  mine = $state(false);

  constructor(
    readonly id: number,
    readonly index: number,
  ) {
    this.name = t('vehicle {id}', { id });
  }

  /** Brings every field up to date. While the server is not heard (`heard` false) no new problem is found: the page has one, not
      every vehicle. */
  refresh(fleet: Fleet, info: VehicleInfo | undefined, safety: VehicleSafety | null, now: number, heard: boolean): void {
    const i = this.index;
    const ageMs = fleet.ageMs(i, now);
    this.ageMs = ageMs;
    this.present = fleet.present[i] === 1;
    this.staleness = classify(ageMs, fleet.has(i, FLAG.connected));
    this.age = ageText(ageMs);
    this.flightState = FLIGHT_STATES[fleet.flightState[i] ?? 0] ?? 'idle';
    this.mode = FLIGHT_MODES[fleet.mode[i] ?? 0] ?? 'unknown';
    this.fix = GNSS_FIXES[fleet.fix[i] ?? 0] ?? 'unknown';
    this.armed = fleet.has(i, FLAG.armed);
    const landed = LANDED_STATES[fleet.landed[i] ?? 0] ?? 'unknown';
    // Not known counts as in the air while the motors may turn.
    this.airborne = landed === 'unknown' ? this.armed : landed !== 'on_ground';
    this.leader = fleet.has(i, FLAG.leader);
    this.readyToArm = fleet.has(i, FLAG.ready);
    const battery = fleet.batteryPercent[i] ?? NaN;
    this.battery = Number.isNaN(battery) ? null : battery;
    const volts = fleet.batteryV[i] ?? 0;
    this.voltage = volts > 0 ? `${volts.toFixed(1)} V` : UNKNOWN;
    this.satellites = fleet.satellites[i] ?? 0;
    this.loss = fleet.lossPercent[i] ?? 0;
    this.roundTrip = measured(fleet.roundTripMs[i], 'ms');
    this.setpointRate = (fleet.setpointHz[i] ?? 0) > 0 ? `${Math.round(fleet.setpointHz[i] ?? 0)} Hz` : UNKNOWN;
    this.actorRestarts = Math.max(0, (fleet.actorIncarnation[i] ?? 1) - 1);
    this.modelRestarts = Math.max(0, (fleet.modelIncarnation[i] ?? 1) - 1);
    this.#refreshMotion(fleet, info);
    this.#refreshSafety(safety);
    if (info) {
      this.name = info.name;
      this.simulated = info.simulated === true;
      this.plugin = `${info.plugin} ${info.plugin_version}`;
      this.stateDetail = info.state_detail;
      this.node = info.node ?? null;
      ({ text: this.pluginsText, level: this.pluginsLevel } = pluginSummary(info));
    }
    if (heard) this.#assess(fleet, info);
  }

  refreshControl(control: VehicleControl | undefined, console: string): void {
    this.holder = control?.console.name ?? '';
    this.mine = control?.console.id === console;
  }

  #refreshSafety(safety: VehicleSafety | null): void {
    this.safety = safety;
    this.stopped = safety?.stopped ?? false;
    this.clockTrouble = safety?.failsafe?.alarms.some((alarm) => alarm.trigger === 'clock_fault') ?? false;
    const energy = safety?.energy ?? null;
    this.returnS = energy?.return_in_s ?? NaN;
    if (!energy) this.neededHome = this.returnIn = UNKNOWN;
    else {
      this.neededHome = energy.needed_home === null ? t('out of reach') : percentText(energy.needed_home + energy.reserve);
      this.returnIn = returnText(energy);
    }
  }

  #refreshMotion(fleet: Fleet, info: VehicleInfo | undefined): void {
    const i = this.index;
    if (!fleet.has(i, FLAG.position)) {
      this.height = this.speed = this.trackingError = UNKNOWN;
      this.heightM = this.speedMS = this.errorM = NaN;
      return;
    }
    const ground = info?.home?.altitude_amsl_m;
    this.heightM = ground === undefined ? NaN : (fleet.altitudeM[i] ?? 0) - ground;
    this.height = ground === undefined ? UNKNOWN : figureText('height', this.heightM);
    const speed = Math.hypot(fleet.velocityNorth[i] ?? 0, fleet.velocityEast[i] ?? 0, fleet.velocityDown[i] ?? 0);
    this.speedMS = speed;
    this.speed = figureText('speed', speed);
    const error = fleet.trackingErrorM[i] ?? NaN;
    this.errorM = error;
    this.trackingError = Number.isNaN(error) ? UNKNOWN : errorText(error);
  }

  #assess(fleet: Fleet, info: VehicleInfo | undefined): void {
    const i = this.index;
    const problems = problemsOf({
      staleness: this.staleness,
      flightState: this.flightState,
      airborne: this.airborne,
      armed: this.armed,
      batteryPercent: fleet.batteryPercent[i] ?? NaN,
      lossPercent: this.loss,
      fix: fleet.fix[i] ?? 0,
      hasPosition: fleet.has(i, FLAG.position),
      trackingErrorM: fleet.trackingErrorM[i] ?? NaN,
      pilotControl: fleet.has(i, FLAG.pilot),
      faulted: fleet.has(i, FLAG.faulted),
      actor: info?.actor.status ?? 'running',
      model: info?.model.status ?? 'running',
      degraded: (info?.degraded.length ?? 0) > 0,
    });
    problems.push(...safetyProblems(this.safety, this.airborne));
    problems.sort((a, b) => b.level - a.level);
    this.level = worst(problems);
    this.problems = problems.map((p) => p.text).join(' · ');
  }
}

function measured(value: number | undefined, unit: string): string {
  if (value === undefined || Number.isNaN(value)) return UNKNOWN;
  return `${value < 10 ? value.toFixed(1) : Math.round(value)} ${unit}`;
}
