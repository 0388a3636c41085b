// What a key does, for the whole page. Must never send a command: a key finds the button, the button is pressed.

import { FOCUSES } from '../model/shortcuts.svelte';
import type { Console } from './console.svelte';

export function obey(event: KeyboardEvent, app: Console): void {
  const typing = event.target instanceof HTMLElement && event.target.matches('input, select, textarea');
  if (event.key === 'Escape') leave(app, typing);
  else if (!typing) {
    const keys = app.shortcuts.keys.press(event, performance.now());
    if (keys === null) return;
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
  switch (keys) {
    case 'g m':
      return navigation.show('map');
    case 'g f':
      return navigation.show('fleet');
    case 'g c':
      return navigation.show('preflight');
    case 'g a':
      return navigation.show('alerts');
    case 'g p':
      return navigation.show('plugins');
    case 'k':
      return step(app, -1);
    case 'j':
      return step(app, 1);
    case '/':
      return find(app);
    case 's':
      return void app.sound.toggle();
    case '?':
      app.shortcuts.shown = !app.shortcuts.shown;
      return;
    default:
      document.querySelector<HTMLElement>(`[data-verb="${FOCUSES[keys] ?? ''}"]`)?.focus();
  }
}

/** The page of the next vehicle by number. */
function step(app: Console, by: 1 | -1): void {
  const ids = app.session.rows.map((row) => row.id);
  const at = ids.indexOf(app.navigation.vehicle ?? -1);
  const id = ids[at < 0 ? 0 : (at + by + ids.length) % ids.length];
  if (id !== undefined) app.navigation.showVehicle(id);
}

function find(app: Console): void {
  app.navigation.side = 'fleet';
  const focus = (): boolean => {
    const field = document.getElementById('fleet-search');
    field?.focus();
    return field !== null;
  };
  // The field may be on a page that is not open: then it is opened first.
  queueMicrotask(() => {
    if (focus()) return;
    app.navigation.show('fleet');
    setTimeout(focus, 50);
  });
}
