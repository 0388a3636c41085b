import { describe, expect, it } from 'vitest';
import { byName, isFlown, logText, stateText } from './flightWords';

const NONE = { file: null, in_flight: false };

describe('a recording', () => {
  it('is of a flight or of vehicles that stood', () => {
    expect([isFlown({ file: '2026-01-02T03-04-05Z_demo.mcap' }, NONE), isFlown({ file: '2026-01-02T03-04-05Z_demo_ground.mcap' }, NONE)]).toEqual([true, false]);
  });

  it('that is being written is of a flight once somebody was armed', () => {
    expect([false, true].map((in_flight) => isFlown({ file: 'a.mcap' }, { file: 'a.mcap', in_flight }))).toEqual([false, true]);
  });

  it('has logs of autopilots beside it, named in short', () => {
    const flight = { file: '2026-01-02T03-04-05Z_demo.mcap' };
    expect(logText('2026-01-02T03-04-05Z_demo_uav-1_0.ulg', flight)).toBe('uav-1, log 0');
    expect(logText('2026-01-02T03-04-05Z_demo_my_uav_12.ulg', { file: '2026-01-02T03-04-05Z_demo_ground.mcap' })).toBe('my_uav, log 12');
    for (const other of ['2026-01-02T03-04-06Z_demo_uav-1_0.ulg', '2026-01-02T03-04-05Z_demo_uav.ulg']) expect(logText(other, flight)).toBe(other);
  });

  it('has them in the order in which vehicles and logs are counted', () => {
    expect(byName(['a_uav-10_0.ulg', 'a_uav-2_11.ulg', 'a_uav-2_2.ulg'])).toEqual(['a_uav-2_2.ulg', 'a_uav-2_11.ulg', 'a_uav-10_0.ulg']);
  });

  it('is whole, is being written, or was cut off', () => {
    const writing = { file: 'b.mcap', in_flight: true };
    expect(stateText({ file: 'a.mcap', finished: true }, writing)).toBe('');
    expect(stateText({ file: 'b.mcap', finished: false }, writing)).toBe('is being written');
    expect(stateText({ file: 'a.mcap', finished: false }, writing)).toBe('cut off');
    expect(stateText({ file: 'a.mcap', finished: false }, NONE)).toBe('cut off');
  });
});
