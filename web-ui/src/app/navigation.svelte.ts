// Which page is before the eyes, and which panel beside it. The page stands in the address, so that it can be linked to, opened in a
// second window and gone back from. Anything of the console may ask for another.

export type Plan = 'formation' | 'route' | 'hand' | 'preflight' | 'fences' | 'payloads' | 'tracks' | 'swarm';
export type Record = 'events' | 'commands';
export type Side = 'fleet' | Plan | Record;

/** Room for list, page and plans side by side. */
export const WIDE = '(min-width: 1360px)';

/** What fills the middle of the screen. */
export const PAGES = ['map', 'fleet', 'video', 'preflight', 'alerts', 'plugins', 'links', 'flights'] as const;
export type Page = (typeof PAGES)[number] | 'vehicle' | OfVehicle;

/** What is shown of a vehicle on a page of its own. */
const OF_VEHICLE = ['parameters', 'logs'] as const;
type OfVehicle = (typeof OF_VEHICLE)[number];

/** A page as it stands in the address: `#fleet`, `#vehicle/3`, `#vehicle/3/parameters`, `#vehicle/3/logs`; anything else is the map. */
export function pageOf(hash: string): { page: Page; vehicle: number | null } {
  const text = hash.replace(/^#/, '');
  const [, id, place] = /^vehicle\/(\d{1,5})(?:\/(\w+))?$/.exec(text) ?? [];
  const of = place === undefined ? 'vehicle' : OF_VEHICLE.find((name) => name === place);
  if (id !== undefined && of !== undefined) return { page: of, vehicle: Number(id) };
  const page = PAGES.find((name) => name === text);
  return { page: page ?? 'map', vehicle: null };
}

/** Plans and pages that show something which is recorded. */
const RECORDED_PAGES: readonly Page[] = ['map', 'fleet', 'vehicle', 'alerts'];
export const RECORDED_PLANS: readonly Plan[] = ['fences', 'tracks', 'swarm'];

/** The page that is shown where `page` is asked for: of a recorded flight there are not all. */
export function pageIn(replay: boolean, page: Page): Page {
  if (!replay || RECORDED_PAGES.includes(page)) return page;
  return OF_VEHICLE.some((name) => name === page) ? 'vehicle' : 'map';
}

export class Navigation {
  plan = $state<Plan>('formation');
  record = $state<Record>('events');
  side = $state<Side>('fleet');
  page = $state<Page>('map');
  /** The settings of this browser are open. */
  settings = $state(false);
  /** Whose page is open. */
  vehicle = $state<number | null>(null);

  /** Follows the address from now on. */
  follow(): void {
    const read = (): void => {
      ({ page: this.page, vehicle: this.vehicle } = pageOf(location.hash));
    };
    addEventListener('hashchange', read);
    read();
  }

  show(page: (typeof PAGES)[number]): void {
    location.hash = page;
  }

  showVehicle(id: number): void {
    location.hash = `vehicle/${id}`;
  }

  /** Leaves the panels that a recorded flight does not have. */
  keepToRecorded(): void {
    const isPlan = (side: Side): side is Plan => side !== 'fleet' && side !== 'events' && side !== 'commands';
    if (!RECORDED_PLANS.includes(this.plan)) this.plan = 'fences';
    this.record = 'events';
    if (this.side === 'commands' || (isPlan(this.side) && !RECORDED_PLANS.includes(this.side))) this.side = 'fleet';
  }

  showPlan(plan: Plan): void {
    this.plan = this.side = plan;
    if (!this.#beside()) this.show(plan === 'preflight' ? 'preflight' : 'map');
  }

  showRecord(record: Record): void {
    this.record = this.side = record;
    if (!this.#beside()) this.show('map');
  }

  /** Whether the panels are there: on a narrow screen they stand beside the map alone. */
  #beside(): boolean {
    return this.page === 'map' || matchMedia(WIDE).matches;
  }
}
