// A tab's console over its life: reloaded, duplicated, kept by the browser; and the name it has.

import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { Operator, soundName } from './operator.svelte';
import { idOf } from './tab';

class Store {
  kept = new Map<string, string>();
  getItem = (key: string): string | null => this.kept.get(key) ?? null;
  setItem = (key: string, value: string): void => void this.kept.set(key, value);
  removeItem = (key: string): void => void this.kept.delete(key);
}

let count = 0;
const draw = (): string => (++count).toString(16).padStart(32, '0');
const show = (page: EventTarget, persisted: boolean): void => void page.dispatchEvent(Object.assign(new Event('pageshow'), { persisted }));

describe("a tab's id", () => {
  it('outlives a reload', () => {
    const storage = new Store();
    const first = new EventTarget();
    const id = idOf(() => ({ storage, page: first }), draw);
    first.dispatchEvent(new Event('pagehide'));
    expect(idOf(() => ({ storage, page: new EventTarget() }), draw)).toBe(id);
  });

  it('is not copied with the tab, however often it was reloaded or left and come back to', () => {
    const storage = new Store();
    const page = new EventTarget();
    const id = idOf(() => ({ storage, page }), draw);
    const duplicate = (): string => {
      const copy = new Store();
      copy.kept = new Map(storage.kept);
      return idOf(() => ({ storage: copy, page: new EventTarget() }), draw);
    };
    expect(duplicate()).not.toBe(id);
    page.dispatchEvent(new Event('pagehide'));
    show(page, true);
    expect(duplicate()).not.toBe(id);
    page.dispatchEvent(new Event('pagehide'));
    const next = new EventTarget();
    expect(idOf(() => ({ storage, page: next }), draw)).toBe(id);
    show(next, false);
    expect(duplicate()).not.toBe(id);
  });

  it('is drawn anew where storage is forbidden or holds something else', () => {
    const forbidden = (): never => {
      throw new DOMException('denied', 'SecurityError');
    };
    expect(idOf(forbidden, draw)).toMatch(/^[0-9a-f]{32}$/);
    const shut = { getItem: forbidden, setItem: forbidden, removeItem: forbidden };
    const page = new EventTarget();
    expect(idOf(() => ({ storage: shut, page }), draw)).toMatch(/^[0-9a-f]{32}$/);
    expect(() => page.dispatchEvent(new Event('pagehide'))).not.toThrow();
    const storage = new Store();
    storage.setItem('skein-console', '<script>');
    expect(idOf(() => ({ storage, page }), draw)).toMatch(/^[0-9a-f]{32}$/);
  });

  it('is drawn by chance', () => {
    const some = Array.from({ length: 50 }, () => idOf(() => ({ storage: new Store(), page: new EventTarget() })));
    expect(new Set(some).size).toBe(50);
    for (const id of some) expect(id).toMatch(/^[0-9a-f]{32}$/);
  });
});

describe('a name', () => {
  beforeEach(() => vi.stubGlobal('localStorage', new Store()));
  afterEach(() => vi.unstubAllGlobals());

  it('is what can be shown of it, and not longer than the node takes', () => {
    expect(soundName('  Anna\tB.\n')).toBe('Anna B.');
    expect(soundName('\u0000\u007f \u0085')).toBe('');
    expect(soundName('x'.repeat(70))).toHaveLength(64);
    // 64 bytes, and no half of a character.
    expect(soundName('ä'.repeat(40))).toBe('ä'.repeat(32));
    expect(soundName(`${'x'.repeat(62)}🛩`)).toBe('x'.repeat(62));
  });

  it('comes from the id until one is given, and is remembered', () => {
    const id = `3f2a${'0'.repeat(28)}`;
    const operator = new Operator(id);
    expect(operator.wire()).toEqual({ id, name: 'Console 3f2a' });
    operator.rename(' Anna ');
    expect(new Operator('b'.repeat(32)).wire()).toEqual({ id: 'b'.repeat(32), name: 'Anna' });
    operator.rename('   ');
    expect(operator.name).toBe('Console 3f2a');
  });
});
