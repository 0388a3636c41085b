// The dictionary against the page: every text once, with the same values in it, and none that is not used.

import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { codes, de, parts } from './de';
import { language, said, t } from './language.svelte';

const sources = Object.entries(import.meta.glob<string>('../**/*.{svelte,ts}', { query: '?raw', import: 'default', eager: true }))
  .filter(([path]) => !path.startsWith('./') && !path.endsWith('.test.ts'))
  .map(([, text]) => text.replaceAll("\\'", "'"));
const names = (text: string): string[] => [...text.matchAll(/\{\w+\}/g)].map(String).sort();

describe('German', () => {
  it('has the values of the English text', () => {
    for (const [english, german] of Object.entries(de)) expect(names(german), english).toEqual(names(english));
  });

  it('has no text twice', () => {
    const all = Object.values(parts).flatMap((part) => Object.keys(part));
    expect(all.filter((text, at) => all.indexOf(text) !== at)).toEqual([]);
  });

  it('has no text that the page does not say', () => {
    const said = (text: string): boolean => sources.some((source) => source.includes(`'${text}'`) || source.includes(`"${text}"`));
    expect(Object.keys(de).filter((text) => !said(text))).toEqual([]);
  });

  it('has no empty word', () => {
    for (const [english, german] of Object.entries({ ...de, ...codes })) expect(german.trim(), english).not.toBe('');
  });
});

describe('the page', () => {
  const kept = new Map<string, string>();
  beforeEach(() => {
    kept.clear();
    vi.stubGlobal('localStorage', { getItem: (key: string) => kept.get(key) ?? null, setItem: (key: string, value: string) => kept.set(key, value) });
    vi.stubGlobal('document', { documentElement: { lang: '' } });
  });
  afterEach(async () => {
    await language.choose('en');
    vi.unstubAllGlobals();
  });

  it("speaks the first of the browser's languages that it knows", async () => {
    vi.stubGlobal('navigator', { languages: ['fr-FR', 'de-AT', 'en'] });
    await language.start();
    expect([language.name, document.documentElement.lang, t('Fleet')]).toEqual(['de', 'de', 'Flotte']);
  });

  it('speaks English where it knows none of them', async () => {
    vi.stubGlobal('navigator', { languages: ['fr-FR'] });
    await language.start();
    expect([language.name, t('Fleet')]).toEqual(['en', 'Fleet']);
  });

  it('remembers what was chosen', async () => {
    vi.stubGlobal('navigator', { languages: ['en'] });
    await language.choose('de');
    await language.choose('en');
    await language.choose('de');
    await language.start();
    expect(language.name).toBe('de');
  });

  it('puts values into their places, and leaves alone what it has no word for', async () => {
    expect(t('{count} of {all} shown', { count: 2, all: 7 })).toBe('2 of 7 shown');
    await language.choose('de');
    expect(t('{count} of {all} shown', { count: 2, all: 7 })).toBe('2 von 7 gezeigt');
    expect([said('holding'), said('some new state')]).toEqual(['hält', 'some new state']);
  });
});
