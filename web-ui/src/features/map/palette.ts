// The theme's colours as the canvas needs them, read once per theme change.

const NAMES = {
  bg: '--map-bg',
  minor: '--map-minor',
  major: '--map-major',
  axis: '--map-axis',
  label: '--map-label',
  trail: '--map-trail',
  vehicle: '--map-vehicle',
  outline: '--map-outline',
  slot: '--map-slot',
  route: '--map-route',
  fence: '--map-fence',
  hatch: '--map-hatch',
  text: '--text',
  accent: '--accent',
  accentStrong: '--accent-strong',
  advisory: '--advisory',
  ready: '--ready',
  warning: '--warning',
  critical: '--critical',
} as const;

export type Palette = Record<keyof typeof NAMES, string>;

export function readPalette(element: Element): Palette {
  const style = getComputedStyle(element);
  const entries = Object.entries(NAMES).map(([key, name]) => [key, style.getPropertyValue(name).trim()]);
  return Object.fromEntries(entries) as Palette;
}

/** Colour of a level of urgency. */
export function levelColour(palette: Palette, level: number): string {
  return level >= 3 ? palette.critical : level === 2 ? palette.warning : level === 1 ? palette.advisory : palette.vehicle;
}
