// The stream's socket, opened before what draws the vehicles has come: over a thin link that is a round trip or two sooner. What the server says
// meanwhile is kept, of frames the newest one, until the stream takes it over. Must never be kept by a page that does not come up.

/** A frame or a word of the server, and when it came, on the `performance.now()` clock. */
export type Said = { data: string | ArrayBuffer; at: number };
type Early = { socket: WebSocket; said: Said[] };

/** Few frames meanwhile: the link is wanted for the page itself. */
const RATE_HZ = 1;
/** The server takes an open socket for an operator who is there. */
const UNTAKEN_MS = 30_000;

let early: (Early & { url: string; timer: ReturnType<typeof setTimeout> }) | null = null;

let asked = false;

/** Whether the stream has begun without it: then it is too late for it. */
export function wasAsked(): boolean {
  return asked;
}

export function openEarly(url: string): void {
  const socket = new WebSocket(url);
  socket.binaryType = 'arraybuffer';
  const said: Said[] = [];
  socket.onopen = () => socket.send(JSON.stringify({ type: 'rate', rate_hz: RATE_HZ }));
  socket.onmessage = (message) => {
    const data = message.data as Said['data'];
    const before = typeof data === 'string' ? -1 : said.findIndex((one) => typeof one.data !== 'string');
    if (before >= 0) said.splice(before, 1);
    said.push({ data, at: performance.now() });
  };
  const timer = setTimeout(() => takeEarly(url)?.socket.close(), UNTAKEN_MS);
  early = { socket, said, url, timer };
}

/** Hands the socket over, once; null where there is none to this address, or none any more. */
export function takeEarly(url: string): Early | null {
  asked = true;
  if (early?.url !== url) return null;
  const { socket, said, timer } = early;
  early = null;
  clearTimeout(timer);
  socket.onopen = null;
  socket.onmessage = null;
  return socket.readyState <= WebSocket.OPEN ? { socket, said } : null;
}
