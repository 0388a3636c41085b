// `window.__skeinSpace`: what the view in space shows, for tests that cannot read pixels. Read-only; nothing of the page depends on it.

export type SpaceHook = {
  drawer(): 'webgl' | 'canvas';
  frames(): number;
  positions(): { id: number; x: number; y: number }[];
  bearingDeg(): number;
  distanceM(): number;
  /** Heights of the fences' volumes above the swarm's origin. */
  walls(): { name: string; floorM: number; ceilingM: number }[];
};

declare global {
  interface Window {
    __skeinSpace?: SpaceHook;
  }
}
