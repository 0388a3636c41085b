import { describe, expect, it } from 'vitest';
import { FOCUSES, Keys, SHORTCUTS } from './shortcuts.svelte';

const stroke = (key: string, over: object = {}) => ({ key, ctrlKey: false, metaKey: false, altKey: false, repeat: false, ...over });

describe('the keys', () => {
  it('are one, or two after each other in time', () => {
    const keys = new Keys();
    expect(keys.press(stroke('?'), 0)).toBe('?');
    expect(keys.press(stroke('g'), 0)).toBeNull();
    expect(keys.press(stroke('f'), 500)).toBe('g f');
    expect(keys.press(stroke('f'), 600)).toBeNull();
    expect(keys.press(stroke('g'), 1000)).toBeNull();
    expect(keys.press(stroke('f'), 9000)).toBeNull();
    expect(keys.press(stroke('H'), 9100)).toBe('Shift+H');
  });

  it('say that the second of two is meant for nothing else', () => {
    const keys = new Keys();
    expect(keys.completes('v', 0)).toBe(false);
    keys.press(stroke('g'), 0);
    expect([keys.completes('v', 1500), keys.completes('v', 1501), keys.completes('x', 100)]).toEqual([true, false, false]);
    keys.press(stroke('v'), 1000);
    expect(keys.completes('v', 1001)).toBe(false);
  });

  it('leave to the browser what is the browser\'s, and do not repeat', () => {
    const keys = new Keys();
    expect(keys.press(stroke('r', { ctrlKey: true }), 0)).toBeNull();
    expect(keys.press(stroke('r', { repeat: true }), 0)).toBeNull();
    expect(keys.press(stroke('r'), 0)).toBe('r');
  });

  it('have no two meanings, and every one that focuses is in the list', () => {
    expect(new Set(SHORTCUTS.map((s) => s.keys)).size).toBe(SHORTCUTS.length);
    for (const keys of Object.keys(FOCUSES)) expect(SHORTCUTS.some((s) => s.keys === keys)).toBe(true);
    for (const first of SHORTCUTS.filter((s) => s.keys.includes(' '))) {
      expect(SHORTCUTS.some((s) => s.keys === first.keys.split(' ')[0])).toBe(false);
    }
  });
});
