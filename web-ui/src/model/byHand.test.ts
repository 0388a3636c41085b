// Sticks, dead zones and the dead-man: what is said, and above all when nothing is.

import { describe, expect, it } from 'vitest';
import { CENTRED, DEAD_ZONE, Grip, LIMITS, SPEEDS, axesOfKeys, firstPad, isStickKey, isWell, merged, padName, readPad, shaped, shown, stickOf } from './byHand';
import type { Moment, PadState } from './byHand';

const pad = (over: Partial<PadState> = {}): PadState => ({
  id: 'Xbox 360 Controller (XInput STANDARD GAMEPAD)', connected: true, mapping: 'standard', axes: [0, 0, 0, 0],
  buttons: Array.from({ length: 17 }, () => ({ pressed: false })), ...over,
});
const pressed = (...which: number[]): { pressed: boolean }[] => Array.from({ length: 17 }, (_, at) => ({ pressed: which.includes(at) }));

describe('a stick', () => {
  it('that rests near the middle is in it', () => {
    expect(shaped(DEAD_ZONE * 0.7, DEAD_ZONE * 0.7)).toEqual({ x: 0, y: 0 });
    expect(shaped(NaN, 0.5)).toEqual({ x: 0, y: 0 });
  });

  it('begins at the edge of the dead zone without a step and is whole at the rim', () => {
    expect(shaped(DEAD_ZONE + 0.001, 0).x).toBeLessThan(0.01);
    expect(shaped(-1, 0)).toEqual({ x: -1, y: 0 });
    // The corner of a square one is no faster than its rim.
    const corner = shaped(1, 1);
    expect(Math.hypot(corner.x, corner.y)).toBeCloseTo(1);
    expect(corner.x).toBeCloseTo(corner.y);
  });

  it('is as fast as was chosen, and no faster', () => {
    for (const speed of SPEEDS) {
      const most = stickOf({ forward: 1, right: -1, up: 1, turn: -1 }, speed);
      const { levelMS, climbMS, turnRadS } = LIMITS[speed];
      expect(most).toEqual({ forward_m_s: levelMS, right_m_s: -levelMS, up_m_s: climbMS, yaw_rate_rad_s: -turnRadS });
    }
    expect(stickOf(CENTRED, 'fast')).toEqual({ forward_m_s: 0, right_m_s: 0, up_m_s: 0, yaw_rate_rad_s: 0 });
  });
});

describe('a gamepad', () => {
  it('climbs and turns with the left stick and moves with the right one', () => {
    expect(readPad(pad({ axes: [1, 0, 0, 0] }))?.axes).toEqual({ ...CENTRED, turn: 1 });
    expect(readPad(pad({ axes: [0, -1, 0, 0] }))?.axes).toEqual({ ...CENTRED, up: 1 });
    expect(readPad(pad({ axes: [0, 0, -1, 0] }))?.axes).toEqual({ ...CENTRED, right: -1 });
    expect(readPad(pad({ axes: [0, 0, 0, -1] }))?.axes).toEqual({ ...CENTRED, forward: 1 });
    expect(readPad(pad())?.axes).toEqual(CENTRED);
  });

  it('has its dead-man over the right trigger and nowhere else', () => {
    expect(readPad(pad({ buttons: pressed(5) }))?.held).toBe(true);
    expect(readPad(pad({ buttons: pressed(0, 1, 2, 3, 4, 6, 7, 8, 9) }))?.held).toBe(false);
    expect(readPad(pad({ buttons: [] }))?.held).toBe(false);
  });

  it('of an unknown layout, or that is gone, is not read', () => {
    expect(readPad(pad({ mapping: '' }))).toBeNull();
    expect(readPad(pad({ connected: false }))).toBeNull();
    expect(firstPad([null, pad({ mapping: '', id: 'Odd Stick' }), pad()])).toMatchObject({ reading: { name: 'Xbox 360 Controller' }, unread: '' });
    expect(firstPad([null, pad({ mapping: '', id: 'Odd Stick' })])).toEqual({ reading: null, unread: 'Odd Stick' });
    expect(firstPad([null, pad({ connected: false })])).toEqual({ reading: null, unread: '' });
  });

  it('is called what is printed on it', () => {
    expect(padName('Xbox 360 Controller (XInput STANDARD GAMEPAD)')).toBe('Xbox 360 Controller');
    expect(padName('Wireless Controller (STANDARD GAMEPAD Vendor: 054c Product: 09cc)')).toBe('Wireless Controller');
    expect(padName('054c-09cc-Wireless Controller')).toBe('Wireless Controller');
    expect(padName('(STANDARD GAMEPAD)')).toBe('(STANDARD GAMEPAD)');
  });
});

describe('the dead-man', () => {
  it('counts while it is held and all is well', () => {
    const grip = new Grip();
    expect([grip.take(false, true), grip.take(true, true), grip.take(true, true), grip.take(false, true)]).toEqual([false, true, true, false]);
  });

  it('that was held when something came between has to be taken anew', () => {
    const grip = new Grip();
    grip.take(true, true);
    expect(grip.take(true, false)).toBe(false);
    expect([grip.take(true, true), grip.spent]).toEqual([false, true]);
    expect(grip.take(false, true)).toBe(false);
    expect([grip.take(true, true), grip.spent]).toEqual([true, false]);
  });

  it('that is held before all is well does not count when it becomes so', () => {
    const grip = new Grip();
    expect([grip.take(true, false), grip.take(true, true)]).toEqual([false, false]);
  });

  it('does not outlast what came between two looks', () => {
    const grip = new Grip();
    grip.break();
    expect(grip.take(true, true)).toBe(true);
    grip.break();
    expect(grip.take(true, true)).toBe(false);
  });

  it('that was let go meanwhile may be taken at once', () => {
    const grip = new Grip();
    grip.take(true, true);
    grip.take(true, false);
    grip.take(false, false);
    expect(grip.take(true, true)).toBe(true);
  });
});

describe('what is shown', () => {
  const steering: Moment = { order: 'flown', attended: true, heard: true, gripped: true, spent: false };

  it('is steering only when everything is as it has to be', () => {
    expect(shown(steering)).toBe('steering');
    expect(shown({ ...steering, gripped: false })).toBe('let go');
    expect(shown({ ...steering, gripped: false, spent: true })).toBe('spent');
    expect(shown({ ...steering, attended: false })).toBe('away');
    expect(shown({ ...steering, heard: false })).toBe('lost');
    expect(shown({ ...steering, order: 'asked' })).toBe('asked');
    expect(shown({ ...steering, order: 'none' })).toBe('off');
    expect(shown({ ...steering, order: 'over' })).toBe('off');
  });

  it('never is steering where a grip could not be taken', () => {
    for (const order of ['none', 'asked', 'flown', 'over'] as const) {
      for (const attended of [true, false]) {
        for (const heard of [true, false]) {
          const moment = { order, attended, heard, gripped: true, spent: false };
          expect(shown(moment) === 'steering', JSON.stringify(moment)).toBe(isWell(moment));
        }
      }
    }
  });
});

describe('keys and fingers', () => {
  it('move the sticks, and against each other they do not', () => {
    expect(axesOfKeys(['KeyW', 'ArrowRight'])).toEqual({ forward: 0, right: 1, up: 1, turn: 0 });
    expect(axesOfKeys(['KeyA', 'KeyD', 'ArrowUp', 'KeyX'])).toEqual({ ...CENTRED, forward: 1 });
    expect([isStickKey('KeyS'), isStickKey('Space'), isStickKey('toString')]).toEqual([true, false, false]);
  });

  it('are taken together, axis by axis', () => {
    expect(merged({ ...CENTRED, forward: 0.4, turn: -0.2 }, { ...CENTRED, forward: -0.6, up: 0.1 })).toEqual({ forward: -0.6, right: 0, up: 0.1, turn: -0.2 });
  });
});
