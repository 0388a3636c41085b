// Number, height and trouble of each vehicle beside its sign, where there is room. For the map and the view in space alike: both say where
// on the canvas a vehicle is.

import { t } from '../../language/language.svelte';
import { FLAG } from '../../protocol/frame';
import { isAirborne } from '../../telemetry/carry';
import { LabelRoom, toolsBox } from './labelRoom';
import type { Box } from './labelRoom';
import { CROWD_SCALE, SHORT_LABELS_FROM, eachPlaced } from './paintFleet';
import type { FleetScene } from './paintFleet';
import { FONT } from './paintGround';
import { levelColour } from './palette';
import type { Palette } from './palette';

const HEAD_FONT = `600 12px ${FONT.slice(FONT.indexOf(' ') + 1)}`;
export const LINE_PX = 16;
const SIGN_PX = 22;
/** Widths of texts that come again and again; bounded. */
const WIDTHS = new Map<string, number>();
const MOST_WIDTHS = 4000;

/** Where a vehicle is on the canvas; `x` is NaN for one that is not on it. */
export type OnCanvas = { x: number; y: number };
type Size = { width: number; height: number };
export type Locator = (index: number) => OnCanvas;

/** Labels right of the vehicles, or where there is room; one without room is left out unless its vehicle wants attention. */
export function paintLabels(
  ctx: CanvasRenderingContext2D, size: Size, palette: Palette, scene: FleetScene, at: Locator,
): void {
  const { fleet } = scene;
  const room = new LabelRoom();
  // Nothing is to be read under the map's tools.
  room.take(toolsBox(size));
  const short = fleet.presentCount > SHORT_LABELS_FROM;
  // No label over a neighbour's sign: in a crowd most go without, and the nearer one looks the more have theirs.
  const sign = short ? SIGN_PX * CROWD_SCALE : SIGN_PX;
  eachPlaced(fleet, (i) => {
    const { x, y } = at(i);
    if (!Number.isNaN(x)) room.take({ x: x - sign / 2, y: y - sign / 2, w: sign, h: sign });
  });
  ctx.save();
  ctx.textBaseline = 'middle';
  ctx.textAlign = 'left';
  ctx.lineJoin = 'round';
  ctx.lineWidth = 3;
  eachPlaced(fleet, (i) => {
    const { x, y } = at(i);
    // Not a number is no place either.
    if (!(x >= 0 && y >= 0 && x <= size.width && y <= size.height)) return;
    const id = fleet.ids[i] ?? 0;
    const { level, problem, height } = scene.marking(i);
    const leads = fleet.has(i, FLAG.leader);
    const head = leads ? `${id} ${t('leader')}` : `${id}`;
    const rest = level >= 2 ? problem : short || !isAirborne(fleet, i) ? '' : height;
    const headWidth = widthOf(ctx, head, HEAD_FONT);
    const restWidth = rest ? widthOf(ctx, rest, FONT) + 6 : 0;
    const selected = scene.selected.has(id);
    const box = labelPlace(x, y, headWidth + restWidth, leads || selected ? 26 : 17, room, size, level >= 2 || selected);
    if (!box) return;
    room.take(box);
    // A plate: a route that runs behind the words must not look like a line through them.
    ctx.fillStyle = palette.bg;
    ctx.globalAlpha = 0.9;
    ctx.fillRect(box.x - 2, box.y, box.w + 4, LINE_PX);
    ctx.globalAlpha = 1;
    write(ctx, head, box.x, box.y + 8, HEAD_FONT, palette.text);
    if (rest) write(ctx, rest, box.x + headWidth + 6, box.y + 8, FONT, level >= 2 ? levelColour(palette, level) : palette.label);
  });
  ctx.restore();
}

export function widthOf(ctx: CanvasRenderingContext2D, text: string, font: string): number {
  const key = `${font.length}|${text}`;
  const known = WIDTHS.get(key);
  if (known !== undefined) return known;
  if (WIDTHS.size >= MOST_WIDTHS) WIDTHS.clear();
  ctx.font = font;
  const { width } = ctx.measureText(text);
  WIDTHS.set(key, width);
  return width;
}

function write(ctx: CanvasRenderingContext2D, text: string, x: number, y: number, font: string, colour: string): void {
  if (ctx.font !== font) ctx.font = font;
  ctx.fillStyle = colour;
  ctx.fillText(text, x, y);
}

/** Right, left, above or below of a sign, where there is room; what is important stands right of it in any case. */
export function labelPlace(
  x: number, y: number, width: number, reach: number, room: LabelRoom, size: Size, important: boolean,
): Box | null {
  const fits = (box: Box): boolean => box.x >= 0 && box.x + box.w <= size.width && box.y >= 0 && box.y + box.h <= size.height && room.isFree(box);
  const right = { x: x + reach, y: y - LINE_PX / 2, w: width, h: LINE_PX };
  if (fits(right)) return right;
  const left = { x: x - width - reach, y: y - LINE_PX / 2, w: width, h: LINE_PX };
  if (fits(left)) return left;
  const above = { x: x - width / 2, y: y - reach - LINE_PX, w: width, h: LINE_PX };
  if (fits(above)) return above;
  const below = { x: x - width / 2, y: y + reach, w: width, h: LINE_PX };
  if (fits(below)) return below;
  return important ? right : null;
}
