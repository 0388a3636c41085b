// Who sits at this page, as other operators see it: the tab is a console with an id of its own, its operator has a name. The name is kept
// in the browser, the id in the tab. Must never let two tabs be one console: each would command what the other has in hand.

import { remember, rememberedText } from '../app/remembered';
import type { Console } from '../protocol/types';

const ID_KEY = 'skein-console';
const NAME_KEY = 'skein-operator';
const ID_BYTES = 16;
/** More the node does not take, of either. */
const MOST_BYTES = 64;

/** What of the browser it needs. */
export type Tab = {
  storage: Pick<Storage, 'getItem' | 'setItem' | 'removeItem'>;
  page: Pick<EventTarget, 'addEventListener'>;
};

/** The id of this tab: the one it had before it was reloaded, or a new one. It lies in the tab's storage only while no page is open in
    it: whoever duplicates the tab or opens a window from it copies that storage, and finds none. A tab that the browser ends without a
    word (a crash, a phone short of memory) is another console when it comes back; what it had can be relieved soon after. */
export function idOf(open: () => Tab, draw: () => string = drawn): string {
  let tab: Tab;
  try {
    tab = open();
  } catch {
    return draw();
  }
  const { storage, page } = tab;
  const guarded = <T>(what: () => T): T | null => {
    try {
      return what();
    } catch {
      // storage can be forbidden or full: then the id does not outlive the page
      return null;
    }
  };
  const take = (): string | null => {
    const found = guarded(() => storage.getItem(ID_KEY));
    guarded(() => storage.removeItem(ID_KEY));
    return found;
  };
  const before = take();
  const id = before !== null && /^[0-9a-f]{32}$/.test(before) ? before : draw();
  page.addEventListener('pagehide', () => guarded(() => storage.setItem(ID_KEY, id)));
  // The browser can keep a page that was left, and show it again as it was.
  page.addEventListener('pageshow', (event) => {
    if ((event as PageTransitionEvent).persisted) take();
  });
  return id;
}

/** Not by `randomUUID`: over plain HTTP there is none. */
function drawn(): string {
  const bytes = crypto.getRandomValues(new Uint8Array(ID_BYTES));
  return [...bytes].map((byte) => byte.toString(16).padStart(2, '0')).join('');
}

/** What the node takes for a name: nothing that cannot be shown, and not too long. Empty if nothing is left. */
export function soundName(text: string): string {
  const encoder = new TextEncoder();
  let name = '';
  let bytes = 0;
  for (const char of text.replace(/\p{Cc}/gu, ' ').trim()) {
    bytes += encoder.encode(char).length;
    if (bytes > MOST_BYTES) break;
    name += char;
  }
  return name.trim();
}

export class Operator {
  readonly id: string;
  /** As it was given by hand; empty if it was not. */
  given = $state('');

  constructor(id = idOf(() => ({ storage: sessionStorage, page: window }))) {
    this.id = id;
    this.given = soundName(rememberedText(NAME_KEY) ?? '');
  }

  get name(): string {
    return this.given === '' ? `Console ${this.id.slice(0, 4)}` : this.given;
  }

  rename(text: string): void {
    this.given = soundName(text);
    remember(NAME_KEY, this.given);
  }

  /** As the node is told. */
  wire(): Console {
    return { id: this.id, name: this.name };
  }
}
