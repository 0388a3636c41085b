// The keys of the console: one list that is both what is obeyed and what the help shows. A key never commands a vehicle: it brings the
// button into focus, which says what will happen and to whom, and that button is then pressed or held like any other.

import type { Text } from '../language/language.svelte';

export type Shortcut = {
  /** As on the keyboard: one key, or two after each other. */
  keys: string;
  words: Text;
  group: 'Go to' | 'Choose' | 'Command' | 'Recording' | 'This console';
  /** Where it is obeyed, if not everywhere. */
  only?: 'live' | 'replay';
};

export const SHORTCUTS: readonly Shortcut[] = [
  { keys: 'g m', words: 'Map', group: 'Go to' },
  { keys: 'g f', words: 'Fleet', group: 'Go to' },
  { keys: 'g v', words: 'Video', group: 'Go to', only: 'live' },
  { keys: 'g c', words: 'Preflight checks', group: 'Go to', only: 'live' },
  { keys: 'g a', words: 'Alerts and events', group: 'Go to' },
  { keys: 'g p', words: 'Plugins and supervision', group: 'Go to', only: 'live' },
  { keys: 'g r', words: 'Recorded flights', group: 'Go to', only: 'live' },
  { keys: 'k', words: 'Page of the vehicle before this, which it selects', group: 'Go to' },
  { keys: 'j', words: 'Page of the vehicle after this, which it selects', group: 'Go to' },
  { keys: '/', words: 'Find vehicles: 3, 1-4, a name, a state; Enter goes to the button that selects them', group: 'Choose' },
  { keys: 'Escape', words: 'Lock the emergency stop, leave a tool, clear the targets', group: 'Choose', only: 'live' },
  { keys: 't', words: 'Take off', group: 'Command', only: 'live' },
  { keys: 'h', words: 'Hold', group: 'Command', only: 'live' },
  { keys: 'l', words: 'Land', group: 'Command', only: 'live' },
  { keys: 'r', words: 'Return', group: 'Command', only: 'live' },
  { keys: 'o', words: 'Take, ask for or let go the targets', group: 'Command', only: 'live' },
  { keys: 'a', words: 'Answer who asks for vehicles', group: 'Command', only: 'live' },
  { keys: 'Shift+H', words: 'HOLD ALL', group: 'Command', only: 'live' },
  { keys: 'Shift+R', words: 'RETURN ALL', group: 'Command', only: 'live' },
  { keys: 'Shift+E', words: 'Emergency stop, first step', group: 'Command', only: 'live' },
  { keys: 'Space', words: 'Go on or stand still', group: 'Recording', only: 'replay' },
  { keys: ',', words: '10 s back', group: 'Recording', only: 'replay' },
  { keys: '.', words: '10 s on', group: 'Recording', only: 'replay' },
  { keys: 'b', words: 'To the mark before', group: 'Recording', only: 'replay' },
  { keys: 'n', words: 'To the next mark', group: 'Recording', only: 'replay' },
  { keys: 's', words: 'Sound of alerts on or off', group: 'This console', only: 'live' },
  { keys: '?', words: 'This list', group: 'This console' },
];

export type Stroke = { key: string; ctrlKey: boolean; metaKey: boolean; altKey: boolean; repeat: boolean };

/** After so long the first of two keys is forgotten. */
const PAIR_WITHIN_MS = 1500;

/** Tells which shortcut a row of strokes is. */
export class Keys {
  #first = '';
  #firstAt = -Infinity;

  /** The key is the second of two: it is meant for nothing else. */
  completes(key: string, nowMs: number): boolean {
    return nowMs - this.#firstAt <= PAIR_WITHIN_MS && SHORTCUTS.some(({ keys }) => keys === `${this.#first} ${key}`);
  }

  /** The shortcut that `stroke` completes, or null. */
  press(stroke: Stroke, nowMs: number): string | null {
    // With a modifier it is the browser's; a key held down is not pressed again.
    if (stroke.ctrlKey || stroke.metaKey || stroke.altKey || stroke.repeat) return null;
    const pair = `${this.#first} ${stroke.key}`;
    const paired = this.completes(stroke.key, nowMs);
    this.#first = '';
    if (paired) return pair;
    if (SHORTCUTS.some(({ keys }) => keys.startsWith(`${stroke.key} `))) {
      this.#first = stroke.key;
      this.#firstAt = nowMs;
      return null;
    }
    const capital = /^[A-Z]$/.test(stroke.key) ? `Shift+${stroke.key}` : stroke.key === ' ' ? 'Space' : stroke.key;
    return SHORTCUTS.some(({ keys }) => keys === capital) ? capital : null;
  }
}

export class Shortcuts {
  /** The list is open. */
  shown = $state(false);
  /** The search field is on its way: what is typed until it is there is meant for it and does nothing else. */
  finding = false;
  readonly keys = new Keys();
}

/** Which button a key brings into focus, by its `data-verb`. */
export const FOCUSES: Readonly<Record<string, string>> = {
  t: 'take_off', h: 'hold', l: 'land', r: 'return', o: 'authority', a: 'answer', 'Shift+H': 'hold_all', 'Shift+R': 'return_all', 'Shift+E': 'emergency',
};

/** Those that are obeyed where a flight is shown again, or where it is flown. */
export function shortcutsIn(replay: boolean): readonly Shortcut[] {
  return SHORTCUTS.filter(({ only }) => only === undefined || only === (replay ? 'replay' : 'live'));
}
