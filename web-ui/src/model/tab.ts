// The id of this tab, which is a console to the node. Kept in the tab; of no framework, since it is wanted before the page is there.
// Must never let two tabs be one console: each would command what the other has control authority over.

const ID_KEY = 'skein-console';
const ID_BYTES = 16;

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

let own: string | null = null;

/** The id of this tab, drawn or found once. */
export function tabId(): string {
  own ??= idOf(() => ({ storage: sessionStorage, page: window }));
  return own;
}
