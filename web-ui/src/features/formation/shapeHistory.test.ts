import { describe, expect, it } from 'vitest';
import { ShapeHistory } from './shapeHistory';
import { numbers } from './someShapes';

describe('ShapeHistory', () => {
  it('takes back change by change, a run of changes at once', () => {
    const history = new ShapeHistory('a');
    history.change('a', 'b');
    history.change('b', 'c', 'drag 1');
    history.change('c', 'd', 'drag 1');
    history.change('d', 'e', 'drag 2');
    expect([history.undo('e'), history.undo('d'), history.undo('b'), history.undo('a')]).toEqual(['d', 'b', 'a', null]);
    expect(history.canUndo('a')).toBe(false);
  });

  it('does not go on with a run after one of its changes was taken back', () => {
    const history = new ShapeHistory('a');
    history.change('a', 'b', 'field');
    expect(history.undo('b')).toBe('a');
    history.change('a', 'c', 'field');
    expect(history.undo('c')).toBe('a');
  });

  it('takes what was typed as one step', () => {
    const history = new ShapeHistory('');
    expect([history.canUndo(''), history.canUndo('typed')]).toEqual([false, true]);
    history.change('typed', 'drawn');
    expect([history.undo('drawn'), history.undo('typed'), history.undo('')]).toEqual(['typed', '', null]);
  });

  it('keeps a hundred steps, and of long texts fewer', () => {
    const history = new ShapeHistory('0');
    for (let k = 0; k < 150; k++) history.change(`${k}`, `${k + 1}`);
    let steps = 0;
    let text: string | null = '150';
    for (let before = history.undo(text); before !== null; before = history.undo(before)) [text, steps] = [before, steps + 1];
    expect([text, steps]).toEqual(['50', 100]);
    const long = new ShapeHistory('x'.repeat(3_000_000));
    long.change('x'.repeat(3_000_000), 'y'.repeat(3_000_000));
    long.change('y'.repeat(3_000_000), 'z');
    expect([long.undo('z')?.[0], long.undo('y'.repeat(3_000_000))]).toEqual(['y', null]);
  });

  it('leads back through every text that there was, in any order of drawing and typing', () => {
    const next = numbers(3);
    for (let round = 0; round < 100; round++) {
      const history = new ShapeHistory('0');
      const texts = ['0'];
      let text = '0';
      for (let k = 1; k < 30; k++) {
        // What is typed twice in a row is one step.
        const typed: boolean = next() < 0.3 && texts.at(-1) === text;
        const before = text;
        text = `${k}`;
        if (typed) {
          texts.push(text);
          history.change(text, (text = `${k} drawn`));
        } else history.change(before, text);
        texts.push(text);
      }
      for (let at = texts.length - 2; at >= 0; at--) expect(history.undo(texts[at + 1]!)).toBe(texts[at]);
    }
  });
});
