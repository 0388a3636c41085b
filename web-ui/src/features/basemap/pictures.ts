// The operator's own base map: pictures out of one file of this computer. Nothing is fetched from anywhere and nothing is sent. Must never
// know what kind of file it is, nor keep more pictures than it may.

import type { Ground, Patch } from './ground';
import type { Piece } from './tileMath';

/** Pictures that are kept; the longest unused go first. With 256 pixels each way they take 50 MB. */
const MOST_KEPT = 200;

export class BaseMap {
  /** In the order of their last use; null: the file has nothing there. */
  readonly #kept = new Map<string, ImageBitmap | null>();
  readonly #loading = new Set<string>();
  #closed = false;

  /** `onpicture` is called whenever a picture has come. */
  constructor(
    readonly ground: Ground,
    readonly onpicture: () => void,
  ) {}

  get name(): string {
    return this.ground.name;
  }

  /** The pictures that are there for a piece of Earth, coarser ones below finer ones; what is missing is loaded. */
  shown(view: Piece, metresPerPixel: number): { patch: Patch; picture: ImageBitmap }[] {
    const found: { patch: Patch; picture: ImageBitmap }[] = [];
    for (const patch of this.ground.patches(view, metresPerPixel)) {
      const picture = this.#picture(patch);
      if (picture) found.push({ patch, picture });
    }
    return found;
  }

  close(): void {
    this.#closed = true;
    for (const picture of this.#kept.values()) picture?.close();
    this.#kept.clear();
    this.ground.close();
  }

  #picture(patch: Patch): ImageBitmap | null {
    const { key } = patch;
    const kept = this.#kept.get(key);
    if (kept !== undefined) {
      this.#kept.delete(key);
      this.#kept.set(key, kept);
      return kept;
    }
    if (!this.#loading.has(key) && this.#loading.size < this.ground.atOnce) void this.#load(patch);
    return null;
  }

  async #load({ key, load }: Patch): Promise<void> {
    this.#loading.add(key);
    let picture: ImageBitmap | null = null;
    try {
      picture = await load();
    } catch {
      // A picture that cannot be read is one that is not there.
    }
    this.#loading.delete(key);
    if (this.#closed) {
      picture?.close();
      return;
    }
    this.#kept.set(key, picture);
    for (const [oldest, old] of this.#kept) {
      if (this.#kept.size <= MOST_KEPT) break;
      old?.close();
      this.#kept.delete(oldest);
    }
    this.onpicture();
  }
}
