// A question that is asked again and again, for what the stream does not carry. Must never ask while nobody looks.

/** Events come in swarms; one question after the last of them is enough. */
const SOON_MS = 150;

/** Asks again and again, `everyMs` after each answer. */
export class Pulse {
  #timer: ReturnType<typeof setTimeout> | undefined;
  #running = false;

  constructor(
    readonly ask: () => Promise<void>,
    readonly everyMs: () => number,
    readonly wanted: () => boolean,
  ) {}

  start(): void {
    this.#running = true;
    this.soon(0);
  }

  stop(): void {
    this.#running = false;
    clearTimeout(this.#timer);
  }

  soon(ms = SOON_MS): void {
    if (!this.#running) return;
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => void this.#beat(), ms);
  }

  async #beat(): Promise<void> {
    if (this.wanted() && !document.hidden) {
      try {
        await this.ask();
      } catch {
        // What was known stays; that the server is not heard is said by the banner.
      }
    }
    this.soon(this.everyMs());
  }
}
