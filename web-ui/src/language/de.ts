// German, put together from the parts of the page. Fetched only where it is wanted.

import { always } from './de/always';
import { fleet } from './de/fleet';
import { words } from './de/words';

export { codes } from './de/codes';
export const parts = { always, fleet, words };
export const de = { ...always, ...fleet, ...words };
export type Dictionary = typeof de;
