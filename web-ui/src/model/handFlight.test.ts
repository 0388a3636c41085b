// A flight by hand from the page, with a pad, a page and a node that are stood in for: what is said, and when nothing is.

import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import type { Refusal } from '../protocol/types';
import { LIMITS } from './byHand';
import type { PadState, Shown, Stick } from './byHand';
import type { Phase } from './commandLedger';
import { HandFlight } from './handFlight.svelte';
import type { Authority, Orders, Source } from './handFlight.svelte';

const ID = 3;
const FORWARD = [0, 0, 0, -1];
const EVERY_MS = 50;

let page: EventTarget & { hidden: boolean; focused: boolean; hasFocus: () => boolean };
let pads: (PadState | null)[];

function pad(held: boolean, axes = FORWARD): PadState {
  return { id: 'Test Pad (STANDARD GAMEPAD)', connected: true, mapping: 'standard', axes, buttons: Array.from({ length: 17 }, (_, at) => ({ pressed: at === 5 && held })) };
}

function made() {
  const sticks: Stick[] = [];
  const commands: string[] = [];
  let refuse: (vehicle: number, refusal: Refusal) => void = () => undefined;
  const row = { id: ID, staleness: 'live', leader: false };
  const node = { heard: true, canCommand: true, holder: '', phase: 'sending' as Phase, detail: '' };
  let batch = 0;
  let lastHeard = 0;
  const source = {
    rows: [row],
    get canCommand() {
      return node.canCommand;
    },
    fleet: {
      get receivedAt() {
        if (node.heard) lastHeard = performance.now();
        return lastHeard;
      },
    },
    stick: (vehicle: number, stick: Stick) => {
      expect(vehicle).toBe(ID);
      sticks.push(stick);
      return true;
    },
    onStickRefused: (listener: typeof refuse) => void (refuse = listener),
  };
  const orders = {
    run: (command: { command: string }) => {
      commands.push(command.command);
      batch++;
      node.phase = 'sending';
      return Promise.resolve();
    },
    get ledger() {
      return { batches: [{ key: batch, entries: [{ phase: node.phase, detail: node.detail }] }], early: [] };
    },
  };
  const hand = new HandFlight(source as unknown as Source, orders as unknown as Orders, { heldBy: () => node.holder } satisfies Authority);
  const close = hand.open();
  return {
    hand, row, node, sticks, commands, close,
    refuse: (refusal: Refusal, vehicle = ID) => refuse(vehicle, refusal),
    /** Lets some looks pass; what was said meanwhile. */
    pass: (looks = 4): Stick[] => {
      const before = sticks.length;
      vi.advanceTimersByTime(looks * EVERY_MS);
      return sticks.slice(before);
    },
  };
}

/** Steering: the command is in force, the dead-man was taken after that. */
function steering() {
  const all = made();
  all.hand.choose('medium');
  all.hand.begin(ID);
  all.node.phase = 'executing';
  pads = [pad(false)];
  all.pass();
  pads = [pad(true)];
  expect(all.pass(4)).toHaveLength(4);
  expect(all.hand.is).toBe('steering');
  return all;
}

beforeEach(() => {
  const global = new EventTarget();
  page = Object.assign(new EventTarget(), { hidden: false, focused: true, hasFocus: () => page.focused });
  pads = [];
  vi.stubGlobal('document', page);
  vi.stubGlobal('navigator', { getGamepads: () => pads });
  for (const name of ['addEventListener', 'removeEventListener', 'dispatchEvent'] as const) vi.stubGlobal(name, global[name].bind(global));
  vi.stubGlobal('localStorage', { getItem: () => null, setItem: () => undefined });
  vi.useFakeTimers({ toFake: ['setInterval', 'clearInterval', 'performance'] });
});
afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

describe('a flight by hand', () => {
  it('begins with the command, and says nothing before that is taken up', () => {
    const { hand, node, commands, pass } = made();
    pads = [pad(false)];
    hand.begin(ID);
    expect([commands, hand.is]).toEqual([['steer'], 'asked']);
    pads = [pad(true)];
    expect(pass()).toEqual([]);
    node.phase = 'sent';
    // The dead-man was held already: it has to be taken anew.
    expect([pass(), hand.is]).toEqual([[], 'spent']);
    pads = [pad(false)];
    pass(1);
    pads = [pad(true)];
    expect([pass(2).length, hand.is, hand.pad]).toEqual([2, 'steering', 'Test Pad']);
  });

  it('says twenty sticks a second, as fast as was chosen', () => {
    const { hand, pass } = steering();
    expect(pass(20)).toHaveLength(20);
    expect(pass(1)).toEqual([{ forward_m_s: LIMITS.medium.levelMS, right_m_s: 0, up_m_s: 0, yaw_rate_rad_s: 0 }]);
    hand.choose('slow');
    expect(pass(1)[0]?.forward_m_s).toBe(LIMITS.slow.levelMS);
  });

  it('that is let go says the middle once and then nothing', () => {
    const { hand, pass } = steering();
    pads = [pad(false)];
    expect(pass(10)).toEqual([{ forward_m_s: 0, right_m_s: 0, up_m_s: 0, yaw_rate_rad_s: 0 }]);
    expect(hand.is).toBe('let go');
  });

  type Leaving = readonly [what: string, shown: Shown, leave: () => void, come: () => void];
  const leavings: readonly Leaving[] = [
    ['lost focus', 'away', () => (page.focused = false), () => (page.focused = true)],
    ['a window that is left', 'away', () => dispatchEvent(new Event('blur')), () => dispatchEvent(new Event('focus'))],
    ['a hidden page', 'away', () => (page.hidden = true), () => (page.hidden = false)],
  ];

  it.each(leavings)('says nothing with %s, nor when it is back while the dead-man is still held', (_, shown, leave, come) => {
    const { hand, pass } = steering();
    leave();
    expect([pass(10), hand.is]).toEqual([[], shown]);
    come();
    expect([pass(10), hand.is]).toEqual([[], 'spent']);
    pads = [pad(false)];
    pass(1);
    pads = [pad(true)];
    expect(pass(2)).toHaveLength(2);
  });

  it('says nothing after a window was left and entered again between two looks', () => {
    const { pass } = steering();
    dispatchEvent(new Event('blur'));
    dispatchEvent(new Event('focus'));
    expect(pass()).toEqual([]);
  });

  it('says nothing once the pad is gone', () => {
    const { hand, pass } = steering();
    pads = [{ ...pad(true), connected: false }];
    pass(1);
    expect(pass(10)).toEqual([]);
    expect([hand.is, hand.pad]).toEqual(['let go', '']);
  });

  it('says nothing when nothing is heard, of the node or of the vehicle', () => {
    const silent = steering();
    silent.node.heard = false;
    silent.pass(21);
    expect([silent.pass(10), silent.hand.is]).toEqual([[], 'lost']);
    const gone = steering();
    gone.row.staleness = 'lost';
    expect([gone.pass(), gone.hand.is]).toEqual([[], 'lost']);
    const away = steering();
    away.node.canCommand = false;
    expect([away.pass(), away.hand.is]).toEqual([[], 'lost']);
  });

  it('ends when somebody else has the vehicle, and says who', () => {
    const { hand, node, pass } = steering();
    node.holder = 'Ben';
    expect([pass(), hand.is, hand.vehicle, hand.ended]).toEqual([[], 'off', null, 'under the control of Ben']);
  });

  it('ends with the command, and with a stick that is refused for good', () => {
    const done = steering();
    done.node.phase = 'done';
    expect([done.pass(), done.hand.ended]).toEqual([[], 'nobody has held the sticks for ten seconds']);
    const replaced = steering();
    Object.assign(replaced.node, { phase: 'replaced', detail: 'replaced by a newer command' });
    expect([replaced.pass(), replaced.hand.ended]).toEqual([[], 'replaced by a newer command']);
    const refused = steering();
    refused.refuse({ reason: 'wrong_state', state: 'holding', command: 'steer' });
    expect([refused.pass(), refused.hand.ended]).toEqual([[], 'it is not flown by hand any more']);
  });

  it('goes on through what may pass, and through what is about another vehicle', () => {
    const { hand, pass, refuse } = steering();
    refuse({ reason: 'timed_out', what: 'a stick', after_s: 1 });
    refuse({ reason: 'pilot_in_control' }, ID + 1);
    expect([pass(2).length, hand.trouble]).toEqual([2, 'no answer to a stick within 1.0 s']);
    pass(40);
    expect([hand.trouble, hand.is]).toEqual(['', 'steering']);
  });

  it('that is ended by hand holds the vehicle, but not a leader', () => {
    const one = steering();
    one.hand.end();
    expect([one.commands, one.hand.is, one.pass()]).toEqual([['steer', 'hold'], 'off', []]);
    const leader = steering();
    leader.row.leader = true;
    leader.hand.end();
    expect([leader.commands, leader.pass()]).toEqual([['steer'], []]);
  });

  it('goes on without gamepads where the browser gives none', () => {
    const { hand, pass } = made();
    vi.stubGlobal('navigator', {});
    pass();
    expect([hand.allowed, hand.pad]).toEqual([false, '']);
  });

  it('ends with its panel', () => {
    const { hand, close, pass } = steering();
    close();
    expect([pass(), hand.vehicle]).toEqual([[], null]);
  });

  it('is flown by fingers and keys while the dead-man on the screen is held', () => {
    const { hand, node, pass } = made();
    hand.begin(ID);
    node.phase = 'executing';
    pass(1);
    hand.fingers = { forward: 0.5, right: 0, up: 0, turn: 0 };
    expect(pass()).toEqual([]);
    hand.screenHeld = true;
    hand.keys = { forward: 0, right: 0, up: -1, turn: 0 };
    expect(pass(1)).toEqual([{ forward_m_s: 0.5 * LIMITS.medium.levelMS, right_m_s: 0, up_m_s: -LIMITS.medium.climbMS, yaw_rate_rad_s: 0 }]);
    hand.screenHeld = false;
    pass(1);
    expect(pass()).toEqual([]);
  });
});
