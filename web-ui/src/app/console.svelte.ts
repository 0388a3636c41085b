// Everything the features share, put together once. Components get it through Svelte's context.

import { createContext } from 'svelte';
import { MapState } from '../features/map/mapState.svelte';
import { Observed } from '../features/observed/observed.svelte';
import { AlarmSound } from '../model/alarmSound.svelte';
import { Commander } from '../model/commander.svelte';
import { Control } from '../model/control.svelte';
import { EmergencyStop } from '../model/emergencyStop.svelte';
import { FenceDraft } from '../model/fenceDraft.svelte';
import { Findings } from '../model/findings.svelte';
import { FormationDraft } from '../model/formationDraft.svelte';
import { GoTo } from '../model/goTo.svelte';
import { HandFlight } from '../model/handFlight.svelte';
import { History } from '../model/history';
import { Journal } from '../model/journal.svelte';
import { Operator } from '../model/operator.svelte';
import { Presence } from '../model/presence.svelte';
import { Session } from '../model/session.svelte';
import { Shortcuts } from '../model/shortcuts.svelte';
import { Targets } from '../model/targets.svelte';
import { Video } from '../model/video.svelte';
import { Watch } from '../model/watch.svelte';
import { callAs } from '../protocol/rest';
import { Navigation } from './navigation.svelte';
import { Theme } from './theme.svelte';

export class Console {
  readonly theme = new Theme();
  readonly journal = new Journal();
  readonly commander = new Commander();
  readonly operator = new Operator();
  readonly session = new Session(this.commander, this.journal, this.operator.id);
  readonly control = new Control(this.session, this.journal, this.operator);
  readonly targets = new Targets(() => this.session.rows);
  readonly watch = new Watch(this.session);
  readonly emergency = new EmergencyStop(this.journal);
  readonly formation = new FormationDraft(this.session, this.targets, this.journal, () => this.watch.references);
  readonly fence = new FenceDraft();
  readonly goTo = new GoTo(this.session, this.targets, this.commander);
  readonly hand = new HandFlight(this.session, this.commander, this.control);
  readonly presence = new Presence(this.session);
  readonly navigation = new Navigation();
  readonly map = new MapState();
  readonly observed = new Observed(() => this.session.hears && this.map.layers.cameras, () => this.map.invalidate());
  readonly tracks = this.session.tracks;
  readonly video = new Video();
  readonly findings = new Findings(() => this.session.canCommand && this.video.boxes);
  readonly history = new History();
  readonly shortcuts = new Shortcuts();
  readonly sound = new AlarmSound(() => this.journal.outstanding, () => this.session.replay.on);

  constructor() {
    callAs(this.operator.id);
    this.session.onFrame(() => this.history.take(this.session.fleet, (index) => this.session.rowAt(index)?.heightM ?? NaN, this.session.shownNowMs(), performance.now()));
    this.session.onRestart((sameVehicles) => {
      this.history.clear();
      if (sameVehicles) return;
      // A vehicle of the new run with the same number need not be the same vehicle.
      this.targets.clear();
      this.tracks.selected = null;
      this.emergency.restart();
      this.formation.restart();
      if (this.map.followed !== null) this.map.setCamera('free');
    });
  }
}

export const [useConsole, provideConsole] = createContext<Console>();
