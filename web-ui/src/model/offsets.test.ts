import { describe, expect, it } from 'vitest';
import { parseOffsets } from './offsets';

const TWO = { offsets: [{ forward_m: 0, right_m: 0, down_m: 0 }, { forward_m: -5, right_m: 2.5, down_m: -1 }] };

describe('parseOffsets', () => {
  it.each([
    ['a bare table', '0,0,0\n-5, 2.5, -1'],
    ['headings in any order, up instead of down', '# two\nup_m,right_m,forward_m\n0,0,0\n\n1,2.5,-5\n'],
    ['quoted headings and tabs', '"forward_m"\t"right_m"\t"down_m"\n0\t0\t0\n-5\t2.5\t-1'],
    ['a list of lists', '[[0,0,0],[-5,2.5,-1]]'],
    ['a list of objects', '[{"forward_m":0,"right_m":0,"down_m":0},{"forward_m":-5,"right_m":2.5,"up_m":1}]'],
  ])('%s', (_, text) => expect(parseOffsets(text)).toEqual(TWO));

  it.each([
    ['', 'no offsets yet'],
    ['forward_m,right_m,down_m', 'no offsets yet'],
    ['0,0', 'line 1: 2 fields instead of three'],
    ['0,0,0\n1,x,0', 'line 2: "x" is no number'],
    ['0,0,0\n1,,0', 'line 2: "" is no number'],
    ['north,east,down', 'line 1: the headings must be forward_m, right_m and one of down_m and up_m'],
    ['[1,2', 'line 1: this is no JSON list'],
    ['[\n[0,0,0],\n[1,x,0]\n]', 'line 3: this is no JSON list'],
    ['[[0,0,0],\n', 'line 1: this is no JSON list'],
    ['\n[[0,0,0]\n[1,2,3]]', 'line 3: this is no JSON list'],
    [`0,0,${'x'.repeat(100)}`, `line 1: "${'x'.repeat(40)}" is no number`],
    ['[[0,0,0],[1,2]]', 'entry 2: three numbers, or forward_m, right_m and down_m or up_m'],
    ['[{"forward_m":0,"right_m":0,"down_m":0,"up_m":0}]', 'entry 1: three numbers, or forward_m, right_m and down_m or up_m'],
    ['[[0,0,null]]', 'entry 1: three numbers, or forward_m, right_m and down_m or up_m'],
  ])('%j is refused with the place', (text, fault) => expect(parseOffsets(text)).toEqual({ fault }));
});
