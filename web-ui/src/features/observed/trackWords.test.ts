import { afterEach, describe, expect, it } from 'vitest';
import { units } from '../../language/units.svelte';
import type { ObserverProposal } from '../../protocol/types';
import { ApiError } from '../../protocol/rest';
import { classLines, knownText, positionText, proposalText, signText, trackName, velocityText, whyText } from './trackWords';

const velocity = (north_m_s: number, east_m_s: number, down_m_s: number) => ({ north_m_s, east_m_s, down_m_s });

describe('a track in words', () => {
  it('is called by its name or its number, and by its class beside that', () => {
    expect(trackName({ name: '', track: 1000001 })).toBe('Track 1000001');
    expect(signText({ name: '', track: 7, class: '' })).toBe('Track 7');
    expect(signText({ name: 'Ghost', track: 7, class: 'bird' })).toBe('Ghost bird');
  });

  it('may be several things, the likeliest first', () => {
    expect(classLines({ class: 'bird', classes: { drone: 0.2, bird: 0.7, boat: 0.004 } })).toEqual([{ word: 'bird', share: 0.7 }, { word: 'drone', share: 0.2 }]);
    expect(classLines({ class: 'drone', classes: {} })).toEqual([{ word: 'drone', share: null }]);
    expect(classLines({ class: '', classes: {} })).toEqual([]);
  });

  it('is at a place and goes somewhere', () => {
    expect(positionText({ north_m: 12, east_m: -5.25, down_m: -20 })).toBe('12.0 m N, 5.3 m W, height 20.0 m');
    expect(velocityText(velocity(3, 3, -1))).toBe('4.2 m/s to 045°, climbs 1.0 m/s');
    expect(velocityText(velocity(-2, -0.001, 0.5))).toBe('2.0 m/s to 180°, descends 0.5 m/s');
    expect(velocityText(velocity(5, -0.001, 0))).toBe('5.0 m/s to 000°');
    expect(velocityText(velocity(0.1, 0, 0))).toBe('0.1 m/s');
  });

  it('is known to two standard deviations, and says where its range is guessed', () => {
    expect(knownText({ covariance_m2: [9, 0, 0, 4, 0, 25], guessed_range: false })).toBe('± 6.00 m, height ± 10.0 m');
    expect(knownText({ covariance_m2: [9, 0, 0, 4, 0, 25], guessed_range: true })).toContain('range only guessed');
    expect(knownText({ covariance_m2: null, guessed_range: false })).toBe('nobody says');
  });
});

describe('why something was not done', () => {
  it('is the reason that the node gives, or what was wrong with the call', () => {
    const only = 'tracks that this swarm makes are only shown here';
    expect(whyText(new ApiError(409, 'not_permitted', `not permitted: ${only}`, { reason: 'not_permitted', detail: only }))).toBe(only);
    expect(whyText(new ApiError(404, 'unknown_track', 'x', { reason: 'unknown_track', track: 7 }))).toBe('there is no track 7');
    expect(whyText(new ApiError(0, 'timeout', 'no answer from the server'))).toBe('no answer from the server');
    expect(whyText(new TypeError('odd'))).toBe('odd');
  });
});

describe('who could observe it', () => {
  const one: ObserverProposal = { vehicle: 2, score: 0.8, distance_m: 120, battery: 0.85, flies: true, gimbal_camera: true, busy: null, unfit: null };
  afterEach(() => units.choose('metric'));

  it('says why', () => {
    expect(proposalText(one)).toBe('120 m away, 85 % charge, in the air, camera on a gimbal, not busy');
    expect(proposalText({ ...one, distance_m: null, battery: null, flies: false, gimbal_camera: false, busy: 'observes track 9' })).toBe(
      'place not known, charge not known, on the ground, no camera on a gimbal, observes track 9',
    );
  });

  it('... in the units of the page', () => {
    units.choose('aviation');
    expect(proposalText(one)).toContain('394 ft away');
  });
});
