import { describe, expect, it } from 'vitest';
import { FormationDraft } from '../../model/formationDraft.svelte';
import type { Journal } from '../../model/journal.svelte';
import { parseOffsets } from '../../model/offsets';
import type { Session } from '../../model/session.svelte';
import type { Targets } from '../../model/targets.svelte';
import { ShapeEditor } from './shapeEditor.svelte';
import { placeText } from './placeWords';
import { numbers } from './someShapes';

function board(text = ''): { form: FormationDraft; editor: ShapeEditor } {
  const form = new FormationDraft({ rows: [] } as unknown as Session, { ids: [] } as unknown as Targets, {} as Journal, () => []);
  form.offsetsText = text;
  return { form, editor: new ShapeEditor(form) };
}
const spots = (editor: ShapeEditor) => editor.places.map((p) => [p.forward_m, p.right_m, p.down_m]);
const file = (text: string) => ({ name: 'a.csv', size: text.length, text: () => Promise.resolve(text) });

describe('ShapeEditor', () => {
  it('begins with the first place, writes what is drawn and asks for a preview', () => {
    const { form, editor } = board();
    expect([spots(editor), editor.fault, form.preview, editor.movable]).toEqual([[[0, 0, 0]], '', false, false]);
    editor.add({ forwardM: -5.1, rightM: 3.2 });
    expect(form.offsetsText).toBe('forward_m,right_m,down_m\n0,0,0\n-5,3,0\n');
    expect([editor.chosen, form.preview]).toEqual([1, true]);
  });

  it('draws what is typed, and over a fault draws nothing but shows what was', () => {
    const { form, editor } = board('[[0,0,0],[-5,2,-1]]');
    expect(spots(editor)).toEqual([[0, 0, 0], [-5, 2, -1]]);
    editor.choose(1);
    form.offsetsText = '0,0,0\n-5,x,0';
    expect([editor.fault, spots(editor), editor.movable, editor.fileText()]).toEqual(['line 2: "x" is no number', [[0, 0, 0], [-5, 2, -1]], false, '']);
    editor.add({ forwardM: 1, rightM: 1 });
    editor.nudge(1, 0, null);
    editor.remove();
    expect(form.offsetsText).toBe('0,0,0\n-5,x,0');
    editor.undo();
    expect([form.offsetsText, editor.fault]).toEqual(['[[0,0,0],[-5,2,-1]]', '']);
  });

  it('moves the chosen place but never the first, and takes a drag back at once', () => {
    const { form, editor } = board('0,0,0\n-5,2,-1');
    editor.nudge(1, 1, null);
    editor.remove();
    expect(form.offsetsText).toBe('0,0,0\n-5,2,-1');
    editor.choose(1);
    editor.drag({ forwardM: -6.2, rightM: 2 }, 'drag 1');
    editor.drag({ forwardM: -7.2, rightM: 2.9 }, 'drag 1');
    editor.nudge(-0.1, 0, null);
    editor.set({ down_m: -4.25 }, 'field');
    expect(spots(editor)[1]).toEqual([-7.1, 3, -4.25]);
    editor.undo();
    editor.undo();
    editor.undo();
    expect(form.offsetsText).toBe('0,0,0\n-5,2,-1');
    editor.remove();
    expect([spots(editor), editor.chosen]).toEqual([[[0, 0, 0]], 0]);
  });

  it('takes a file, or says why not and keeps the shape', async () => {
    const { form, editor } = board('0,0,0\n-5,2,-1');
    await editor.take(file('0,0\n'));
    expect([editor.said, form.offsetsText]).toEqual([{ bad: true, text: 'a.csv not read: line 1: 2 fields instead of three' }, '0,0,0\n-5,2,-1']);
    await editor.take(file('0,0,0\n1,1,1\n2,2,2'));
    expect([editor.said, spots(editor).length]).toEqual([{ bad: false, text: 'Read from a.csv. Places: 3' }, 3]);
    editor.undo();
    expect(form.offsetsText).toBe('0,0,0\n-5,2,-1');
  });

  it('can take every change back, and its text is always the drawing', () => {
    const next = numbers(11);
    const { form, editor } = board('0,0,0\n-5,2,-1\n-9,0.125,0');
    const texts = [form.offsetsText];
    const acts = [
      () => editor.add({ forwardM: next() * 50, rightM: next() * 50 }),
      () => editor.nudge(0.1, -0.5, null),
      () => editor.remove(),
      () => editor.set({ down_m: next() * 9 }, null),
      () => editor.addBehind(),
    ];
    for (let k = 0; k < 80; k++) {
      editor.choose(Math.floor(next() * editor.drawn.length));
      acts[Math.floor(next() * acts.length)]!();
      expect(parseOffsets(form.offsetsText)).toEqual({ offsets: editor.places });
      if (form.offsetsText !== texts.at(-1)) texts.push(form.offsetsText);
    }
    for (const text of texts.reverse().slice(1)) {
      editor.undo();
      expect(form.offsetsText).toBe(text);
    }
    expect(editor.canUndo).toBe(false);
  });

  it('knows after a look at another panel what there was', () => {
    const { form, editor } = board();
    editor.add({ forwardM: 1, rightM: 2 });
    expect(spots(editor).length).toBe(2);
    form.offsetsText = '1,';
    const again = new ShapeEditor(form);
    expect(spots(again)).toEqual([[0, 0, 0], [1, 2, 0]]);
    again.undo();
    again.undo();
    expect([form.offsetsText, again.canUndo]).toEqual(['', false]);
  });

  it('lacks places before anything is asked, but has too many at no time', () => {
    const { form, editor } = board('0,0,0\n-5,2,-1');
    form.shape = 'free';
    expect(form.missing).toBe('');
    const four = new FormationDraft({ rows: [] } as unknown as Session, { ids: [1, 2, 3, 4] } as unknown as Targets, {} as Journal, () => []);
    four.shape = 'free';
    four.offsetsText = form.offsetsText;
    expect([four.wouldTakePart, four.missing]).toEqual([4, 'Places missing: 2']);
    expect(editor.places.length).toBe(2);
  });
});

describe('a place in words', () => {
  it.each([
    [{ forward_m: -5, right_m: 3, down_m: 0 }, 'Place 2: 5.0 m back, 3.0 m right, level'],
    [{ forward_m: 0, right_m: -3, down_m: -2 }, 'Place 2: 3.0 m left, 2.0 m up'],
    [{ forward_m: 0, right_m: 0, down_m: 1 }, 'Place 2: at the origin, 1.0 m down'],
  ])('%j', (place, words) => expect(placeText(1, place, '', false)).toBe(words));

  it('says what is the matter with it', () => {
    expect(placeText(4, { forward_m: 1, right_m: 0, down_m: 0 }, 'nearer than 1.0 m to another', true)).toBe('Place 5: 1.0 m forward, level, nearer than 1.0 m to another, stays empty');
  });
});
