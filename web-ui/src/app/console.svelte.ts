// Everything the features share, put together once. Components get it through Svelte's context.

import { createContext } from 'svelte';
import { MapState } from '../features/map/mapState.svelte';
import { Commander } from '../model/commander.svelte';
import { FormationDraft } from '../model/formationDraft.svelte';
import { Journal } from '../model/journal.svelte';
import { Session } from '../model/session.svelte';
import { Targets } from '../model/targets.svelte';
import { Theme } from './theme.svelte';

export class Console {
  readonly theme = new Theme();
  readonly journal = new Journal();
  readonly commander = new Commander();
  readonly session = new Session(this.commander, this.journal);
  readonly targets = new Targets(() => this.session.rows);
  readonly formation = new FormationDraft(this.session, this.targets, this.journal);
  readonly map = new MapState();
}

export const [useConsole, provideConsole] = createContext<Console>();
