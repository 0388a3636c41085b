// What is tracked, on the canvas: sign, name and class, how well its place is known, where it goes and where it was. What is old looks old.

import type { Tracks } from '../../model/tracks.svelte';
import { freshness } from '../../telemetry/trackTrails';
import type { TrailSpot } from '../../telemetry/trackTrails';
import { STALE_FROM_MS } from '../../telemetry/staleness';
import { MOTION_S } from '../map/paintFleet';
import { LabelRoom, toolsBox } from '../map/labelRoom';
import { FONT } from '../map/paintGround';
import { LINE_PX, labelPlace, widthOf } from '../map/paintLabels';
import type { Palette } from '../map/palette';
import type { View } from '../map/view';
import { errorEllipse } from './errorShape';
import type { Covariance, ErrorEllipse } from './errorShape';
import { signText } from './trackWords';

export type SeenTrack = {
  track: number; north: number; east: number; velocityNorth: number; velocityEast: number; upM: number; stale: boolean;
  text: string; pinned: boolean; selected: boolean; guessed: boolean; ellipse: ErrorEllipse | null; covariance: Covariance | null;
  /** Node's clock in ms: by it the trail fades. */
  atMs: number;
  trail: readonly TrailSpot[];
};

/** What is tracked, where it was told to be. */
export function seenTracks({ list, at, trails, selected }: Tracks, now: number): SeenTrack[] {
  return list.tracks.map((one) => ({
    track: one.track,
    north: one.position.north_m,
    east: one.position.east_m,
    velocityNorth: one.velocity.north_m_s,
    velocityEast: one.velocity.east_m_s,
    upM: -one.position.down_m,
    stale: (list.time - one.time) / 1000 + (now - at) >= STALE_FROM_MS,
    text: signText(one),
    pinned: one.pinned,
    selected: one.track === selected,
    guessed: one.guessed_range,
    ellipse: errorEllipse(one.covariance_m2),
    covariance: one.covariance_m2,
    atMs: list.time / 1000 + (now - at),
    trail: trails.of(one.track),
  }));
}

/** Half the side of a track's sign, and how long the strokes at its corners are, in pixels. */
const HALF_PX = 9;
const STROKE_PX = 5;
/** An ellipse smaller than this is hidden by the sign. */
const LEAST_ELLIPSE_PX = 6;
const STALE_ALPHA = 0.55;
const SELECTED_PX = 15;
/** So far from a sign's middle stands what it is. */
const NAME_PX = 18;

export function paintTracks(ctx: CanvasRenderingContext2D, view: View, palette: Palette, tracks: readonly SeenTrack[]): void {
  ctx.save();
  ctx.font = FONT;
  ctx.textBaseline = 'middle';
  ctx.textAlign = 'left';
  ctx.lineJoin = 'round';
  for (const track of tracks) paintTrail(ctx, view, palette, track);
  for (const track of tracks) paintEllipse(ctx, view, palette, track);
  for (const track of tracks) paintSign(ctx, view, palette, track, view.x(track.east), view.y(track.north));
  paintNames(ctx, view, palette, tracks, (track) => ({ x: view.x(track.east), y: view.y(track.north) }));
  ctx.restore();
}

/** What each is, beside its sign where there is room; who is looked at or kept is always named. For the map and the view in space alike. */
export function paintNames(
  ctx: CanvasRenderingContext2D, size: { width: number; height: number }, palette: Palette, tracks: readonly SeenTrack[],
  at: (track: SeenTrack) => { x: number; y: number },
): void {
  const room = new LabelRoom();
  room.take(toolsBox(size));
  ctx.save();
  ctx.font = FONT;
  ctx.textBaseline = 'middle';
  ctx.textAlign = 'left';
  // Who is looked at comes first: the others give way.
  for (const track of [...tracks].sort((a, b) => rank(b) - rank(a))) {
    const { x, y } = at(track);
    // Not a number is no place either.
    if (!(x >= 0 && y >= 0 && x <= size.width && y <= size.height)) continue;
    const box = labelPlace(x, y, widthOf(ctx, track.text, FONT), NAME_PX, room, size, rank(track) > 0);
    if (!box) continue;
    room.take(box);
    ctx.fillStyle = palette.bg;
    ctx.globalAlpha = 0.8;
    ctx.fillRect(box.x - 2, box.y, box.w + 4, LINE_PX);
    ctx.globalAlpha = 1;
    ctx.fillStyle = palette.text;
    ctx.fillText(track.text, box.x, box.y + LINE_PX / 2);
  }
  ctx.restore();
}

const rank = ({ selected, pinned }: SeenTrack): number => (selected ? 2 : pinned ? 1 : 0);

/** A trail fades in so many steps: each is one stroke, and a stroke for each spot would be thousands. */
const FADES = 6;

function paintTrail(ctx: CanvasRenderingContext2D, view: View, palette: Palette, { trail, atMs, north, east, stale }: SeenTrack): void {
  if (trail.length === 0) return;
  const step = (spot: TrailSpot): number => Math.min(FADES - 1, Math.floor(freshness(spot, atMs) * FADES));
  ctx.strokeStyle = palette.text;
  ctx.lineWidth = 1.5;
  let drawn = -1;
  trail.forEach((spot, k) => {
    const next = trail[k + 1] ?? { north, east };
    if (step(spot) !== drawn) {
      if (drawn >= 0) ctx.stroke();
      drawn = step(spot);
      // Never quite gone while it is kept: a line that ends nowhere would look like a track's beginning.
      ctx.globalAlpha = (0.15 + (0.55 * drawn) / (FADES - 1)) * (stale ? STALE_ALPHA : 1);
      ctx.beginPath();
      ctx.moveTo(view.x(spot.east), view.y(spot.north));
    }
    ctx.lineTo(view.x(next.east), view.y(next.north));
  });
  ctx.stroke();
  ctx.globalAlpha = 1;
}

/** Where it is with two standard deviations; broken where its range is only guessed. */
function paintEllipse(ctx: CanvasRenderingContext2D, view: View, palette: Palette, { ellipse, guessed, stale, selected, north, east }: SeenTrack): void {
  if (!ellipse || ellipse.longM * view.scale < LEAST_ELLIPSE_PX) return;
  ctx.strokeStyle = ctx.fillStyle = selected ? palette.accentStrong : palette.text;
  ctx.lineWidth = selected ? 1.8 : 1.2;
  ctx.setLineDash(guessed ? [6, 5] : []);
  ctx.beginPath();
  // The canvas counts angles clockwise from east, a heading clockwise from north.
  ctx.ellipse(view.x(east), view.y(north), ellipse.longM * view.scale, ellipse.shortM * view.scale, ellipse.headingRad - Math.PI / 2, 0, Math.PI * 2);
  ctx.globalAlpha = stale ? 0.03 : 0.07;
  ctx.fill();
  ctx.globalAlpha = stale ? STALE_ALPHA : 0.85;
  ctx.stroke();
  ctx.setLineDash([]);
  ctx.globalAlpha = 1;
}

function paintSign(ctx: CanvasRenderingContext2D, view: View, palette: Palette, track: SeenTrack, x: number, y: number): void {
  for (const [width, colour] of [[4.5, palette.bg], [2, palette.text]] as const) {
    ctx.lineWidth = width;
    ctx.strokeStyle = colour;
    ctx.globalAlpha = track.stale ? STALE_ALPHA : 1;
    ctx.beginPath();
    for (const [sx, sy] of [[-1, -1], [1, -1], [1, 1], [-1, 1]] as const) {
      ctx.moveTo(x + sx * HALF_PX, y + sy * (HALF_PX - STROKE_PX));
      ctx.lineTo(x + sx * HALF_PX, y + sy * HALF_PX);
      ctx.lineTo(x + sx * (HALF_PX - STROKE_PX), y + sy * HALF_PX);
    }
    if (!track.stale) {
      ctx.moveTo(x, y);
      ctx.lineTo(view.x(track.east + track.velocityEast * MOTION_S), view.y(track.north + track.velocityNorth * MOTION_S));
    }
    ctx.stroke();
  }
  if (track.pinned) {
    // A pin's head in its middle.
    ctx.fillStyle = palette.text;
    ctx.beginPath();
    ctx.arc(x, y, 3.2, 0, Math.PI * 2);
    ctx.fill();
  }
  if (track.selected) {
    ctx.globalAlpha = 1;
    ctx.lineWidth = 2;
    ctx.strokeStyle = palette.accentStrong;
    ctx.strokeRect(x - SELECTED_PX, y - SELECTED_PX, 2 * SELECTED_PX, 2 * SELECTED_PX);
  }
  ctx.globalAlpha = 1;
}

/** The track nearest to a place on the canvas within `reachPx`, or null. */
export function trackAt(view: View, tracks: readonly SeenTrack[], x: number, y: number, reachPx: number): number | null {
  let best: number | null = null;
  let least = reachPx;
  for (const { track, north, east } of tracks) {
    const distance = Math.hypot(view.x(east) - x, view.y(north) - y);
    if (distance > least) continue;
    best = track;
    least = distance;
  }
  return best;
}
