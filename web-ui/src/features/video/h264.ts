// What of a picture in H.264 the page needs to know: with which decoder it is read, and whether the decoder may be given it. Pure.

/** A sequence parameter set, by the type in the first byte of a unit. */
const SPS = 7;
const TYPE_BITS = 0x1f;

/** The decoder that a picture in Annex B wants, from its sequence parameter set; null where there is none in it. */
export function codecOf(annexB: Uint8Array): string | null {
  for (let at = 0; at + 6 < annexB.length; at++) {
    // A start code of three bytes is also the end of one of four.
    if (annexB[at] !== 0 || annexB[at + 1] !== 0 || annexB[at + 2] !== 1) continue;
    if (((annexB[at + 3] ?? 0) & TYPE_BITS) !== SPS) continue;
    const [profile, constraints, level] = [annexB[at + 4], annexB[at + 5], annexB[at + 6]];
    return `avc1.${[profile, constraints, level].map((byte) => (byte ?? 0).toString(16).padStart(2, '0')).join('')}`;
  }
  return null;
}

/** Pictures that wait in the decoder: more are too late to be worth it. */
const QUEUE_MOST = 5;

/** Lets pictures through to a decoder: from one that stands alone on, and none whose forerunner is missing. */
export class DecoderGate {
  #open = false;

  /** The decoder was made anew: it knows no picture. */
  close(): void {
    this.#open = false;
  }

  /** What to do with a picture; `ask` leaves it out and asks for one that stands alone. */
  take({ key, gap }: { key: boolean; gap: boolean }, queued: number): 'feed' | 'ask' {
    if (queued > QUEUE_MOST) this.#open = false;
    else if (key) this.#open = true;
    else if (gap) this.#open = false;
    return this.#open ? 'feed' : 'ask';
  }
}
