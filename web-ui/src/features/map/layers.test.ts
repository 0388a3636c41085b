import { describe, expect, it } from 'vitest';
import { LAYERS, readChoice } from './layers';

describe('readChoice', () => {
  it('takes what was chosen and leaves the rest as it is at first', () => {
    const first = readChoice(null);
    const chosen = readChoice(JSON.stringify({ trails: !first.trails, links: !first.links }));
    expect(chosen).toEqual({ ...first, trails: !first.trails, links: !first.links });
  });

  it.each(['', 'no JSON', '7', 'null', '[]', '{"trails":"yes","unheard":true}'])('%j changes nothing', (text) => {
    expect(readChoice(text)).toEqual(readChoice(null));
  });

  it('fences are shown until somebody hides them', () => {
    expect(readChoice(null).fences).toBe(true);
    expect(Object.keys(readChoice(null)).sort()).toEqual(LAYERS.map((l) => l.key).sort());
  });
});
