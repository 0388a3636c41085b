// What draws a view in space: one with WebGL, one on a plain canvas where there is none. Both draw the same model.

import type { Palette } from '../map/palette';
import type { Orbit } from './orbit';
import type { SpaceModel } from './spaceModel';

export type Drawer = {
  readonly kind: 'webgl' | 'canvas';
  /** CSS pixels and the screen's pixel ratio. */
  resize(width: number, height: number, ratio: number): void;
  draw(model: SpaceModel, orbit: Orbit, palette: Palette): void;
  dispose(): void;
};

/** Length of an aircraft in the picture, whatever its distance. */
export const CRAFT_PX = 26;
/** ... but never shorter than this in space. */
export const CRAFT_M = 0.7;
/** How thick the filling of a zone is. */
export const FILL_OPACITY = { inclusion: 0.04, exclusion: 0.13 } as const;
