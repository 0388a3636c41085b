// The colours of every theme against each other: what is read on what, and how well.

import { describe, expect, it } from 'vitest';
import css from './theme.css?raw';
import { THEMES } from './theme.svelte';

function colours(theme: string): Map<string, string> {
  const block = theme === 'dark' ? /^:root \{([^}]*)\}/m : new RegExp(`^:root\\[data-theme='${theme}'\\] \\{([^}]*)\\}`, 'm');
  const text = block.exec(css)?.[1] ?? '';
  return new Map([...text.matchAll(/(--[a-z-]+): (#[0-9a-f]{6});/g)].map((found) => [found[1]!, found[2]!]));
}

function luminance(colour: string): number {
  const part = (at: number): number => {
    const value = Number.parseInt(colour.slice(at, at + 2), 16) / 255;
    return value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4;
  };
  return 0.2126 * part(1) + 0.7152 * part(3) + 0.0722 * part(5);
}

function contrast(a: string, b: string): number {
  const [low, high] = [luminance(a), luminance(b)].sort((x, y) => x - y) as [number, number];
  return (high + 0.05) / (low + 0.05);
}

const GROUNDS = ['--bg', '--panel', '--raised', '--raised-hover', '--field'];
const WORDS = ['--text', '--muted', '--faint', '--accent', '--advisory', '--warning', '--critical'];
const PAIRS = [
  ...GROUNDS.flatMap((ground) => WORDS.map((word) => [word, ground])),
  ...['accent', 'advisory', 'warning', 'critical'].map((name) => ['--text', `--${name}-wash`]),
  ...['advisory', 'warning', 'critical'].map((name) => [`--${name}`, `--${name}-wash`]),
  ['--on-solid', '--critical-solid'],
] as [string, string][];

/** WCAG: AA for every text; the sun takes contrast away, so there AAA. */
const LEAST = { dark: 4.5, light: 4.5, sunlight: 7 };

describe.each(THEMES)('%s', (theme) => {
  const of = colours(theme);

  it('has every colour', () => {
    expect([...of.keys()].sort()).toEqual([...colours('dark').keys()].sort());
    expect(of.size).toBeGreaterThan(30);
  });

  it.each(PAIRS)('%s can be read on %s', (word, ground) => {
    expect(contrast(of.get(word)!, of.get(ground)!)).toBeGreaterThanOrEqual(LEAST[theme]);
  });

  it('edges of controls and what is drawn on the map can be told from their ground', () => {
    for (const [line, ground] of [['--line-strong', '--field'], ['--map-vehicle', '--map-bg'], ['--map-slot', '--map-bg'], ['--map-trail', '--map-bg'], ['--map-fence', '--map-bg']] as const) {
      expect(contrast(of.get(line)!, of.get(ground)!), `${line} on ${ground}`).toBeGreaterThanOrEqual(theme === 'sunlight' ? 7 : 2.2);
    }
  });
});
