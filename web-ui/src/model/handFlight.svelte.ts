// One vehicle flown by hand from this page: the command it begins with, and twenty sticks a second while the dead-man is held.
// Must never say a stick while nobody looks at the page, nothing is heard, or the dead-man is not held; nor keep one for later.

import { remember, remembered } from '../app/remembered';
import { t } from '../language/language.svelte';
import type { Refusal } from '../protocol/types';
import { refusalText } from '../protocol/words';
import { CENTRED, Grip, SPEEDS, firstPad, isWell, merged, shown, stickOf } from './byHand';
import type { Axes, Order, PadState, Shown, Speed } from './byHand';
import type { Commander } from './commander.svelte';
import type { Control } from './control.svelte';
import type { Session } from './session.svelte';

/** How often it is looked, and a stick said. */
const EVERY_MS = 50;
/** Frames come ten times a second and more: after so long without one nothing is heard. */
const SILENT_MS = 1000;
/** What is refused for now is shown for so long. */
const TROUBLE_SHOWN_MS = 1500;
/** Refusals that may pass by themselves: another node is asked, and does not answer. */
const PASSING: readonly Refusal['reason'][] = ['timed_out', 'not_running', 'clock'];
const KEY = 'skein-hand-speed';

/** What is used of the session, of commands and of authority. */
export type Source = Pick<Session, 'rows' | 'canCommand' | 'fleet' | 'stick' | 'onStickRefused'>;
export type Orders = Pick<Commander, 'run' | 'ledger'>;
export type Authority = Pick<Control, 'heldBy'>;

export class HandFlight {
  speed = $state<Speed>(remembered(KEY, SPEEDS) ?? 'medium');
  /** Which vehicle; null while none is flown by hand from here. */
  vehicle = $state<number | null>(null);
  is = $state<Shown>('off');
  /** Where the sticks are. */
  axes = $state.raw<Axes>(CENTRED);
  /** The gamepad that is read, and one that is there and cannot be. */
  pad = $state('');
  unread = $state('');
  /** This browser gives this page gamepads: over plain HTTP from another computer it may not. */
  allowed = $state(true);
  /** Why the last flight by hand ended; empty if it was ended by hand. */
  ended = $state('');
  /** What a stick was refused for, if that may pass. */
  trouble = $state('');

  /** The dead-man on the screen is held, by a finger or by a key; and where fingers and keys hold the sticks. */
  screenHeld = false;
  fingers: Axes = CENTRED;
  keys: Axes = CENTRED;

  readonly #source: Source;
  readonly #orders: Orders;
  readonly #authority: Authority;
  #grip = new Grip();
  #batch = -1;
  #troubleAt = -Infinity;
  #focused = true;
  #timer: ReturnType<typeof setInterval> | undefined;

  constructor(source: Source, orders: Orders, authority: Authority) {
    this.#source = source;
    this.#orders = orders;
    this.#authority = authority;
    source.onStickRefused((vehicle, refusal) => this.#refused(vehicle, refusal));
  }

  /** The panel is there: pads are looked at from now on. Gives what ends that, and with it the flight. */
  open(): () => void {
    const gone = (): void => {
      this.#focused = false;
      this.#grip.break();
      this.#beat();
    };
    const back = (): void => {
      this.#focused = true;
    };
    const hidden = (): void => {
      if (document.hidden) this.#grip.break();
      this.#beat();
    };
    addEventListener('blur', gone);
    addEventListener('focus', back);
    document.addEventListener('visibilitychange', hidden);
    this.#focused = document.hasFocus();
    this.#timer = setInterval(() => this.#beat(), EVERY_MS);
    return () => {
      clearInterval(this.#timer);
      removeEventListener('blur', gone);
      removeEventListener('focus', back);
      document.removeEventListener('visibilitychange', hidden);
      this.screenHeld = false;
      this.fingers = this.keys = CENTRED;
      this.#over('');
    };
  }

  /** Has a vehicle flown by hand. It stands until the dead-man is taken. */
  begin(vehicle: number): void {
    this.#over('');
    this.vehicle = vehicle;
    this.#grip = new Grip();
    void this.#orders.run({ command: 'steer' }, { vehicles: [vehicle] }, [vehicle], t('Fly by hand'));
    this.#batch = this.#orders.ledger.batches[0]?.key ?? -1;
    this.#beat();
  }

  /** Ends it: the vehicle holds. A leader stands and leads on; a hold would take it out of its formation. */
  end(): void {
    const vehicle = this.vehicle;
    this.#over('');
    const row = this.#source.rows.find(({ id }) => id === vehicle);
    if (vehicle === null || row?.leader) return;
    void this.#orders.run({ command: 'hold' }, { vehicles: [vehicle] }, [vehicle], t('Hold'));
  }

  choose(speed: Speed): void {
    this.speed = speed;
    remember(KEY, speed);
  }

  #over(why: string): void {
    this.vehicle = null;
    this.ended = why;
    this.is = 'off';
    this.trouble = '';
    this.#batch = -1;
  }

  #refused(vehicle: number, refusal: Refusal): void {
    if (vehicle !== this.vehicle) return;
    if (PASSING.includes(refusal.reason)) {
      this.trouble = refusalText(refusal);
      this.#troubleAt = performance.now();
    } else {
      this.#over(refusal.reason === 'wrong_state' ? t('it is not flown by hand any more') : refusalText(refusal));
    }
  }

  /** How the command stands; ends the flight when that is over. */
  #order(): Order {
    if (this.vehicle === null) return 'none';
    const holder = this.#authority.heldBy(this.vehicle);
    const entry = this.#orders.ledger.batches.find(({ key }) => key === this.#batch)?.entries[0];
    if (holder !== '') this.#over(t('under the control of {name}', { name: holder }));
    else if (entry?.phase === 'sending') return 'asked';
    else if (entry?.phase === 'sent' || entry?.phase === 'executing') return 'flown';
    else this.#over(entry?.phase === 'done' ? t('nobody has held the sticks for ten seconds') : (entry?.detail ?? ''));
    return 'over';
  }

  #pads(): readonly (PadState | null)[] {
    try {
      const pads = navigator.getGamepads();
      this.allowed = true;
      return pads;
    } catch {
      this.allowed = false;
      return [];
    }
  }

  #isHeard(now: number): boolean {
    const row = this.#source.rows.find(({ id }) => id === this.vehicle);
    const fresh = row !== undefined && row.staleness !== 'stale' && row.staleness !== 'lost';
    return this.#source.canCommand && fresh && now - this.#source.fleet.receivedAt < SILENT_MS;
  }

  #beat(): void {
    const now = performance.now();
    const { reading, unread } = firstPad(this.#pads());
    this.pad = reading?.name ?? '';
    this.unread = unread;
    const onScreen = merged(this.fingers, this.keys);
    this.axes = merged(reading?.axes ?? CENTRED, onScreen);
    if (now - this.#troubleAt > TROUBLE_SHOWN_MS) this.trouble = '';
    const order = this.#order();
    const attended = !document.hidden && document.hasFocus() && this.#focused;
    const heard = this.#isHeard(now);
    const byPad = reading?.held ?? false;
    const gripped = this.#grip.take(byPad || this.screenHeld, isWell({ order, attended, heard }));
    const before = this.is;
    this.is = shown({ order, attended, heard, gripped, spent: this.#grip.spent });
    if (this.vehicle === null) return;
    if (this.is === 'steering') {
      const held = merged(byPad && reading ? reading.axes : CENTRED, this.screenHeld ? onScreen : CENTRED);
      this.#source.stick(this.vehicle, stickOf(held, this.speed));
    } else if (this.is === 'let go' && before === 'steering') {
      // It need not wait until the last one is too old.
      this.#source.stick(this.vehicle, stickOf(CENTRED, this.speed));
    }
  }
}
