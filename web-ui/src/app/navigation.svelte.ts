// Which panel is before the eyes, on wide screens and on narrow ones. Anything of the page may ask for another.

export type Plan = 'formation' | 'route' | 'preflight' | 'fences' | 'payloads';
export type Record = 'events' | 'commands';
export type Side = 'fleet' | Plan | Record;

export class Navigation {
  plan = $state<Plan>('formation');
  record = $state<Record>('events');
  side = $state<Side>('fleet');

  showPlan(plan: Plan): void {
    this.plan = this.side = plan;
  }

  showRecord(record: Record): void {
    this.record = this.side = record;
  }
}
