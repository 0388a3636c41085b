// The two steps, with a server that is stood in for at the network: what goes out, and when nothing does.

import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { EmergencyStop, SETTLE_MS } from './emergencyStop.svelte';
import type { Journal } from './journal.svelte';

const sent: { path: string; body: unknown }[] = [];
let answer: (path: string) => Response;

function made() {
  const notices: string[] = [];
  const locked: number[] = [];
  const journal = {
    notice: (_: string, __: string, text: string) => notices.push(text),
    emergencyLocked: (at: number) => locked.push(at),
  } as unknown as Journal;
  return { stop: new EmergencyStop(journal), notices, locked };
}

beforeEach(() => {
  sent.length = 0;
  answer = (path) =>
    Response.json(path.endsWith('unlock') ? { key: 'k1', valid_s: 10 } : { receipts: [{ vehicle: 1, id: 1, refusal: null }] });
  vi.stubGlobal('document', { baseURI: 'http://node/' });
  vi.stubGlobal('fetch', (url: URL, init: RequestInit) => {
    sent.push({ path: url.pathname, body: init.body ? JSON.parse(init.body as string) : null });
    return Promise.resolve(answer(url.pathname));
  });
  vi.useFakeTimers({ toFake: ['setTimeout', 'clearTimeout', 'setInterval', 'clearInterval', 'performance'] });
});

afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

describe('EmergencyStop', () => {
  it('sends nothing without the first step, nor right after it', async () => {
    const { stop } = made();
    await stop.stop('all', [1]);
    expect(sent).toEqual([]);
    await stop.unlock();
    await stop.stop('all', [1]);
    expect(sent.map((s) => s.path)).toEqual(['/api/v1/emergency-stop/unlock']);
    expect(stop.leftS).toBe(10);
  });

  it('stops with the key of the first step, once', async () => {
    const { stop } = made();
    await stop.unlock();
    vi.advanceTimersByTime(SETTLE_MS + 100);
    await stop.stop({ vehicles: [1] }, [1]);
    await stop.stop({ vehicles: [1] }, [1]);
    expect(sent.slice(1)).toEqual([{ path: '/api/v1/emergency-stop', body: { key: 'k1', targets: { vehicles: [1] } } }]);
    expect([stop.unlocked, stop.outcome]).toEqual([false, { bad: false, text: 'Emergency stop sent to 1' }]);
  });

  it('counts down and locks when its time is over', async () => {
    const { stop } = made();
    await stop.unlock();
    vi.advanceTimersByTime(7200);
    expect(stop.leftS).toBe(3);
    vi.advanceTimersByTime(3000);
    expect([stop.leftS, stop.ready]).toEqual([null, false]);
    await stop.stop('all', [1]);
    expect(sent).toHaveLength(1);
  });

  it('says once that it is locked again: put back, used or run out', async () => {
    const { stop, locked } = made();
    const before = Date.now();
    stop.lock();
    expect(locked).toEqual([]);
    await stop.unlock();
    stop.lock();
    stop.lock();
    await stop.unlock();
    vi.advanceTimersByTime(SETTLE_MS + 100);
    await stop.stop('all', [1]);
    await stop.unlock();
    vi.advanceTimersByTime(10_100);
    expect(locked).toHaveLength(3);
    for (const at of locked) expect(at).toBeGreaterThanOrEqual(before);
  });

  it('a server that began anew takes its key and what was said of it away', async () => {
    const { stop } = made();
    await stop.unlock();
    vi.advanceTimersByTime(SETTLE_MS + 100);
    await stop.stop('all', [1]);
    expect(stop.outcome).not.toBeNull();
    await stop.unlock();
    stop.restart();
    expect([stop.unlocked, stop.outcome]).toEqual([false, null]);
    vi.advanceTimersByTime(SETTLE_MS + 100);
    await stop.stop('all', [1]);
    expect(sent).toHaveLength(3);
  });

  it('an unlocking that is refused leaves it locked and is said', async () => {
    const { stop, notices } = made();
    answer = () => Response.json({ error: { code: 'x', message: 'no', detail: null } }, { status: 503 });
    await stop.unlock();
    expect([stop.unlocked, stop.busy]).toEqual([false, false]);
    expect(notices).toEqual(['Emergency stop not unlocked: no']);
  });
});
