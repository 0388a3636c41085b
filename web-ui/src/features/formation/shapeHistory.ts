// What a free shape's text was before each change, so that a change can be taken back. Holds the last hundred. Pure.

const MOST_STEPS = 100;
/** Long texts are kept for fewer steps. */
const MOST_CHARACTERS = 4_000_000;

export class ShapeHistory {
  #past: string[] = [];
  #known: string;
  #run: string | null = null;

  constructor(text: string) {
    this.#known = text;
  }

  /** What became of the text without the history hearing of it (typing) is one step of its own. */
  #settle(current: string): void {
    if (current === this.#known) return;
    this.#push(this.#known);
    this.#known = current;
    this.#run = null;
  }

  #push(text: string): void {
    this.#past.push(text);
    let kept = this.#past.reduce((sum, one) => sum + one.length, 0);
    while (this.#past.length > MOST_STEPS || (kept > MOST_CHARACTERS && this.#past.length > 1)) kept -= this.#past.shift()!.length;
  }

  /** The text goes from one to another. Changes of one run (a drag, a key that is held) are one step. */
  change(before: string, after: string, run: string | null = null): void {
    this.#settle(before);
    if (after === before) return;
    if (run === null || run !== this.#run) this.#push(before);
    this.#known = after;
    this.#run = run;
  }

  canUndo(current: string): boolean {
    return current !== this.#known || this.#past.length > 0;
  }

  /** What the text was before the last change, or null if there was none. */
  undo(current: string): string | null {
    this.#settle(current);
    const before = this.#past.pop() ?? null;
    if (before !== null) this.#known = before;
    this.#run = null;
    return before;
  }
}
