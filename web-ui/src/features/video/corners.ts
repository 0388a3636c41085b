// Where a tile on the map comes to rest: in the corner that it was let go nearest to. Pure.

import { CORNERS } from '../../model/video.svelte';
import type { Corner } from '../../model/video.svelte';

/** The corner of a box that a place in it is nearest to; places count from its upper left. */
export function nearestCorner(x: number, y: number, width: number, height: number): Corner {
  return `${y < height / 2 ? 'top' : 'bottom'}-${x < width / 2 ? 'left' : 'right'}`;
}

/** The next one, clockwise: for whoever has no pointer. */
export function nextCorner(corner: Corner): Corner {
  return CORNERS[(CORNERS.indexOf(corner) + 1) % CORNERS.length] ?? corner;
}
