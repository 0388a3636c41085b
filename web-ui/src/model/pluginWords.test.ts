import { describe, expect, it } from 'vitest';
import type { ActorHealth, PayloadInfo } from '../protocol/types';
import { pluginSummary } from './pluginWords';

const health = (status: ActorHealth['status']): ActorHealth => ({ name: 'x', status, incarnation: 1, last_error: '', since: 0 });
const payload = (name: string, status: ActorHealth['status']): PayloadInfo => ({
  name, kind: 'camera', plugin: 'camera', version: '1.0.0', isolation: 'in_process', health: health(status), restarts: 0, has_frame: false,
});

describe('the plugins of a vehicle in a few words', () => {
  it('counts them while all run', () => {
    const summary = pluginSummary({ actor: health('running'), model: health('running'), payloads: [payload('camera', 'running')] });
    expect(summary).toEqual({ text: '2 running', level: 0 });
  });

  it('names the worst, and how many more are wrong', () => {
    const payloads = [payload('camera', 'restarting'), payload('gimbal', 'given_up')];
    expect(pluginSummary({ actor: health('running'), model: health('running'), payloads })).toEqual({ text: 'gimbal given up +1', level: 3 });
    expect(pluginSummary({ actor: health('restarting'), model: health('running'), payloads: [] })).toEqual({ text: 'control restarting', level: 2 });
  });

  it('says nothing of a vehicle of which nothing is known', () => {
    expect(pluginSummary(undefined).text).toBe('–');
  });
});
