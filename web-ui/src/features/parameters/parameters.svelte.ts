// The parameters of the vehicle whose page is open: asked for while somebody looks, only what has changed since.
// Must never write one by itself, or twice.

import { ApiError, getParameters, putParameter, readParameters } from '../../protocol/rest';
import type { ParameterReceipt, ReadingAction } from '../../protocol/types';
import { NOTHING, merged } from './parameterLines';
import type { Known } from './parameterLines';

const WHILE_READING_MS = 500;
const EVERY_MS = 2500;

export class Parameters {
  known = $state.raw<Known>(NOTHING);
  /** Why they cannot be had; empty if they can. */
  error = $state.raw<ApiError | null>(null);

  readonly #vehicle: number;
  #timer: ReturnType<typeof setTimeout> | undefined;
  #watching = false;
  #begun = false;
  #asking = false;

  constructor(vehicle: number) {
    this.#vehicle = vehicle;
  }

  /** Looks until the returned function is called. The reading of all is begun if nobody has read them yet. */
  watch(): () => void {
    this.#watching = true;
    void this.look();
    return () => {
      this.#watching = false;
      clearTimeout(this.#timer);
    };
  }

  async look(): Promise<void> {
    if (this.#asking) return;
    clearTimeout(this.#timer);
    this.#asking = true;
    try {
      if (!document.hidden) {
        const answer = await getParameters(this.#vehicle, this.known.revision, !this.#begun);
        this.#begun = true;
        this.known = merged(this.known, answer);
        this.error = null;
      }
    } catch (error) {
      this.error = asApiError(error);
    }
    this.#asking = false;
    if (!this.#watching) return;
    const soon = this.known.reading.state === 'reading';
    this.#timer = setTimeout(() => void this.look(), soon ? WHILE_READING_MS : EVERY_MS);
  }

  /** Begins the reading, begins it from the start, or ends it. */
  async read(action: ReadingAction): Promise<void> {
    try {
      await readParameters(this.#vehicle, action);
      await this.look();
    } catch (error) {
      this.error = asApiError(error);
    }
  }

  /** Writes one; throws why not. */
  async write(name: string, value: number): Promise<ParameterReceipt> {
    try {
      return await putParameter(this.#vehicle, name, value);
    } catch (error) {
      throw asApiError(error);
    } finally {
      void this.look();
    }
  }
}

function asApiError(error: unknown): ApiError {
  return error instanceof ApiError ? error : new ApiError(0, 'unknown', String(error));
}
