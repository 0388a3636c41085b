// What the stream does not carry, asked for at a pace that fits it: the fences in force, the preflight report, the references. Events about them bring the question forward. Must never ask while nobody looks.

import { getFences, getPreflight, getReferences } from '../protocol/rest';
import type { EventRecord, FenceAnswer, PreflightAnswer, ReferenceSnapshot } from '../protocol/types';
import { Pulse } from './pulse';
import type { Session } from './session.svelte';

/** Above so many vehicles the pace of the preflight report goes down with their number: one answer holds them all. */
const FULL_PACE = 40;
const FENCES_EVERY_MS = 4000;
const PREFLIGHT_EVERY_MS = 2500;
const REFERENCES_EVERY_MS = 1000;

export class Watch {
  fences = $state.raw<FenceAnswer | null>(null);
  preflight = $state.raw<PreflightAnswer | null>(null);
  references = $state.raw<readonly ReferenceSnapshot[]>([]);

  readonly #session: Session;
  readonly #fencePulse: Pulse;
  readonly #preflightPulse: Pulse;
  readonly #referencePulse: Pulse;

  constructor(session: Session) {
    this.#session = session;
    const live = () => session.canCommand;
    // The fences were recorded.
    const heard = () => session.hears;
    const crowd = () => Math.max(1, session.rows.length / FULL_PACE);
    this.#fencePulse = new Pulse(async () => void (this.fences = await getFences()), () => FENCES_EVERY_MS, heard);
    this.#preflightPulse = new Pulse(async () => void (this.preflight = await getPreflight()), () => PREFLIGHT_EVERY_MS * crowd(), live);
    this.#referencePulse = new Pulse(async () => void (this.references = await getReferences()), () => REFERENCES_EVERY_MS, live);
  }

  start(): void {
    this.#fencePulse.start();
    this.#preflightPulse.start();
    this.#session.onEvent((event) => this.#event(event));
    this.#session.onRestart(() => this.#fencePulse.soon());
    this.#session.onLive(() => {
      for (const pulse of [this.#fencePulse, this.#preflightPulse]) pulse.soon();
    });
  }

  /** Asks for the references until the returned function is called. */
  watchReferences(): () => void {
    this.#referencePulse.start();
    return () => this.#referencePulse.stop();
  }

  refreshPreflight(): void {
    this.#preflightPulse.soon();
  }

  #event(event: EventRecord): void {
    switch (event.kind.kind) {
      case 'fences':
        this.#fencePulse.soon();
        this.#preflightPulse.soon();
        break;
      case 'preflight':
      case 'refused':
        this.#preflightPulse.soon();
        break;
    }
  }
}
