import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import type { LogFetch } from '../../protocol/types';

const rest = vi.hoisted(() => ({ getAutopilotLogs: vi.fn(), fetchAutopilotLog: vi.fn(), getLogFetch: vi.fn() }));
vi.mock('../../protocol/rest', async (original) => ({ ...(await original<object>()), ...rest }));
const { AutopilotLogs } = await import('./autopilotLogs.svelte');
const { ApiError } = await import('../../protocol/rest');

const LOG = { number: 0, size_bytes: 1000, written_unix_s: 100 };
const fetching = (received_bytes: number, end: LogFetch['end'] = null): { fetch: LogFetch } => ({ fetch: { log: LOG, received_bytes, end } });
const DONE = fetching(1000, { end: 'fetched', file: 'a.ulg' });

beforeEach(() => {
  vi.useFakeTimers();
  vi.stubGlobal('document', { hidden: false });
  rest.getLogFetch.mockResolvedValue({ fetch: null });
  rest.getAutopilotLogs.mockResolvedValue({ logs: [LOG] });
});
afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
  vi.resetAllMocks();
});

const seconds = (count: number): Promise<unknown> => vi.advanceTimersByTimeAsync(count * 1000);

describe('the logs of the vehicle whose page is open', () => {
  it('are listed, and nothing more is asked while none is fetched', async () => {
    const logs = new AutopilotLogs(1);
    await logs.load();
    await seconds(10);
    expect([logs.list, logs.fetch, logs.error, logs.asking]).toEqual([[LOG], null, null, false]);
    expect([rest.getLogFetch.mock.calls.length, rest.getAutopilotLogs.mock.calls.length]).toEqual([1, 1]);
  });

  it('one is fetched: how far it has come is asked once a second, until it has ended', async () => {
    const logs = new AutopilotLogs(1);
    await logs.load();
    rest.fetchAutopilotLog.mockResolvedValue(fetching(0).fetch);
    rest.getLogFetch.mockResolvedValueOnce(fetching(400)).mockRejectedValueOnce(new ApiError(0, 'timeout', '')).mockResolvedValueOnce(DONE);
    await logs.begin(0);
    expect(rest.fetchAutopilotLog).toHaveBeenCalledExactlyOnceWith(1, 0);
    await seconds(1.1);
    expect(logs.fetch?.received_bytes).toBe(400);
    await seconds(10);
    expect(logs.fetch).toEqual(DONE.fetch);
    expect([rest.getLogFetch.mock.calls.length, rest.getAutopilotLogs.mock.calls.length]).toEqual([4, 1]);
  });

  it('where one was on its way already, it is shown, and the list is asked for after it', async () => {
    rest.getLogFetch.mockResolvedValueOnce(fetching(10)).mockResolvedValueOnce(fetching(20)).mockResolvedValue(DONE);
    const logs = new AutopilotLogs(1);
    await logs.load();
    expect([logs.fetch?.received_bytes, logs.list, rest.getAutopilotLogs.mock.calls.length]).toEqual([10, null, 0]);
    await seconds(3);
    expect([logs.fetch, logs.list]).toEqual([DONE.fetch, [LOG]]);
  });

  it('where another console was first, that is said and its log is shown', async () => {
    const logs = new AutopilotLogs(1);
    await logs.load();
    rest.fetchAutopilotLog.mockRejectedValue(new ApiError(403, 'not_permitted', 'a log of it is being fetched'));
    rest.getLogFetch.mockResolvedValueOnce(fetching(30)).mockResolvedValue(DONE);
    await logs.begin(0);
    expect([logs.error?.code, logs.fetch?.received_bytes]).toEqual(['not_permitted', 30]);
    await seconds(2);
    expect([logs.error, logs.fetch]).toEqual([null, DONE.fetch]);
  });

  it('nothing is asked when the page is closed, or not in sight', async () => {
    rest.getLogFetch.mockResolvedValue(fetching(10));
    const logs = new AutopilotLogs(1);
    await logs.look();
    vi.stubGlobal('document', { hidden: true });
    await seconds(5);
    expect(rest.getLogFetch).toHaveBeenCalledTimes(1);
    vi.stubGlobal('document', { hidden: false });
    await seconds(1);
    expect(rest.getLogFetch).toHaveBeenCalledTimes(2);
    logs.close();
    await seconds(5);
    expect(rest.getLogFetch).toHaveBeenCalledTimes(2);
  });
});
