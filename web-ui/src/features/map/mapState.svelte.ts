// What the map's controls and other panels share: view, camera, tool, layers. The drawing itself is outside of the framework.

import { View, include, isEmpty, noBounds } from './view';

/** Keeps all vehicles in view, keeps the targets centred, or stays where the operator put it. */
export type Camera = 'fleet' | 'follow' | 'free';
export type Tool = 'pan' | 'box' | 'route' | 'path' | 'place';

export class MapState {
  readonly view = new View();
  camera = $state<Camera>('fleet');
  tool = $state<Tool>('pan');
  trails = $state(true);
  /** Where the pointer is, in words; empty when it is elsewhere. */
  cursor = $state('');
  /** Targets that are not on the screen. */
  hiddenTargets = $state(0);
  #wake: () => void = () => {};

  /** The painter says how it wants to be woken. */
  attach(wake: () => void): void {
    this.#wake = wake;
  }

  /** Something that is drawn has changed. */
  invalidate(): void {
    this.#wake();
  }

  setCamera(camera: Camera): void {
    this.camera = camera;
    this.invalidate();
  }

  /** Brings places into view and stays there. */
  show(places: Iterable<{ north: number; east: number }>): void {
    const bounds = noBounds();
    for (const { north, east } of places) include(bounds, north, east);
    if (isEmpty(bounds)) return;
    this.view.fit(bounds, Math.min(this.view.width, this.view.height) * 0.12);
    this.setCamera('free');
  }

  zoom(factor: number): void {
    this.view.zoomAt(this.view.width / 2, this.view.height / 2, factor);
    if (this.camera === 'fleet') this.camera = 'free';
    this.invalidate();
  }
}
