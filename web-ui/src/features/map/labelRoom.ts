// Finds room for labels: boxes that are taken, filed by where they are, so that a crowd costs no more per label than a few. Pure.

export type Box = { x: number; y: number; w: number; h: number };

const CELL_PX = 64;
/** A map lower than this has its tools in two columns (as in `MapTools`). */
export const LOW_PX = 400;
const TOOL_PX = 45;
const TOOLS = 8;

/** What the map's tools at the upper right lie over. */
export function toolsBox(size: { width: number; height: number }): Box {
  const columns = size.height <= LOW_PX ? 2 : 1;
  const w = columns * TOOL_PX + 12;
  return { x: size.width - w, y: 0, w, h: (TOOLS / columns) * TOOL_PX + 12 };
}

export class LabelRoom {
  readonly #cells = new Map<number, Box[]>();

  take(box: Box): void {
    this.#each(box, (key) => {
      const cell = this.#cells.get(key);
      if (cell) cell.push(box);
      else this.#cells.set(key, [box]);
      return true;
    });
  }

  isFree(box: Box): boolean {
    return this.#each(box, (key) => !this.#cells.get(key)?.some((other) => overlap(box, other)));
  }

  /** Runs over the cells of a box as long as `visit` says so; whether it always did. */
  #each(box: Box, visit: (key: number) => boolean): boolean {
    for (let column = Math.floor(box.x / CELL_PX); column <= Math.floor((box.x + box.w) / CELL_PX); column++) {
      for (let row = Math.floor(box.y / CELL_PX); row <= Math.floor((box.y + box.h) / CELL_PX); row++) {
        if (!visit(column * 65_536 + row)) return false;
      }
    }
    return true;
  }
}

function overlap(a: Box, b: Box): boolean {
  return a.x < b.x + b.w && b.x < a.x + a.w && a.y < b.y + b.h && b.y < a.y + a.h;
}
