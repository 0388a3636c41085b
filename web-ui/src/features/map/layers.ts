// What of the map can be shown and hidden, and what the operator chose; the choice is kept in the browser. Vehicles are no layer: they
// are always there.

export const LAYERS = [
  { key: 'labels', words: 'Labels' },
  { key: 'trails', words: 'Trails' },
  { key: 'slots', words: 'Slots and setpoints' },
  { key: 'motion', words: 'Way of the next 3 s' },
  { key: 'links', words: 'Links' },
  { key: 'cameras', words: 'What cameras see' },
  { key: 'tracks', words: 'Tracks' },
  { key: 'fences', words: 'Fences' },
  { key: 'plans', words: 'Routes' },
  { key: 'heights', words: 'Heights' },
  { key: 'grid', words: 'Grid' },
  { key: 'world', words: 'Coasts and borders' },
] as const;

export type Layer = (typeof LAYERS)[number]['key'];
export type LayerChoice = Record<Layer, boolean>;

/** Links, ways and what cameras see are for a closer look; the rest is what one flies by. */
const AT_FIRST: LayerChoice = {
  labels: true, trails: true, slots: true, motion: false, links: false, cameras: false, tracks: true, fences: true, plans: true, heights: true, grid: true, world: true,
};
const KEY = 'skein-layers';

/** The choice that a stored text holds; what it does not say is as at first. */
export function readChoice(text: string | null): LayerChoice {
  const choice = { ...AT_FIRST };
  let stored: unknown;
  try {
    stored = JSON.parse(text ?? 'null');
  } catch {
    return choice;
  }
  if (typeof stored !== 'object' || stored === null) return choice;
  for (const { key } of LAYERS) {
    const value: unknown = (stored as Record<string, unknown>)[key];
    if (typeof value === 'boolean') choice[key] = value;
  }
  return choice;
}

export function loadChoice(): LayerChoice {
  try {
    return readChoice(localStorage.getItem(KEY));
  } catch {
    return readChoice(null); // storage can be forbidden; the page works without
  }
}

export function keepChoice(choice: LayerChoice): void {
  try {
    localStorage.setItem(KEY, JSON.stringify(choice));
  } catch {
    // not kept, that is all
  }
}
