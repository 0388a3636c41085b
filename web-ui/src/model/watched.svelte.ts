// The vehicle whose payloads are looked at: its newest snapshot, asked for a few times a second while the panel is open.
// Must never ask while nobody looks.

import { getVehicle } from '../protocol/rest';
import type { VehicleSnapshot } from '../protocol/types';

const EVERY_MS = 500;

export class Watched {
  vehicle = $state.raw<VehicleSnapshot | null>(null);
  error = $state('');
  /** Counts answers; part of a picture's address, so that the browser asks for the next one. */
  count = $state(0);

  /** Looks at one vehicle until the returned function is called. */
  watch(id: number): () => void {
    let ended = false;
    let timer: ReturnType<typeof setTimeout>;
    this.vehicle = null;
    this.error = '';
    const look = async (): Promise<void> => {
      if (!document.hidden) {
        try {
          const vehicle = await getVehicle(id);
          if (ended) return;
          this.vehicle = vehicle;
          this.error = '';
          this.count++;
        } catch (error) {
          if (!ended) this.error = error instanceof Error ? error.message : String(error);
        }
      }
      if (!ended) timer = setTimeout(() => void look(), EVERY_MS);
    };
    void look();
    return () => {
      ended = true;
      clearTimeout(timer);
    };
  }
}
