import { describe, expect, it } from 'vitest';
import { ApiError } from '../../protocol/rest';
import type { LogFetch } from '../../protocol/types';
import { errorText, fetchText, isUnderWay, newestFirst, receivedText, shareOf } from './logWords';

const log = (number: number, written_unix_s: number | null = 1_790_000_000, size_bytes = 200_000) => ({ number, size_bytes, written_unix_s });
const fetching = (received_bytes: number, end: LogFetch['end'] = null): LogFetch => ({ log: log(3), received_bytes, end });

describe('the logs of an autopilot', () => {
  it('are listed with the newest first, and those without a time at the end', () => {
    const all = [log(0, null), log(1, 100), log(2, 300), log(3, 100), log(4, null)];
    expect(newestFirst(all).map(({ number }) => number)).toEqual([2, 3, 1, 4, 0]);
    expect(all[0]!.number).toBe(0);
  });
});

describe('a log that is fetched', () => {
  it('is under way until it has ended', () => {
    expect([null, fetching(0), fetching(7, { end: 'fetched', file: 'a.ulg' })].map(isUnderWay)).toEqual([false, true, false]);
  });

  it('says how much of it is there', () => {
    expect([fetching(0), fetching(50_000), fetching(200_000), fetching(300_000)].map(shareOf)).toEqual([0, 0.25, 1, 1]);
    expect(shareOf({ log: log(0, null, 0), received_bytes: 0, end: null })).toBe(1);
    expect(receivedText(fetching(92_160))).toBe('92 kB of 200 kB');
  });

  it('says how it stands and how it ended', () => {
    expect(fetchText(fetching(5))).toBe('Fetching log 3');
    expect(fetchText(fetching(200_000, { end: 'fetched', file: 'a.ulg' }))).toBe('Log 3 was fetched, 200 kB');
    expect(fetchText(fetching(5, { end: 'broken_off', why: 'no answer to a part of the log within 7.2 s' }))).toBe('Log 3 was not fetched: no answer to a part of the log within 7.2 s');
    const armed = 'not permitted: it is armed: logs are listed and fetched on the ground alone';
    expect(fetchText(fetching(5, { end: 'broken_off', why: armed }))).toBe('Log 3 was not fetched: the vehicle was armed');
  });
});

describe('a refusal', () => {
  const refused = (detail: string) => new ApiError(403, 'not_permitted', `not permitted: ${detail}`, { reason: 'not_permitted', detail });

  it('is said in plain words', () => {
    expect(errorText(refused('it is armed: logs are listed and fetched on the ground alone'))).toBe('the vehicle is armed');
    expect(errorText(refused('a log of it is being fetched'))).toBe('another log of it is being fetched');
    expect(errorText(new ApiError(409, 'link_lost', '…', { reason: 'link_lost', vehicle: 4 }))).toBe('the link to vehicle 4 is lost');
  });

  it('that is not known is said as the server says it', () => {
    expect(errorText(refused('there is no folder for recordings (recorder.folder)'))).toBe('not permitted: there is no folder for recordings (recorder.folder)');
    expect(errorText(new ApiError(0, 'unreachable', 'the server cannot be reached'))).toBe('the server cannot be reached');
  });
});
