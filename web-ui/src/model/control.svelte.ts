// Who has control authority over which vehicle, for the screen, and what this console does about it: take, ask for, let go, hand over. What came of it is
// told in the journal; so is who asks, and who has taken what was ours.
// Must never do any of it by itself, nor keep a command from being sent.

import { SvelteSet } from 'svelte/reactivity';
import { ApiError, changeControl } from '../protocol/rest';
import type { ControlAction } from '../protocol/types';
import { t } from '../language/language.svelte';
import { askingFor, divide, authorityOf, refusalsText } from './authority';
import type { Asking, Division, Authority } from './authority';
import { idRanges } from './idRanges';
import type { Journal } from './journal.svelte';
import type { Operator } from './operator.svelte';
import type { Session } from './session.svelte';

/** What is read of the session. */
export type Source = Pick<Session, 'control' | 'onControl' | 'onRestart'>;

export type ControlOutcome = { text: string; at: number };

/** What is said when it was done, and when it was not. */
type Words = { done: (who: string) => string; not: string };

export class Control {
  /** Anybody has control authority: where nobody has, nothing is said of authority. */
  inUse = $derived.by(() => this.#source.control.size > 0);
  /** Who asks for what is ours, without those who were told "not now". */
  asking = $derived.by(() => askingFor(this.#source.control.values(), this.operator.wire(), this.#declined));
  /** Every vehicle that is ours. */
  mine = $derived.by(() => [...this.#source.control.values()].filter(({ console }) => console.id === this.operator.id).map(({ vehicle }) => vehicle));
  /** What went wrong last; null after what went well. */
  outcome = $state.raw<ControlOutcome | null>(null);

  readonly #source: Source;
  readonly #journal: Journal;
  readonly #declined = new SvelteSet<string>();
  /** By the id of who asks: the alert that says so, and the requests it speaks of. */
  readonly #alerts = new Map<string, { key: string; about: ReadonlySet<string> }>();
  #wasMine = new Set<number>();
  /** Let go or handed over by hand: no surprise if another one has it. */
  readonly #given = new Set<number>();
  /** Asked for, and not had yet. */
  readonly #wanted = new Set<number>();
  #busy = false;

  constructor(
    source: Source,
    journal: Journal,
    readonly operator: Operator,
  ) {
    this.#source = source;
    this.#journal = journal;
    source.onControl(() => this.#look());
    source.onRestart(() => {
      for (const one of [this.#wasMine, this.#given, this.#wanted]) one.clear();
      this.#tellRequests();
    });
  }

  of(id: number): Authority {
    return authorityOf(this.#source.control.get(id), this.operator.wire());
  }

  divide(ids: readonly number[]): Division {
    return divide(ids, (id) => this.of(id));
  }

  /** The name of who will keep this vehicle from our commands; empty if nobody will. */
  heldBy(id: number): string {
    const authority = this.of(id);
    return authority.whose === 'others' && authority.heard ? authority.name : '';
  }

  async take(ids: readonly number[]): Promise<void> {
    await this.#change(ids, { action: 'take' }, { done: (who) => t('Control taken: {who}', { who }), not: t('Control not taken') });
  }

  async request(ids: readonly number[]): Promise<void> {
    if (this.#busy) return;
    for (const id of ids) this.#wanted.add(id);
    const refused = await this.#change(ids, { action: 'request' }, { done: (who) => t('Asked for: {who}', { who }), not: t('Not asked for') });
    for (const id of refused) this.#wanted.delete(id);
  }

  async release(ids: readonly number[]): Promise<void> {
    await this.#give(ids, { action: 'release' }, { done: (who) => t('Let go: {who}', { who }), not: t('Not let go') });
  }

  async handOver({ console, name, vehicles, keys }: Asking): Promise<void> {
    const refused = await this.#give(vehicles, { action: 'hand_over', to: console.id }, { done: (who) => t('Handed over to {name}: {who}', { name, who }), not: t('Not handed over') });
    // What is done is not asked for any more, also until the stream says so.
    vehicles.forEach((id, k) => {
      if (!refused.includes(id)) this.#declined.add(keys[k] ?? '');
    });
    this.#tellRequests();
  }

  /** These requests are not shown any more. Who asks is not told; asking again later is another request. */
  notNow({ keys }: Asking): void {
    for (const key of keys) this.#declined.add(key);
    this.#tellRequests();
  }

  /** The operator is called otherwise from now on, also where vehicles are under its control already. */
  async rename(name: string): Promise<void> {
    const before = this.operator.name;
    this.operator.rename(name);
    if (this.operator.name === before || this.mine.length === 0) return;
    try {
      await changeControl(this.mine, this.operator.wire(), { action: 'take' });
    } catch {
      // others see the former name until vehicles are taken again
    }
  }

  async #give(ids: readonly number[], action: ControlAction, words: Words): Promise<number[]> {
    if (this.#busy) return [...ids];
    // Before it is sent: the stream may be quicker than the answer.
    for (const id of ids) this.#given.add(id);
    const refused = await this.#change(ids, action, words);
    for (const id of refused) this.#given.delete(id);
    return refused;
  }

  /** Does it and tells what came of it. Gives those of which it is not certain that it was done. */
  async #change(ids: readonly number[], action: ControlAction, words: Words): Promise<number[]> {
    if (this.#busy || ids.length === 0) return [...ids];
    this.#busy = true;
    this.outcome = null;
    try {
      const receipts = await changeControl(ids, this.operator.wire(), action);
      const refused = receipts.filter(({ refusal }) => refusal !== null).map(({ vehicle }) => vehicle);
      const done = receipts.filter(({ refusal }) => refusal === null).map(({ vehicle }) => vehicle);
      if (done.length > 0) this.#journal.notice('info', 'control', words.done(idRanges(done)));
      if (refused.length > 0) this.#fail('advisory', `${words.not}: ${idRanges(refused)}: ${refusalsText(receipts)}`);
      return refused;
    } catch (error) {
      this.#fail('warning', `${words.not}: ${idRanges(ids)}: ${error instanceof ApiError ? error.message : String(error)}`);
      return [...ids];
    } finally {
      this.#busy = false;
    }
  }

  #fail(severity: 'advisory' | 'warning', text: string): void {
    this.outcome = { text, at: performance.now() };
    this.#journal.notice(severity, 'control', text);
  }

  /** The node has said anew who has what. */
  #look(): void {
    const mine = new Set(this.mine);
    const taken = [...this.#wasMine].filter((id) => !this.#given.has(id) && this.of(id).whose === 'others');
    for (const name of new Set(taken.map((id) => this.of(id).name))) {
      const who = idRanges(taken.filter((id) => this.of(id).name === name));
      this.#journal.notice('warning', 'control', t('{name} has taken over: {who}', { name, who }));
    }
    const got = [...this.#wanted].filter((id) => mine.has(id));
    if (got.length > 0) this.#journal.notice('info', 'control', t('Under your control now: {who}', { who: idRanges(got.sort((a, b) => a - b)) }));
    for (const id of got) this.#wanted.delete(id);
    for (const id of this.#given) if (!mine.has(id)) this.#given.delete(id);
    this.#wasMine = mine;
    this.#tellRequests();
  }

  /** An alert for everybody who asks, as long as they do. */
  #tellRequests(): void {
    const asking = this.asking;
    for (const { console, name, vehicles, keys } of asking) {
      const told = this.#alerts.get(console.id);
      if (told && keys.every((key) => told.about.has(key))) continue;
      if (told) this.#journal.acknowledge(told.key);
      const text = t('{name} asks for {who}', { name, who: idRanges(vehicles) });
      this.#alerts.set(console.id, { key: this.#journal.notice('warning', 'control', text), about: new Set(keys) });
    }
    for (const [id, told] of this.#alerts) {
      if (asking.some(({ console }) => console.id === id)) continue;
      this.#journal.acknowledge(told.key);
      this.#alerts.delete(id);
    }
  }
}
