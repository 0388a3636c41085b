// Where the stream is. Of no framework, since it is wanted before the page is there.

/** Address of the stream beside the page, whatever prefix the page is served under. That it is open is the console's sign of life. */
export function streamUrl(base: string, console: string): string {
  const url = new URL('api/v1/stream', base);
  url.searchParams.set('console', console);
  url.protocol = url.protocol === 'https:' ? 'wss:' : 'ws:';
  return url.href;
}
