import { describe, expect, it } from 'vitest';
import type { DetectorState, Finding, PayloadSnapshot } from '../../protocol/types';
import { boxesIn, findingText, fitted, statesOf } from './findingBoxes';

const finding = (change: Partial<Finding> = {}): Finding => ({
  class: 'bird', score: 0.874, center_x_px: 320, center_y_px: 240, width_px: 64, height_px: 48, id: '12', error_px: 0, coasted_s: 0, classes: {}, ...change,
});
const state = (change: Partial<DetectorState> = {}): DetectorState => ({ camera: 'front', time: 50_000_000, width_px: 640, height_px: 480, pose: null, findings: [finding()], ...change });
const payload = (kind: string, name: string, of: unknown = null) => ({ kind, name, state: of }) as PayloadSnapshot;
const NOW_MS = 50_400;

describe('a box', () => {
  it('lies where it was found, in the size that is shown', () => {
    expect(boxesIn(state(), { width: 320, height: 240 })).toEqual([{ x: 144, y: 108, w: 32, h: 24, text: 'bird 87 % 12', coasted: false }]);
  });

  it('leaves out the bars beside or above a picture of other proportions', () => {
    expect(fitted({ width: 640, height: 480 }, { width: 800, height: 480 })).toEqual({ scale: 1, x: 80, y: 0 });
    const [box] = boxesIn(state(), { width: 640, height: 600 });
    expect([box!.x, box!.y]).toEqual([288, 276]);
  });

  it('is only thought to be there where it was not found in this picture', () => {
    expect(boxesIn(state({ findings: [finding({ coasted_s: 0.2, id: '' })] }), { width: 640, height: 480 })[0]).toMatchObject({ coasted: true, text: 'bird 87 %' });
  });

  it.each<[string, Partial<DetectorState>]>([['does not say the size of its picture', { width_px: 0 }], ['says a size of nothing', { height_px: 0 }]])('is not placed if the detector %s', (_, change) => {
    expect(boxesIn(state(change), { width: 640, height: 480 })).toEqual([]);
  });

  it('is left out where it is followed beyond the edge of the picture', () => {
    const beyond = [finding({ center_x_px: -59 }), finding({ center_y_px: 620 }), finding({ center_x_px: 655 })];
    expect(boxesIn(state({ findings: beyond }), { width: 640, height: 480 }).map(({ x }) => x)).toEqual([623]);
  });

  it('says what has no class and no name by its score', () => {
    expect(findingText(finding({ class: '', id: '' }))).toBe('87 %');
  });
});

describe('what a detector says', () => {
  const cameras = [payload('camera', 'front'), payload('camera', 'rear')];
  it('is of the camera that it names', () => {
    const carried = [...cameras, payload('detector', 'detector', state())];
    expect([statesOf(carried, 'front', NOW_MS).length, statesOf(carried, 'rear', NOW_MS).length]).toEqual([1, 0]);
  });

  it('is of the only camera if it names none', () => {
    const unnamed = payload('detector', 'detector', state({ camera: '' }));
    expect([statesOf([cameras[0]!, unnamed], 'front', NOW_MS).length, statesOf([...cameras, unnamed], 'front', NOW_MS).length]).toEqual([1, 0]);
  });

  it('is not drawn when it is older than a second, or no state of a detector', () => {
    const old = payload('detector', 'detector', state());
    expect(statesOf([cameras[0]!, old], 'front', 51_001)).toEqual([]);
    expect(statesOf([cameras[0]!, payload('detector', 'x'), payload('detector', 'y', { frames: 3 })], 'front', NOW_MS)).toEqual([]);
  });
});
