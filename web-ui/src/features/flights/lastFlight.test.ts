import { describe, expect, it } from 'vitest';
import { LastFlight } from './lastFlight';

describe('a flight that has ended', () => {
  it('is news when it ends while the page is open, and once', () => {
    const last = new LastFlight();
    expect([null, null, 'a.mcap', 'a.mcap', 'b.mcap'].map((file) => last.take(file))).toEqual([null, null, 'a.mcap', null, 'b.mcap']);
  });

  it('is none where it had ended before', () => {
    const last = new LastFlight();
    expect([last.take('a.mcap'), last.take('a.mcap'), last.take('b.mcap')]).toEqual([null, null, 'b.mcap']);
  });

  it('is none because the node began anew', () => {
    const last = new LastFlight();
    expect(['a.mcap', null, 'a.mcap', null, 'b.mcap'].map((file) => last.take(file))).toEqual([null, null, null, null, 'b.mcap']);
  });
});
