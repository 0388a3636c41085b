// The operator's own base map under everything else. Each picture goes where the swarm's own projection puts its corners, so that what is
// drawn on it and what is flown agree.

import type { SwarmProjection } from '../../telemetry/geodesy';
import type { Palette } from '../map/palette';
import type { View } from '../map/view';
import type { BaseMap } from './pictures';
import type { Degrees, Piece } from './tileMath';

/** The pictures are dimmed by this, so that signs and lines stand out on them. */
const DIMMED = 0.3;
/** Pictures overlap by this share, or the ground would shine through between them. */
const SEAM = 1 / 400;

/** What of Earth the view shows. */
export function pieceOf(view: View, projection: SwarmProjection): Piece {
  const piece: Piece = { south: Infinity, west: Infinity, north: -Infinity, east: -Infinity };
  for (const x of [0, view.width]) {
    for (const y of [0, view.height]) {
      const { latitudeDeg, longitudeDeg } = projection.unproject(view.north(y), view.east(x));
      piece.south = Math.min(piece.south, latitudeDeg);
      piece.north = Math.max(piece.north, latitudeDeg);
      piece.west = Math.min(piece.west, longitudeDeg);
      piece.east = Math.max(piece.east, longitudeDeg);
    }
  }
  return piece;
}

/** Returns how many pictures were drawn. */
export function paintBase(ctx: CanvasRenderingContext2D, view: View, ratio: number, projection: SwarmProjection, base: BaseMap, palette: Palette): number {
  const shown = base.shown(pieceOf(view, projection), 1 / view.scale);
  const place = ({ latitudeDeg, longitudeDeg }: Degrees): [number, number] => {
    const { north, east } = projection.project(latitudeDeg, longitudeDeg);
    return [view.x(east), view.y(north)];
  };
  ctx.save();
  for (const { patch, picture } of shown) {
    // Over one picture every projection is flat: three corners say it all, a turn by the meridian's convergence as well.
    const [x0, y0] = place(patch.upperLeft);
    const [x1, y1] = place(patch.upperRight);
    const [x2, y2] = place(patch.lowerLeft);
    const [w, h] = [picture.width, picture.height];
    ctx.setTransform(((x1 - x0) / w) * ratio, ((y1 - y0) / w) * ratio, ((x2 - x0) / h) * ratio, ((y2 - y0) / h) * ratio, x0 * ratio, y0 * ratio);
    ctx.drawImage(picture, 0, 0, w * (1 + SEAM), h * (1 + SEAM));
  }
  ctx.restore();
  if (shown.length > 0) {
    // All at once: where pictures overlap, each of its own would show.
    ctx.globalAlpha = DIMMED;
    ctx.fillStyle = palette.bg;
    ctx.fillRect(0, 0, view.width, view.height);
    ctx.globalAlpha = 1;
  }
  return shown.length;
}
