// Sends commands and keeps their life cycle for the screen. Must never retry or repeat a command by itself.

import { ApiError, sendCommand } from '../protocol/rest';
import type { CommandReceipt, EventRecord, Targets, VehicleCommand } from '../protocol/types';
import { EMPTY, latestOf, reduce } from './commandLedger';
import type { Action, Batch, Entry } from './commandLedger';

export class Commander {
  ledger = $state.raw(EMPTY);
  /** Newest command per vehicle, for the cards. */
  latest = $derived.by(() => {
    const map = new Map<number, { batch: Batch; entry: Entry }>();
    for (const batch of this.ledger.batches) {
      if (batch.former) continue;
      for (const entry of batch.entries) {
        if (!map.has(entry.vehicle)) map.set(entry.vehicle, { batch, entry });
      }
    }
    return map;
  });
  #nextKey = 1;

  dispatch(action: Action): void {
    this.ledger = reduce(this.ledger, action, performance.now());
  }

  /** Sends `command` to `targets`; `vehicles` are the ids it is for, `label` and `detail` the words on the button. */
  async run(command: VehicleCommand, targets: Targets, vehicles: readonly number[], label: string, detail = ''): Promise<void> {
    const key = this.#nextKey++;
    this.dispatch({ type: 'begin', key, label, detail, vehicles });
    try {
      this.dispatch({ type: 'receipts', key, receipts: await sendCommand(targets, command) });
    } catch (error) {
      this.#failed(key, vehicles, error);
    }
  }

  /** Sends each vehicle a command of its own, told as one. Gives the key of the batch when all have answered. */
  async runEach(orders: readonly { vehicle: number; command: VehicleCommand }[], label: string, detail: string): Promise<number> {
    const key = this.#nextKey++;
    this.dispatch({ type: 'begin', key, label, detail, vehicles: orders.map((order) => order.vehicle) });
    const send = async ({ vehicle, command }: (typeof orders)[number]): Promise<CommandReceipt[]> => {
      try {
        return await sendCommand({ vehicles: [vehicle] }, command);
      } catch (error) {
        this.#failed(key, [vehicle], error);
        return [];
      }
    };
    this.dispatch({ type: 'receipts', key, receipts: (await Promise.all(orders.map(send))).flat() });
    return key;
  }

  /** Takes up commands that another call has given, with what each vehicle answered. */
  given(receipts: readonly CommandReceipt[], label: string, detail: string): void {
    const key = this.#nextKey++;
    this.dispatch({ type: 'begin', key, label, detail, vehicles: receipts.map((receipt) => receipt.vehicle) });
    this.dispatch({ type: 'receipts', key, receipts: [...receipts] });
  }

  #failed(key: number, vehicles: readonly number[], error: unknown): void {
    const known = error instanceof ApiError;
    // An answer says for certain that nothing was done; no answer says nothing.
    this.dispatch({ type: 'failed', key, vehicles, certain: known && error.status > 0, message: known ? error.message : String(error) });
  }

  takeEvent(event: EventRecord): void {
    if (event.kind.kind !== 'command' || event.vehicle === null) return;
    this.dispatch({ type: 'progress', id: event.kind.id, vehicle: event.vehicle, progress: event.kind.progress });
  }

  latestOf(vehicle: number): { batch: Batch; entry: Entry } | null {
    return latestOf(this.ledger, vehicle);
  }
}
