// The free shape while it is drawn: which place is chosen, what a hand does to it, what was said last. The text of the form is the one truth:
// what is drawn is written there and read from there. Must never draw, and never change a text that it cannot read.

import { t } from '../../language/language.svelte';
import type { FormationDraft } from '../../model/formationDraft.svelte';
import type { OffsetFrd } from '../../protocol/types';
import { FARTHEST_M, MOST_DRAWN, freeSpot, nearOnes, placeAdded, placeRemoved, placeSet, snapped, toMm } from './shapeBoard';
import type { Ground } from './shapeBoard';
import { offsetsText, readShape } from './shapeFile';
import type { Named } from './shapeFile';
import { ShapeHistory } from './shapeHistory';

const ORIGIN: readonly OffsetFrd[] = [{ forward_m: 0, right_m: 0, down_m: 0 }];

/** What outlasts a look at another panel. */
type Kept = { history: ShapeHistory; lastGood: readonly OffsetFrd[] };
const keptOf = new WeakMap<FormationDraft, Kept>();

export class ShapeEditor {
  #chosen = $state(0);
  said = $state.raw<{ bad: boolean; text: string } | null>(null);
  readonly #form: FormationDraft;
  readonly #kept: Kept;
  /** Counts the changes of the history, which is no state itself. */
  #steps = $state(0);

  constructor(form: FormationDraft) {
    this.#form = form;
    this.#kept = keptOf.get(form) ?? { history: new ShapeHistory(form.offsetsText), lastGood: ORIGIN };
    keptOf.set(form, this.#kept);
  }

  /** What is wrong with the text; empty if nothing is, and while there is no text yet. */
  fault = $derived.by<string>(() => {
    const { offsets, offsetsText: text } = this.#form;
    return 'fault' in offsets && text.trim() !== '' ? offsets.fault : '';
  });

  /** The places as the text says, or as it said when it was last whole. Without a text the first one is there already. */
  places = $derived.by<readonly OffsetFrd[]>(() => {
    const { offsets, offsetsText: text } = this.#form;
    if ('offsets' in offsets) this.#kept.lastGood = offsets.offsets;
    else if (text.trim() === '') this.#kept.lastGood = ORIGIN;
    return this.#kept.lastGood;
  });

  drawn = $derived(this.places.slice(0, MOST_DRAWN));
  near = $derived(nearOnes(this.drawn));
  chosen = $derived.by<number>(() => Math.min(this.#chosen, this.drawn.length - 1));
  place = $derived.by<OffsetFrd>(() => this.drawn[this.chosen] ?? ORIGIN[0]!);
  /** The chosen place can be changed: it is not the first, from which all are measured, and the text can be read. */
  movable = $derived.by<boolean>(() => this.fault === '' && this.chosen > 0);
  canUndo = $derived.by<boolean>(() => {
    void this.#steps;
    return this.#kept.history.canUndo(this.#form.offsetsText);
  });

  choose(which: number): void {
    this.#chosen = Math.max(0, Math.min(which, this.drawn.length - 1));
  }

  add(at: Ground): void {
    if (this.fault !== '') return;
    const after = placeAdded(this.places, at);
    this.#write(offsetsText(after), null);
    this.#chosen = after.length - 1;
  }

  /** Adds one where there is room, as far from the last as the vehicles are to be from each other. */
  addBehind(): void {
    this.add(freeSpot(this.places, this.#form.spacingM));
  }

  /** Other figures for the chosen place; those of one `run` are taken back together. */
  set(to: Partial<OffsetFrd>, run: string | null): void {
    if (!this.movable) return;
    const metres = (value: number): number => toMm(Math.min(FARTHEST_M, Math.max(-FARTHEST_M, value)));
    const bounded = Object.fromEntries(Object.entries(to).map(([axis, value]) => [axis, metres(value)]));
    this.#write(offsetsText(placeSet(this.places, this.chosen, bounded)), run);
  }

  drag(to: Ground, run: string): void {
    this.set({ forward_m: snapped(to.forwardM), right_m: snapped(to.rightM) }, run);
  }

  nudge(forwardM: number, rightM: number, run: string | null): void {
    const { forward_m, right_m } = this.place;
    this.set({ forward_m: forward_m + forwardM, right_m: right_m + rightM }, run);
  }

  remove(): void {
    if (!this.movable) return;
    const which = this.chosen;
    this.#write(offsetsText(placeRemoved(this.places, which)), null);
    this.#chosen = which - 1;
  }

  undo(): void {
    const before = this.#kept.history.undo(this.#form.offsetsText);
    if (before === null) return;
    this.#form.offsetsText = before;
    this.#changed();
  }

  /** Takes the shape from a file; whatever is wrong with it is said, and the shape stays. */
  async take(file: Named): Promise<void> {
    const read = await readShape(file);
    if ('fault' in read) {
      this.said = { bad: true, text: t('{file} not read: {why}', { file: file.name, why: read.fault }) };
      return;
    }
    this.#write(read.text, null);
    this.#chosen = 0;
    this.said = { bad: false, text: t('Read from {file}. Places: {count}', { file: file.name, count: read.count }) };
  }

  say(text: string): void {
    this.said = { bad: false, text };
  }

  /** The shape as a file has it; empty while the text cannot be read. */
  fileText(): string {
    return this.fault === '' ? offsetsText(this.places) : '';
  }

  #write(text: string, run: string | null): void {
    this.#kept.history.change(this.#form.offsetsText, text, run);
    this.#form.offsetsText = text;
    this.#changed();
  }

  #changed(): void {
    this.#steps++;
    this.said = null;
    this.#form.preview = true;
  }
}
