// The page's side of the connection: puts what the stream says where it belongs and beats the tick the list lives on.
// Must never send a command.

import { getEvents, measureLatencyMs } from '../protocol/rest';
import { Stream } from '../protocol/stream';
import type { SaidStick, StreamState } from '../protocol/stream';
import { streamUrl } from '../protocol/streamUrl';
import type { EventRecord, FleetInfo, Refusal, ReplayState, SwarmSnapshot, VehicleControl, VehicleInfo, VehicleSafety } from '../protocol/types';
import { carry } from '../telemetry/carry';
import { Fleet } from '../telemetry/fleet';
import type { Commander } from './commander.svelte';
import type { Journal } from './journal.svelte';
import { Replay } from './replay.svelte';
import { Tracks } from './tracks.svelte';
import { VehicleRow } from './vehicleRow.svelte';
import { t } from '../language/language.svelte';

/** How often the list is brought up to date. */
const TICK_MS = 250;
const LATENCY_EVERY_MS = 5000;
/** Frames per second asked for: at a desk, on a tablet or of a crowd, and while nobody looks. */
const RATE_DESK_HZ = 20;
const RATE_LOW_HZ = 10;
const RATE_HIDDEN_HZ = 1;
/** More vehicles than this are a crowd: none of them is watched so closely, and every frame costs the more. */
const CROWD = 100;
/** The server's clock being behind by more than this, had it gone on since it was last heard, means that it is another run of it. */
const RESTART_MS = 2000;

const NO_INFO: FleetInfo = {
  frame: null, vehicles: [], unadopted: [], formation: null, actors: [], faults_enabled: false,
  dead_man: { state: 'off', warns_after_s: null },
  resume: null,
  recorder: { state: 'off', file: null, in_flight: false, why: null, last_flight: null },
};

export class Session {
  readonly fleet = new Fleet();
  state = $state.raw<StreamState>({ name: 'connecting' });
  info = $state.raw<FleetInfo>(NO_INFO);
  /** The nodes of the swarm; null where the node flies its vehicles alone. */
  swarm = $state.raw<SwarmSnapshot | null>(null);
  /** Who has control authority over which vehicle, by its id; nobody has it over the others. */
  control = $state.raw<ReadonlyMap<number, VehicleControl>>(new Map());
  /** The recorded flight that is shown, if it is one. */
  readonly replay = new Replay();
  readonly tracks = new Tracks(() => this.replay.pace);
  rows = $state.raw<readonly VehicleRow[]>([]);
  /** Counts ticks; reading it in an effect makes the effect run with the list. */
  tick = $state(0);
  /** `performance.now()` of the last tick. */
  now = $state(0);
  latencyMs = $state<number | null>(null);
  frameHz = $state(0);
  /** When the connection was last lost, on the `performance.now()` clock; null while it stands. */
  lostAt = $state<number | null>(null);
  everLive = $state(false);
  hasFrame = $state(false);
  /** Frames come in. */
  hears = $derived(this.state.name === 'live' && this.hasFrame);
  /** Commands go out only while frames come in, and never to what is a recorded flight. */
  canCommand = $derived(this.hears && !this.replay.on);
  hello = $derived(this.state.name === 'live' || this.state.name === 'incompatible' ? this.state.hello : null);

  #stream: Stream;
  #rowById = new Map<number, VehicleRow>();
  /** By the vehicle's index in the live arrays, for the map. */
  #rowByIndex: VehicleRow[] = [];
  #infoById = new Map<number, VehicleInfo>();
  #safetyById = new Map<number, VehicleSafety>();
  #frameListeners: (() => void)[] = [];
  #eventListeners: ((event: EventRecord) => void)[] = [];
  #liveListeners: (() => void)[] = [];
  #restartListeners: ((sameVehicles: boolean) => void)[] = [];
  #controlListeners: (() => void)[] = [];
  #stickListeners: ((vehicle: number, refusal: Refusal) => void)[] = [];
  #waiting: EventRecord[] = [];
  #historyLoaded = false;
  #historyRequested = false;
  /** What is loaded happened before the page looked at it: it is no news. */
  #firstLoad = true;
  #load = 0;
  /** On this connection it was said that a recorded flight is shown. */
  #saidReplay = false;
  /** The next frame is the first one of another moment. */
  #elsewhere = false;
  #framesAtTick = 0;
  #timers: ReturnType<typeof setInterval>[] = [];

  constructor(
    readonly commander: Commander,
    readonly journal: Journal,
    /** The id of the console that this page is. */
    readonly console: string,
  ) {
    this.#stream = new Stream(streamUrl(document.baseURI, console), {
      state: (state) => this.#onState(state),
      frame: (buffer, at) => this.#onFrame(buffer, at),
      fleet: (info) => this.#onFleet(info),
      safety: (vehicles) => this.#onSafety(vehicles),
      control: (vehicles) => this.#onControl(vehicles),
      tracks: (list, at) => this.tracks.take(list, at),
      replay: (state) => this.#onReplay(state),
      swarm: (swarm) => (this.swarm = swarm),
      event: (event) => (this.#historyLoaded ? this.#takeEvent(event) : this.#waiting.push(event)),
      gap: (missed) => journal.notice('warning', 'stream', t('{missed} events did not reach this page', { missed })),
      unreadable: (why) => journal.notice('warning', 'stream', why),
      stickRefused: (vehicle, refusal) => {
        for (const listener of this.#stickListeners) listener(vehicle, refusal);
      },
    });
  }

  start(): void {
    this.#applyRate();
    document.addEventListener('visibilitychange', () => this.#applyRate());
    this.#timers.push(setInterval(() => this.#beat(), TICK_MS));
    this.#timers.push(setInterval(() => void this.#measure(), LATENCY_EVERY_MS));
    this.#stream.start();
  }

  retryNow(): void {
    this.#stream.retryNow();
  }

  /** Calls `listener` after every frame: the map's wake-up, outside of the framework. */
  onFrame(listener: () => void): () => void {
    this.#frameListeners.push(listener);
    return () => {
      this.#frameListeners = this.#frameListeners.filter((l) => l !== listener);
    };
  }

  /** Calls `listener` with every event that is news. */
  onEvent(listener: (event: EventRecord) => void): void {
    this.#eventListeners.push(listener);
  }

  /** Calls `listener` with the first frame of every connection. */
  onLive(listener: () => void): void {
    this.#liveListeners.push(listener);
  }

  /** Calls `listener` when nothing that was known of the vehicles holds any more: the server turns out to be another run, or a recording is at another
      moment, where they are the same vehicles. */
  onRestart(listener: (sameVehicles: boolean) => void): void {
    this.#restartListeners.push(listener);
  }

  /** Calls `listener` when the server has said anew who has control authority over which vehicle. */
  onControl(listener: () => void): void {
    this.#controlListeners.push(listener);
  }

  /** Calls `listener` when a stick was refused. */
  onStickRefused(listener: (vehicle: number, refusal: Refusal) => void): void {
    this.#stickListeners.push(listener);
  }

  /** Says how a vehicle that is flown by hand is to move; whether it went out. */
  stick(vehicle: number, stick: SaidStick): boolean {
    return this.#stream.stick(vehicle, stick);
  }

  /** What the node's clock says now, in ms. */
  serverNowMs(): number {
    return this.fleet.serverTimeMs + (performance.now() - this.fleet.receivedAt) * this.replay.pace;
  }

  /** The clock that what is shown goes by, in ms: this page's, but in a recording that of the flight. */
  shownNowMs(): number {
    return this.replay.on ? this.fleet.serverTimeMs : performance.now();
  }

  /** The row of the vehicle at an index of the live arrays, once the list has seen it. */
  rowAt(index: number): VehicleRow | undefined {
    return this.#rowByIndex[index];
  }

  infoOf(id: number): VehicleInfo | undefined {
    return this.#infoById.get(id);
  }

  /** Wall-clock ms of a moment on the node's clock. */
  wallClockOf(nodeTimeUs: number): number {
    return this.replay.wallClockMs(nodeTimeUs) ?? Date.now() - (this.serverNowMs() - nodeTimeUs / 1000);
  }

  #applyRate(): void {
    const low = matchMedia('(pointer: coarse)').matches || this.rows.length > CROWD;
    this.#stream.setRate(document.hidden ? RATE_HIDDEN_HZ : low ? RATE_LOW_HZ : RATE_DESK_HZ);
  }

  #onState(state: StreamState): void {
    this.state = state;
    this.hasFrame = false;
    if (state.name === 'live') {
      this.#historyLoaded = false;
      this.#historyRequested = false;
      this.#saidReplay = false;
      this.#waiting = [];
      // It is said again at once if anybody has a vehicle, and not at all if nobody has.
      this.control = new Map();
      this.tracks.clear();
      // Not at once: the first moments are busy and would be measured instead of the link.
      setTimeout(() => void this.#measure(), 1500);
    }
    if (state.name === 'lost' && this.lostAt === null) {
      this.lostAt = performance.now();
      this.latencyMs = null;
      this.commander.dispatch({ type: 'connection_lost' });
      if (this.everLive) this.journal.notice('warning', 'connection', t('connection to the server lost: {reason}', { reason: state.reason }));
    }
  }

  #onFrame(buffer: ArrayBuffer, at: number): void {
    const expectedMs = this.serverNowMs();
    const arrived = this.#elsewhere;
    if (arrived) this.#forgetVehicles();
    this.#elsewhere = false;
    try {
      this.fleet.take(buffer, at);
    } catch (error) {
      this.journal.notice('warning', 'stream', error instanceof Error ? error.message : String(error));
      return;
    }
    this.replay.heard(this.fleet.serverTimeMs, at, arrived);
    if (!this.hasFrame) this.#firstFrame(arrived ? -Infinity : expectedMs, buffer, at);
    else if (arrived) this.#beat();
    // Not back to what was said until the next picture: what is picked is what is seen.
    carry(this.fleet, performance.now(), this.replay.pace);
    for (const listener of this.#frameListeners) listener();
  }

  /** The first frame of a connection tells whether the server is the one we knew. */
  #firstFrame(expectedMs: number, buffer: ArrayBuffer, at: number): void {
    if (this.everLive && this.fleet.serverTimeMs + RESTART_MS < expectedMs) {
      this.#forgetVehicles();
      // Of a recording it is another moment of it.
      if (this.replay.on) this.#goElsewhere(true);
      else this.#serverRestarted();
      this.#elsewhere = false;
      this.fleet.take(buffer, at);
    }
    if (this.everLive && this.lostAt !== null) this.journal.notice('info', 'connection', t('connection to the server is back'));
    this.hasFrame = true;
    this.everLive = true;
    this.lostAt = null;
    this.#beat();
    if (!this.#historyRequested) {
      this.#historyRequested = true;
      void this.#loadHistory();
    }
    for (const listener of this.#liveListeners) listener();
  }

  #serverRestarted(): void {
    this.#safetyById.clear();
    this.rows = [];
    this.journal.restart();
    this.commander.dispatch({ type: 'server_restarted' });
    this.journal.notice('advisory', 'connection', t('the server was restarted'));
    for (const listener of this.#restartListeners) listener(false);
  }

  #onReplay(state: ReplayState): void {
    const wasOn = this.replay.on;
    this.#saidReplay = true;
    const is = this.replay.take(state);
    if (is !== 'same') this.#goElsewhere(is === 'moment');
    else if (!wasOn && this.everLive) this.#goElsewhere(false);
  }

  /** What the server says from now on is of another moment, or of other vehicles: nothing that is known holds, and nothing that led there is news. The
      vehicles are forgotten with its first frame, so that the page is not empty meanwhile. */
  #goElsewhere(sameVehicles: boolean): void {
    this.#elsewhere = true;
    this.#safetyById.clear();
    this.tracks.restart();
    this.journal.clear();
    this.#firstLoad = true;
    this.#historyLoaded = false;
    this.#historyRequested = true;
    this.#waiting = [];
    void this.#loadHistory();
    for (const listener of this.#restartListeners) listener(sameVehicles);
  }

  #forgetVehicles(): void {
    this.fleet.reset();
    this.#rowById.clear();
    this.#rowByIndex = [];
    this.fleet.setOrigin(this.info.frame?.origin ?? null);
  }

  async #loadHistory(): Promise<void> {
    const load = ++this.#load;
    try {
      const { events } = await getEvents(this.journal.log.lastSeq);
      if (load !== this.#load) return;
      for (const event of events) this.#takeEvent(event);
    } catch {
      if (load !== this.#load) return;
      this.journal.notice('advisory', 'connection', t('earlier events could not be fetched'));
    }
    this.#firstLoad = false;
    this.#historyLoaded = true;
    for (const event of this.#waiting.splice(0)) this.#takeEvent(event);
  }

  #takeEvent(event: EventRecord): void {
    const name = event.vehicle === null ? '' : this.#infoById.get(event.vehicle)?.name;
    if (!this.journal.take(event, this.wallClockOf(event.time), name)) return;
    if (this.#firstLoad) return;
    if (!this.replay.on) this.commander.takeEvent(event);
    for (const listener of this.#eventListeners) listener(event);
  }

  #onFleet(info: FleetInfo): void {
    // A recorded flight is named before anything else is said.
    if (this.replay.on && !this.#saidReplay) {
      this.replay.leave();
      this.#goElsewhere(false);
    }
    this.info = info;
    this.#infoById = new Map(info.vehicles.map((v) => [v.id, v]));
    this.fleet.setOrigin(info.frame?.origin ?? null);
  }

  /** It shows with the next tick. */
  #onSafety(vehicles: readonly VehicleSafety[]): void {
    for (const safety of vehicles) this.#safetyById.set(safety.id, safety);
  }

  #onControl(vehicles: readonly VehicleControl[]): void {
    this.control = new Map(vehicles.map((one) => [one.vehicle, one]));
    for (const listener of this.#controlListeners) listener();
  }

  #beat(): void {
    const now = performance.now();
    const fleet = this.fleet;
    let added = false;
    for (let index = 0; index < fleet.size; index++) {
      const id = fleet.ids[index] ?? 0;
      let row = this.#rowById.get(id);
      if (!row) {
        row = new VehicleRow(id, index);
        this.#rowById.set(id, row);
        this.#rowByIndex[index] = row;
        added = true;
      }
      row.refresh(fleet, this.#infoById.get(id), this.#safetyById.get(id) ?? null, now, this.lostAt === null);
      row.refreshControl(this.control.get(id), this.console);
    }
    const changed = added || this.rows.length !== fleet.presentCount || this.rows.some((row) => !row.present);
    if (changed) {
      this.rows = [...this.#rowById.values()].filter((r) => r.present).sort((a, b) => a.id - b.id);
      this.#applyRate();
    }
    const frames = fleet.framesTaken - this.#framesAtTick;
    this.#framesAtTick = fleet.framesTaken;
    const elapsed = Math.max(1, now - this.now);
    if (elapsed > TICK_MS / 2) this.frameHz += ((frames * 1000) / elapsed - this.frameHz) * 0.3;
    this.now = now;
    this.journal.pass(this.replay.wallNowMs() ?? Date.now());
    this.tick++;
  }

  async #measure(): Promise<void> {
    if (this.state.name !== 'live') return;
    try {
      this.latencyMs = await measureLatencyMs();
    } catch {
      this.latencyMs = null;
    }
  }
}
