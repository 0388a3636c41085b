// When the lowest part of the map is drawn, and when its picture is laid down again.

import { beforeEach, describe, expect, it } from 'vitest';
import { KEPT_MS, Underlay } from './underlay';
import { View } from './view';

type Canvas = { width: number; height: number; laid: unknown[][]; getContext(): unknown };

function canvas(): Canvas {
  const one: Canvas = { width: 0, height: 0, laid: [], getContext: () => context };
  const context = { setTransform: () => {}, save: () => {}, restore: () => {}, drawImage: (...args: unknown[]) => one.laid.push(args) };
  return one;
}

let [own, shown] = [canvas(), canvas()];
let underlay: Underlay;
let view: View;
let drawnOn: unknown[];

beforeEach(() => {
  [own, shown] = [canvas(), canvas()];
  underlay = new Underlay(own as unknown as HTMLCanvasElement);
  view = new View();
  [view.width, view.height] = [300, 200];
  drawnOn = [];
});

function lay(now: number, ratio = 2): void {
  underlay.lay(shown.getContext() as CanvasRenderingContext2D, view, ratio, now, (ctx) => drawnOn.push(ctx));
}

describe('the lowest part', () => {
  it('is drawn straight onto the map while the view is under way', () => {
    for (let k = 0; k < 5; k++) {
      view.panBy(3, 0);
      lay(k * 16);
    }
    expect(drawnOn).toEqual(Array(5).fill(shown.getContext()));
    expect(shown.laid).toEqual([]);
    expect(own.width).toBe(0);
  });

  it('is drawn once and laid down from then on while the view stands', () => {
    for (let k = 0; k < 6; k++) lay(k * 50);
    expect(drawnOn).toEqual([shown.getContext(), own.getContext()]);
    expect([own.width, own.height]).toEqual([600, 400]);
    expect(shown.laid).toEqual(Array(5).fill([own, 0, 0]));
  });

  it('is drawn anew when its picture is old, or not true any more', () => {
    lay(0);
    lay(50);
    lay(50 + KEPT_MS - 1);
    expect(drawnOn.length).toBe(2);
    lay(50 + KEPT_MS);
    expect(drawnOn.length).toBe(3);
    underlay.forget();
    lay(60 + KEPT_MS);
    expect(drawnOn.length).toBe(4);
    lay(70 + KEPT_MS);
    expect(drawnOn.length).toBe(4);
  });

  it.each([
    ['place', () => view.panBy(0, 1)],
    ['scale', () => view.zoomAt(0, 0, 1.1)],
    ['size', () => void (view.width = 310)],
  ])('is never that of another %s', (_, change) => {
    lay(0);
    lay(10);
    change();
    lay(20);
    expect(shown.laid.length).toBe(1);
    expect(drawnOn.at(-1)).toBe(shown.getContext());
    lay(30);
    expect(drawnOn.length).toBe(4);
    expect(own.width).toBe(view.width * 2);
  });

  it('is never that of a screen with other pixels', () => {
    lay(0);
    lay(10);
    lay(20, 1);
    lay(30, 1);
    expect(own.width).toBe(300);
    expect(shown.laid.length).toBe(2);
  });
});
