// What a key does, for the whole page. Must never send a command: a key finds the button, the button is pressed.

import { FOCUSES, shortcutsIn } from '../model/shortcuts.svelte';
import { JUMP_S } from '../model/replay.svelte';
import type { Console } from './console.svelte';

export function obey(event: KeyboardEvent, app: Console): void {
  const typing = event.target instanceof HTMLElement && event.target.matches('input, select, textarea');
  if (app.shortcuts.finding) event.preventDefault();
  else if (event.key === 'Escape') leave(app, typing);
  else if (!typing) {
    const keys = app.shortcuts.keys.press(event, performance.now());
    if (keys === null || !shortcutsIn(app.session.replay.on).some((one) => one.keys === keys)) return;
    // On a button it presses the button.
    if (keys === 'Space' && event.target instanceof HTMLElement && event.target.closest('button, a, summary, [role="tab"]')) return;
    event.preventDefault();
    follow(keys, app);
  }
}

function leave(app: Console, typing: boolean): void {
  if (app.emergency.unlocked) app.emergency.lock();
  else if (typing) return;
  else if (app.shortcuts.shown) app.shortcuts.shown = false;
  else if (app.map.tool !== 'pan') app.map.tool = 'pan';
  else app.targets.clear();
}

function follow(keys: string, app: Console): void {
  const { navigation } = app;
  const { replay } = app.session;
  switch (keys) {
    case 'g m':
      return navigation.show('map');
    case 'g f':
      return navigation.show('fleet');
    case 'g v':
      return navigation.show('video');
    case 'g c':
      return navigation.show('preflight');
    case 'g a':
      return navigation.show('alerts');
    case 'g p':
      return navigation.show('plugins');
    case 'g r':
      return navigation.show('flights');
    case 'Space':
      return replay.toggle();
    case ',':
      return replay.step(-JUMP_S);
    case '.':
      return replay.step(JUMP_S);
    case 'b':
      return replay.toMark(-1);
    case 'n':
      return replay.toMark(1);
    case 'k':
      return step(app, -1);
    case 'j':
      return step(app, 1);
    case '/':
      return search(app);
    case 's':
      return void app.sound.toggle();
    case '?':
      app.shortcuts.shown = !app.shortcuts.shown;
      return;
    default:
      return find(FOCUSES[keys] ?? '');
  }
}

/** The page of the next vehicle by number. */
function step(app: Console, by: 1 | -1): void {
  const ids = app.session.rows.map((row) => row.id);
  const at = ids.indexOf(app.navigation.vehicle ?? -1);
  const id = ids[at < 0 ? 0 : (at + by + ids.length) % ids.length];
  if (id !== undefined) app.navigation.showVehicle(id);
}

/** Brings the button of a command into focus. Where it cannot be pressed nothing has the focus: Space must not press the one before. */
function find(verb: string): void {
  const button = document.querySelector<HTMLButtonElement>(`[data-verb="${verb}"]`);
  button?.focus();
  if (document.activeElement !== button && document.activeElement instanceof HTMLElement) document.activeElement.blur();
}

const LOOK_AGAIN_MS = 20;
const LOOKS = 25;

function search(app: Console): void {
  const { navigation, shortcuts } = app;
  navigation.side = 'fleet';
  shortcuts.finding = true;
  const look = (left: number): void => {
    const field = document.getElementById('fleet-search');
    field?.focus();
    // The field may be on a page that is not open: then it is opened first.
    if (!field && left === LOOKS - 1) navigation.show('fleet');
    if (field || left === 0) shortcuts.finding = false;
    else setTimeout(() => look(left - 1), LOOK_AGAIN_MS);
  };
  queueMicrotask(() => look(LOOKS));
}
