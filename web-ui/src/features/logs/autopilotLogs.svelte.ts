// The logs of the vehicle whose page is open: listed when they are asked for, and how far the fetching of one has come, asked once a second while one is
// on its way. Must never ask for the list while one is: the autopilot sends one thing at a time.

import { ApiError, fetchAutopilotLog, getAutopilotLogs, getLogFetch } from '../../protocol/rest';
import type { AutopilotLog, LogFetch } from '../../protocol/types';
import { isUnderWay, newestFirst } from './logWords';

const EVERY_MS = 1000;

export class AutopilotLogs {
  /** Null while they are not known. */
  list = $state.raw<readonly AutopilotLog[] | null>(null);
  /** The log that is being fetched, or was last. */
  fetch = $state.raw<LogFetch | null>(null);
  /** Why there is no list, or why none is being fetched. */
  error = $state.raw<ApiError | null>(null);
  /** An answer is awaited. */
  asking = $state(false);

  readonly #vehicle: number;
  #timer: ReturnType<typeof setTimeout> | undefined;
  #open = true;
  /** The last question: an answer to one before it is not taken. */
  #asked = 0;

  constructor(vehicle: number) {
    this.#vehicle = vehicle;
  }

  /** Nobody looks any more. */
  close(): void {
    this.#open = false;
    clearTimeout(this.#timer);
  }

  /** Asks how the fetching stands and, if none is under way, for the list. */
  async load(): Promise<void> {
    if (this.asking) return;
    await this.#awaiting(async () => {
      await this.#look();
      await this.#askList();
    });
  }

  /** Asks how the fetching stands, and again until it has ended. */
  async look(): Promise<void> {
    try {
      await this.#look();
    } catch {
      // That the server is not heard is said by the banner.
    }
  }

  /** Begins to fetch a log. */
  async begin(number: number): Promise<void> {
    if (this.asking) return;
    await this.#awaiting(async () => {
      const asked = ++this.#asked;
      const fetch = await fetchAutopilotLog(this.#vehicle, number);
      if (asked === this.#asked) this.fetch = fetch;
      this.#again();
    });
  }

  async #awaiting(ask: () => Promise<void>): Promise<void> {
    this.asking = true;
    this.error = null;
    try {
      await ask();
    } catch (error) {
      this.error = error instanceof ApiError ? error : new ApiError(0, 'unknown', String(error));
      // Another console may have begun to fetch one.
      await this.look();
    }
    this.asking = false;
  }

  async #look(): Promise<void> {
    const asked = ++this.#asked;
    const { fetch } = await getLogFetch(this.#vehicle);
    if (asked === this.#asked) this.fetch = fetch;
    this.#again();
  }

  async #askList(): Promise<void> {
    if (!isUnderWay(this.fetch)) this.list = newestFirst((await getAutopilotLogs(this.#vehicle)).logs);
  }

  #again(): void {
    clearTimeout(this.#timer);
    if (this.#open && isUnderWay(this.fetch)) this.#timer = setTimeout(() => void this.#beat(), EVERY_MS);
  }

  async #beat(): Promise<void> {
    if (!document.hidden) await this.look();
    if (isUnderWay(this.fetch)) return this.#again();
    // What was refused meanwhile was refused because of it.
    this.error = null;
    if (this.#open && this.list === null) await this.load();
  }
}
