import { describe, expect, it } from 'vitest';
import type { Severity } from '../protocol/types';
import { AGAIN_MS, SoundPlan } from './alarmSound.svelte';
import type { LogEntry } from './eventLog';

const entry = (key: string, severity: Severity, count = 1): LogEntry => ({
  key, signature: key, vehicles: [1], severity, kind: 'failsafe', text: key, cause: null, numbers: [], count, firstAt: 0, lastAt: 0, endsAt: null, acknowledged: false, former: false,
});

describe('what is heard', () => {
  it('is what is new, once, and the worst of it', () => {
    const plan = new SoundPlan();
    expect(plan.next([], 0)).toBeNull();
    expect(plan.next([entry('a', 'warning')], 100)).toBe('warning');
    expect(plan.next([entry('a', 'warning')], 200)).toBeNull();
    expect(plan.next([entry('a', 'warning', 2)], 300)).toBe('warning');
    expect(plan.next([entry('b', 'critical'), entry('c', 'warning'), entry('a', 'warning', 2)], 400)).toBe('critical');
  });

  it('comes again while a critical alert is not acknowledged, and ends with it', () => {
    const plan = new SoundPlan();
    const critical = [entry('b', 'critical')];
    expect(plan.next(critical, 0)).toBe('critical');
    expect(plan.next(critical, AGAIN_MS - 1)).toBeNull();
    expect(plan.next(critical, AGAIN_MS)).toBe('critical');
    expect(plan.next([], AGAIN_MS + 1)).toBeNull();
    expect(plan.next([entry('b', 'warning')], 3 * AGAIN_MS)).toBe('warning');
    expect(plan.next([entry('b', 'warning')], 9 * AGAIN_MS)).toBeNull();
  });

  it('does not tell what was there before it was turned on', () => {
    const plan = new SoundPlan();
    plan.settle([entry('a', 'critical')], 0);
    expect(plan.next([entry('a', 'critical')], 1)).toBeNull();
    expect(plan.next([entry('a', 'critical'), entry('b', 'warning')], 10)).toBe('warning');
    // Still critical and still not acknowledged: that is not kept quiet.
    expect(plan.next([entry('a', 'critical'), entry('b', 'warning')], AGAIN_MS)).toBe('critical');
  });
});
