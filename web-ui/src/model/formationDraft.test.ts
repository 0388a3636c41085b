// When a preview is asked for: the server stands in at the network, and time is the test's.

import { afterEach, beforeEach, expect, it, vi } from 'vitest';
import { FormationDraft } from './formationDraft.svelte';
import type { Journal } from './journal.svelte';
import type { Session } from './session.svelte';
import type { Targets } from './targets.svelte';

const asked: unknown[] = [];

beforeEach(() => {
  asked.length = 0;
  vi.stubGlobal('document', { baseURI: 'http://node/' });
  vi.stubGlobal('fetch', (_: URL, init: RequestInit) => {
    asked.push(JSON.parse(init.body as string));
    return Promise.resolve(Response.json({ slots: [] }));
  });
  vi.useFakeTimers({ toFake: ['setTimeout', 'clearTimeout'] });
});

afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

it('asks for a preview when a drag pauses, not at each of its steps', () => {
  const draft = new FormationDraft({} as Session, {} as Targets, {} as Journal, () => []);
  let callOff = () => {};
  for (let step = 0; step < 40; step++) {
    callOff();
    callOff = draft.askPreview(`{"step":${step}}`);
    vi.advanceTimersByTime(20);
  }
  expect(asked).toEqual([]);
  vi.advanceTimersByTime(1000);
  expect(asked).toEqual([{ step: 39 }]);
});
