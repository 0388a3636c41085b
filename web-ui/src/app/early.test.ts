// When the stream is opened before the page: with the last but one of its files, once, and not when the page was sooner. The browser's
// observer, socket and document are stood in for.

import { afterEach, beforeEach, expect, it, vi } from 'vitest';

const FILES = 4;
const sockets: string[] = [];
let report: (count: number) => void;
let watching: boolean;

beforeEach(() => {
  sockets.length = 0;
  watching = false;
  vi.resetModules();
  vi.useFakeTimers();
  vi.stubGlobal('document', { baseURI: 'http://127.0.0.1:8080/', documentElement: {}, querySelectorAll: () => ({ length: FILES }) });
  vi.stubGlobal('navigator', { languages: ['en'] });
  vi.stubGlobal(
    'PerformanceObserver',
    class {
      constructor(heard: (list: { getEntriesByType: () => unknown[] }) => void) {
        report = (count) => watching && heard({ getEntriesByType: () => Array(count).fill({}) });
      }
      observe(): void {
        watching = true;
      }
      disconnect(): void {
        watching = false;
      }
    },
  );
  vi.stubGlobal(
    'WebSocket',
    class {
      static readonly OPEN = 1;
      readyState = 1;
      constructor(url: string) {
        sockets.push(url);
      }
      close(): void {}
    },
  );
});

afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

it('opens the stream when all but the last file has come, and once', async () => {
  await import('./early');
  report(FILES - 2);
  expect(sockets).toEqual([]);
  report(1);
  expect(sockets).toHaveLength(1);
  expect(sockets[0]).toMatch(/^ws:\/\/127\.0\.0\.1:8080\/api\/v1\/stream\?console=[0-9a-f]{32}$/);
  report(1);
  expect(sockets).toHaveLength(1);
});

it('opens it at once where the files were all there', async () => {
  await import('./early');
  report(FILES + 3);
  expect(sockets).toHaveLength(1);
});

it('leaves it to the page where that has asked before', async () => {
  await import('./early');
  const { takeEarly } = await import('../protocol/early');
  expect(takeEarly('ws://127.0.0.1:8080/api/v1/stream')).toBeNull();
  report(FILES);
  expect(sockets).toEqual([]);
});
