// What the map's controls and other panels share: view, camera, tool, layers. The drawing itself is outside of the framework.

import type { BaseMap } from '../basemap/pictures';
import { World } from '../basemap/world';
import { MeasureDraft } from '../measure/measureDraft.svelte';
import { keepChoice, loadChoice } from './layers';
import type { Layer, LayerChoice } from './layers';
import { View, include, isEmpty, noBounds } from './view';

/** Keeps all vehicles in view, keeps some centred, or stays where the operator put it. */
export type Camera = 'fleet' | 'follow' | 'free';
export type Tool = 'pan' | 'box' | 'route' | 'path' | 'place' | 'measure' | 'goto' | 'fence';
/** Seen from above, or in space. */
export type Look = 'flat' | 'space';

/** What the view in space lets the map's tools do. */
export type SpaceControls = { zoom(factor: number): void; fit(): void; wake(): void };

export class MapState {
  readonly view = new View();
  readonly measure = new MeasureDraft();
  camera = $state<Camera>('fleet');
  tool = $state<Tool>('pan');
  look = $state<Look>('flat');
  layers = $state<LayerChoice>(loadChoice());
  /** The operator's own ground; kept as long as the page is open. */
  base = $state.raw<BaseMap | null>(null);
  readonly world = new World(() => this.invalidate());
  /** The one vehicle that the camera follows; null: the targets or the leader. */
  followed = $state<number | null>(null);
  /** Where the pointer is, in words; empty when it is elsewhere. */
  cursor = $state('');
  #wake: () => void = () => {};
  #space: SpaceControls | null = null;

  /** The painter says how it wants to be woken. */
  attach(wake: () => void): void {
    this.#wake = wake;
  }

  /** The view in space is there, or gone with null. */
  attachSpace(space: SpaceControls | null): void {
    this.#space = space;
  }

  /** Something that is drawn has changed. */
  invalidate(): void {
    this.#wake();
    this.#space?.wake();
  }

  setCamera(camera: Camera): void {
    this.camera = camera;
    if (camera !== 'follow') this.followed = null;
    this.invalidate();
  }

  /** Keeps one vehicle in the middle, whatever the targets are. */
  follow(id: number): void {
    this.followed = id;
    this.camera = 'follow';
    this.invalidate();
  }

  setLayer(layer: Layer, shown: boolean): void {
    this.layers[layer] = shown;
    keepChoice(this.layers);
    this.invalidate();
  }

  setBase(base: BaseMap | null): void {
    this.base?.close();
    this.base = base;
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
    if (this.#space) {
      this.#space.zoom(factor);
      return;
    }
    this.view.zoomAt(this.view.width / 2, this.view.height / 2, factor);
    if (this.camera === 'fleet') this.camera = 'free';
    this.invalidate();
  }

  /** Brings the fleet into the view in space, where that is what is looked at. */
  fitSpace(): void {
    this.#space?.fit();
  }
}
