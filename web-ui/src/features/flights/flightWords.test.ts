import { describe, expect, it } from 'vitest';
import { isFlown, stateText } from './flightWords';

const NONE = { file: null, in_flight: false };

describe('a recording', () => {
  it('is of a flight or of vehicles that stood', () => {
    expect([isFlown({ file: '2026-01-02T03-04-05Z_demo.mcap' }, NONE), isFlown({ file: '2026-01-02T03-04-05Z_demo_ground.mcap' }, NONE)]).toEqual([true, false]);
  });

  it('that is being written is of a flight once somebody was armed', () => {
    expect([false, true].map((in_flight) => isFlown({ file: 'a.mcap' }, { file: 'a.mcap', in_flight }))).toEqual([false, true]);
  });

  it('is whole, is being written, or was cut off', () => {
    const writing = { file: 'b.mcap', in_flight: true };
    expect(stateText({ file: 'a.mcap', finished: true }, writing)).toBe('');
    expect(stateText({ file: 'b.mcap', finished: false }, writing)).toBe('is being written');
    expect(stateText({ file: 'a.mcap', finished: false }, writing)).toBe('cut off');
    expect(stateText({ file: 'a.mcap', finished: false }, NONE)).toBe('cut off');
  });
});
