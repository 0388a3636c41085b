// What the page keeps of video: which streams there are, which is large, which is in the corner, on which way; over a reload too.

import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import type { VideoStreamView } from '../protocol/video';
import { Video } from './video.svelte';

const kept = new Map<string, string>();
let listed: Partial<VideoStreamView>[] = [];
let asked: string[] = [];

beforeEach(() => {
  kept.clear();
  asked = [];
  listed = [{ vehicle: 5, payload: 'camera' }, { vehicle: 2, payload: 'nose' }, { vehicle: 2, payload: 'camera' }];
  vi.stubGlobal('localStorage', { getItem: (key: string) => kept.get(key) ?? null, setItem: (key: string, value: string) => kept.set(key, value) });
  vi.stubGlobal('document', { hidden: false, baseURI: 'http://test/' });
  vi.stubGlobal('fetch', (url: URL, { method }: { method: string }) => {
    asked.push(`${method} ${url.pathname}`);
    return Promise.resolve(Response.json(url.pathname.endsWith('/recordings') ? { recordings: [{ vehicle: 2, payload: 'camera', running: true, file: 'a.mp4' }] } : { streams: listed }));
  });
  vi.useFakeTimers({ toFake: ['setTimeout', 'clearTimeout'] });
});
afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

const answered = () => vi.advanceTimersByTimeAsync(10);

describe('the streams', () => {
  it('are asked for once a second while somebody looks, whoever it is', async () => {
    const video = new Video();
    const [first, second] = [video.watch(), video.watch()];
    await answered();
    expect(video.streams.map(({ vehicle, payload }) => `${vehicle} ${payload}`)).toEqual(['2 camera', '2 nose', '5 camera']);
    first();
    await vi.advanceTimersByTimeAsync(2500);
    expect(asked).toHaveLength(3);
    second();
    await vi.advanceTimersByTimeAsync(5000);
    expect(asked).toHaveLength(3);
  });

  it('are those of before while no answer comes, and why is said', async () => {
    const video = new Video();
    const end = video.watch();
    await answered();
    vi.stubGlobal('fetch', () => Promise.reject(new Error('refused')));
    await vi.advanceTimersByTimeAsync(1500);
    end();
    expect(video.streams).toHaveLength(3);
    expect(video.problem).toBe('the server cannot be reached');
  });
});

describe('the large one', () => {
  it('is the chosen one while it is there, else the first', async () => {
    const video = new Video();
    expect(video.large).toBeNull();
    const end = video.watch();
    await answered();
    expect(video.large).toMatchObject({ vehicle: 2, payload: 'camera' });
    video.showLarge({ vehicle: 5, payload: 'camera' });
    expect(video.large).toMatchObject({ vehicle: 5 });
    expect(video.layout).toBe('large');
    listed = [{ vehicle: 2, payload: 'nose' }];
    await vi.advanceTimersByTimeAsync(1500);
    expect(video.large).toMatchObject({ vehicle: 2, payload: 'nose' });
    end();
    // Before the list is there what was chosen is trusted.
    expect(new Video().large).toEqual({ vehicle: 5, payload: 'camera' });
  });

  it('beside the map stays beside the map', () => {
    const video = new Video();
    video.chooseLayout('map');
    video.showLarge({ vehicle: 5, payload: 'camera' });
    expect([video.layout, new Video().layout]).toEqual(['map', 'map']);
  });
});

describe('this browser', () => {
  it('keeps the way, the corner and what is in it', () => {
    const video = new Video();
    expect([video.way, video.layout, video.corner, video.inset]).toEqual(['automatic', 'wall', 'bottom-right', null]);
    video.chooseWay('jpeg');
    video.setCorner('top-left');
    video.setInset({ vehicle: 2, payload: 'camera' });
    const again = new Video();
    expect([again.way, again.corner, again.inset]).toEqual(['jpeg', 'top-left', { vehicle: 2, payload: 'camera' }]);
    again.setInset(null);
    expect(new Video().inset).toBeNull();
  });
});

describe('a recording', () => {
  it('is begun and ended on the node, and looked for at once', async () => {
    const video = new Video();
    const end = video.watchRecordings();
    await answered();
    asked = [];
    const camera = { vehicle: 2, payload: 'camera' };
    await video.record(camera, true);
    await answered();
    await video.record(camera, false);
    expect(asked).toEqual(['POST /api/v1/vehicles/2/payloads/camera/video/recording', 'GET /api/v1/video/recordings', 'DELETE /api/v1/vehicles/2/payloads/camera/video/recording']);
    expect(video.recordingOf(camera)).toMatchObject({ file: 'a.mp4' });
    expect(video.recordingOf({ vehicle: 2, payload: 'nose' })).toBeUndefined();
    end();
  });
});
