import { describe, expect, it } from 'vitest';
import { parseOffsets } from '../../model/offsets';
import { MOST_BYTES, MOST_PLACES, offsetsText, readShape } from './shapeFile';
import { someShapes } from './someShapes';

const file = (text: string, name = 'shape.csv') => ({ name, size: new TextEncoder().encode(text).length, text: () => Promise.resolve(text) });

describe('a written shape', () => {
  it('has a heading', () => {
    expect(offsetsText([{ forward_m: 0, right_m: 0, down_m: 0 }, { forward_m: -5, right_m: 2.5, down_m: -1 }])).toBe('forward_m,right_m,down_m\n0,0,0\n-5,2.5,-1\n');
  });

  it('is read back to the last digit, whatever the figures', () => {
    for (const offsets of [...someShapes(), [{ forward_m: 1e21, right_m: 5e-324, down_m: 0.1 + 0.2 }]]) {
      expect(parseOffsets(offsetsText(offsets))).toEqual({ offsets });
    }
  });

  it('is read back the same when it is written again', () => {
    for (const offsets of someShapes()) {
      const read = parseOffsets(offsetsText(offsets));
      expect('offsets' in read && offsetsText(read.offsets)).toBe(offsetsText(offsets));
    }
  });
});

describe('a file', () => {
  it('is taken as it is, table or list', async () => {
    expect(await readShape(file('\ufeffforward_m,right_m,up_m\r\n0,0,0\r\n-5,2,1\r\n'))).toMatchObject({ count: 2 });
    expect(await readShape(file('[[0,0,0],[-5,2,-1]]', 'shape.json'))).toEqual({ text: '[[0,0,0],[-5,2,-1]]', count: 2 });
  });

  it('with a fault names the line', async () => {
    expect(await readShape(file('forward_m,right_m,down_m\n0,0,0\n-5,two,0\n'))).toEqual({ fault: 'line 3: "two" is no number' });
    expect(await readShape(file('[[0,0,0],\n[1,2,,3]]'))).toEqual({ fault: 'line 2: this is no JSON list' });
    expect(await readShape(file(''))).toEqual({ fault: 'no offsets yet' });
  });

  it('that is too large is not even opened', async () => {
    const opened = { name: 'x', size: MOST_BYTES + 1, text: () => Promise.reject(new Error('opened')) };
    expect(await readShape(opened)).toEqual({ fault: 'it is larger than 1 MB' });
    expect(await readShape(file('0,0,0\n'.repeat(MOST_PLACES + 1)))).toEqual({ fault: 'it has more than 10000 places' });
  });

  it('that the browser cannot open is said', async () => {
    expect(await readShape({ name: 'x', size: 3, text: () => Promise.reject(new Error('gone')) })).toEqual({ fault: 'the browser cannot open it' });
  });
});
