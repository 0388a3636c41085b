import { describe, expect, it } from 'vitest';
import { Throttle, anglesCommand, centred, dragged, fromPad, moved, toPad, zoomCommand } from './aim';

const RAD = Math.PI / 180;
const picture = { widthPx: 400, heightPx: 300, fieldOfViewRad: 90 * RAD };
const ahead = { pitchRad: 0, yawRad: 0 };

describe('the pad', () => {
  it('is read back as it is drawn, and ends where the gimbal does', () => {
    const aim = { pitchRad: -45 * RAD, yawRad: 30 * RAD };
    const { x, y } = toPad(aim);
    expect(fromPad(x, y).pitchRad).toBeCloseTo(aim.pitchRad);
    expect(fromPad(x, y).yawRad).toBeCloseTo(aim.yawRad);
    expect(fromPad(0.5, 1).pitchRad).toBeCloseTo(-90 * RAD);
    expect(fromPad(2, -1)).toEqual(fromPad(1, 0));
    expect(moved(ahead, -9, 0).pitchRad).toBeCloseTo(-90 * RAD);
  });
});

describe('the picture', () => {
  it('brings to the middle what was clicked', () => {
    // With a field of view of 90 degrees the edge is 45 degrees off.
    expect(centred(ahead, { x: 200, y: 0 }, picture).yawRad).toBeCloseTo(45 * RAD);
    expect(centred(ahead, { x: 0, y: 200 }, picture).pitchRad).toBeCloseTo(-45 * RAD);
  });

  it('follows the finger: drawn to the left the gimbal looks to the right', () => {
    const aim = dragged(ahead, { x: 0, y: 0 }, { x: -200, y: 0 }, picture);
    expect(aim.yawRad).toBeCloseTo(45 * RAD);
    expect(dragged(ahead, { x: 10, y: -5 }, { x: 10, y: -5 }, picture)).toEqual({ pitchRad: 0, yawRad: 0 });
    expect(dragged(ahead, { x: 0, y: 0 }, { x: 0, y: -100 }, picture).pitchRad).toBeLessThan(0);
  });
});

describe('what goes out', () => {
  it('is not more than the device takes, and the last always', () => {
    const throttle = new Throttle(200);
    const sent = [0, 50, 100, 199, 200, 350].filter((now) => throttle.passes(now, false));
    expect(sent).toEqual([0, 200]);
    expect(throttle.passes(360, true)).toBe(true);
  });
});

describe('what is sent', () => {
  it('is an aim in the vehicle\'s frame, and a zoom that is never below one', () => {
    expect(anglesCommand({ pitchRad: -0.5, yawRad: 0.25 })).toEqual({ command: 'angles', pitch_rad: -0.5, yaw_rad: 0.25, yaw_frame: 'vehicle' });
    expect([zoomCommand(2, 'in'), zoomCommand(3, 'out'), zoomCommand(1.2, 'out')]).toEqual([{ command: 'zoom', factor: 3 }, { command: 'zoom', factor: 2 }, { command: 'zoom', factor: 1 }]);
  });
});
