// German, put together from the parts of the page. Fetched only where it is wanted.

import { always } from './de/always';
import { fleet } from './de/fleet';
import { flights } from './de/flights';
import { hand } from './de/hand';
import { logs } from './de/logs';
import { machinery } from './de/machinery';
import { observed } from './de/observed';
import { operators } from './de/operators';
import { parameters } from './de/parameters';
import { plans } from './de/plans';
import { video } from './de/video';
import { words } from './de/words';

export { codes } from './de/codes';
export const parts = { always, fleet, flights, hand, logs, machinery, observed, operators, parameters, plans, video, words };
export const de = { ...always, ...fleet, ...flights, ...hand, ...logs, ...machinery, ...observed, ...operators, ...parameters, ...plans, ...video, ...words };
export type Dictionary = typeof de;
