// What one console does about authority and what it tells of it, with a node that is stood in for at the network and at the stream.

import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { callAs } from '../protocol/rest';
import type { VehicleControl } from '../protocol/types';
import { Control } from './control.svelte';
import { Journal } from './journal.svelte';
import { Operator } from './operator.svelte';

const ME = 'a'.repeat(32);
const BEN = { id: 'b'.repeat(32), name: 'Ben' };
const mine = (vehicle: number, over: Partial<VehicleControl> = {}): VehicleControl => ({
  vehicle, console: { id: ME, name: 'Anna' }, since: 0, is_heard: true, requests: [], ...over,
});
const bens = (vehicle: number, over: Partial<VehicleControl> = {}): VehicleControl => mine(vehicle, { console: BEN, ...over });
const asks = (since = 7): Partial<VehicleControl> => ({ requests: [{ console: BEN, since }] });

const sent: { path: string; console: string | null; body: unknown }[] = [];
let answer: () => Response;

function made() {
  const listeners: (() => void)[] = [];
  const restarts: (() => void)[] = [];
  const source = {
    control: new Map<number, VehicleControl>() as ReadonlyMap<number, VehicleControl>,
    onControl: (listener: () => void) => void listeners.push(listener),
    onRestart: (listener: (sameVehicles: boolean) => void) => void restarts.push(() => listener(false)),
  };
  const journal = new Journal();
  const operator = new Operator(ME);
  operator.rename('Anna');
  const control = new Control(source, journal, operator);
  return {
    control,
    journal,
    operator,
    say: (...vehicles: VehicleControl[]) => {
      source.control = new Map(vehicles.map((one) => [one.vehicle, one]));
      for (const listener of listeners) listener();
    },
    restart: () => restarts.forEach((listener) => listener()),
    texts: () => journal.log.entries.map((entry) => entry.text),
    open: () => journal.outstanding.map((entry) => entry.text),
  };
}

beforeEach(() => {
  sent.length = 0;
  answer = () => Response.json({ receipts: [{ vehicle: 1, refusal: null }] });
  const kept = new Map<string, string>();
  vi.stubGlobal('localStorage', { getItem: (key: string) => kept.get(key) ?? null, setItem: (key: string, value: string) => kept.set(key, value) });
  vi.stubGlobal('document', { baseURI: 'http://node/' });
  vi.stubGlobal('fetch', (url: URL, init: RequestInit) => {
    sent.push({ path: url.pathname, console: new Headers(init.headers).get('skein-console'), body: JSON.parse(init.body as string) });
    return Promise.resolve(answer());
  });
  callAs(ME);
});
afterEach(() => vi.unstubAllGlobals());

describe('what this console does', () => {
  it('says who it is and what it wants, and tells what came of it', async () => {
    const { control, texts } = made();
    answer = () => Response.json({ receipts: [{ vehicle: 1, refusal: null }, { vehicle: 2, refusal: { reason: 'no_control_authority', vehicle: 2, holder: 'Ben' } }] });
    await control.take([1, 2]);
    expect(sent).toEqual([{ path: '/api/v1/control', console: ME, body: { targets: { vehicles: [1, 2] }, console: { id: ME, name: 'Anna' }, action: { action: 'take' } } }]);
    expect(texts()).toEqual(['Control not taken: 2: vehicle 2 is under the control of Ben', 'Control taken: 1']);
    expect(control.outcome?.text).toBe('Control not taken: 2: vehicle 2 is under the control of Ben');
    answer = () => Response.json({ receipts: [{ vehicle: 1, refusal: null }] });
    await control.release([1]);
    expect([control.outcome, texts()[0]]).toEqual([null, 'Let go: 1']);
  });

  it('tells that no answer came, as something to be seen', async () => {
    const { control, open } = made();
    answer = () => Response.json({ error: { code: 'x', message: 'no', detail: null } }, { status: 503 });
    await control.request([1, 2, 3]);
    expect(open()).toEqual(['Not asked for: 1–3: no']);
  });

  it('does one thing at a time, and nothing for nobody', async () => {
    const { control } = made();
    await Promise.all([control.take([1]), control.take([1]), control.release([])]);
    expect(sent).toHaveLength(1);
  });

  it('gives its new name to whom has control authority over it already', async () => {
    const { control, say } = made();
    await control.rename('Annabel');
    expect(sent).toEqual([]);
    say(mine(1), bens(2), mine(3));
    await control.rename('Anna');
    await control.rename(' Anna ');
    expect(sent.map(({ body }) => body)).toEqual([{ targets: { vehicles: [1, 3] }, console: { id: ME, name: 'Anna' }, action: { action: 'take' } }]);
  });
});

describe('what is known of authority', () => {
  it('is nothing while nobody has anything', () => {
    const { control, say, texts } = made();
    expect([control.inUse, control.of(1).whose, control.heldBy(1)]).toEqual([false, 'nobody', '']);
    say(mine(1), bens(2), bens(3, { is_heard: false }));
    expect([control.inUse, control.mine]).toEqual([true, [1]]);
    expect([1, 2, 3, 4].map((id) => control.heldBy(id))).toEqual(['', 'Ben', '', '']);
    say();
    expect(control.inUse).toBe(false);
    expect(texts()).toEqual([]);
  });

  it('tells what was got after asking', async () => {
    const { control, say, texts } = made();
    say(bens(1), bens(2));
    await control.request([1]);
    say(mine(1), bens(2));
    say(mine(1), mine(2));
    expect(texts()).toEqual(['Under your control now: 1', 'Asked for: 1']);
  });

  it('wants to be seen when another one has what was ours, unless it was given', async () => {
    const { control, say, open } = made();
    say(mine(1), mine(2), mine(3));
    say(bens(1), mine(2), mine(3));
    expect(open()).toEqual(['Ben has taken over: 1']);
    answer = () => Response.json({ receipts: [{ vehicle: 2, refusal: null }] });
    const handed = control.handOver({ console: BEN, name: 'Ben', vehicles: [2], keys: [] });
    // A second click while it goes out is none.
    void control.handOver({ console: BEN, name: 'Ben', vehicles: [2], keys: [] });
    say(bens(1), bens(2), mine(3));
    await handed;
    answer = () => Response.json({ receipts: [{ vehicle: 3, refusal: null }] });
    await control.release([3]);
    say(bens(1), bens(2), bens(3));
    expect(open()).toEqual(['Ben has taken over: 1']);
    expect(sent.map(({ body }) => (body as { action: unknown }).action)).toEqual([{ action: 'hand_over', to: BEN.id }, { action: 'release' }]);
  });

  it('forgets what it had when the server is another run', () => {
    const { say, restart, open } = made();
    say(mine(1, asks()));
    restart();
    say(bens(1));
    expect(open()).toEqual([]);
  });
});

describe('requests to this console', () => {
  it('are an alert as long as they stand', () => {
    const { control, say, open } = made();
    say(mine(1, asks()), mine(2, asks()));
    expect(open()).toEqual(['Ben asks for 1, 2']);
    expect(control.asking).toMatchObject([{ console: BEN, vehicles: [1, 2] }]);
    // One less is no news, one more is.
    say(mine(1, asks()), mine(2));
    expect(open()).toEqual(['Ben asks for 1, 2']);
    say(mine(1, asks()), mine(2, asks(9)));
    expect(open()).toEqual(['Ben asks for 1, 2']);
    say(mine(1), mine(2));
    expect([open(), control.asking]).toEqual([[], []]);
  });

  it('are over once they are granted, before the stream says so, and not where they were not', async () => {
    const { control, say, open } = made();
    say(mine(1, asks()), mine(2, asks()));
    answer = () => Response.json({ receipts: [{ vehicle: 1, refusal: null }, { vehicle: 2, refusal: { reason: 'not_permitted', detail: 'no' } }] });
    await control.handOver(control.asking[0]!);
    expect(control.asking).toMatchObject([{ vehicles: [2] }]);
    expect([open(), control.outcome?.text]).toEqual([['Ben asks for 1, 2'], 'Not handed over: 2: not permitted: no']);
  });

  it('"not now" puts them away, and asking again brings them back', () => {
    const { control, say, open } = made();
    say(mine(1, asks()));
    control.notNow(control.asking[0]!);
    expect([open(), control.asking, sent]).toEqual([[], [], []]);
    say(mine(1, asks()), mine(2));
    expect(open()).toEqual([]);
    say(mine(1, asks(99)));
    expect(open()).toEqual(['Ben asks for 1']);
  });
});
