// Draws the view in space with WebGL through three.js. Loaded only when somebody looks at it. Must never hold what the model says beyond
// one picture; it keeps buffers, not data.

import {
  BufferAttribute, BufferGeometry, Color, DoubleSide, DynamicDrawUsage, Euler, Fog, InstancedMesh, LineBasicMaterial, LineSegments, Matrix4,
  Mesh, MeshBasicMaterial, PerspectiveCamera, Quaternion, Scene, ShapeUtils, Vector2, Vector3, WebGLRenderer,
} from 'three';
import type { PlacedZone } from '../../model/fences';
import { levelColour } from '../map/palette';
import type { Palette } from '../map/palette';
import { DART, POSE } from './craft';
import { CRAFT_M, CRAFT_PX, FILL_OPACITY } from './drawer';
import type { Drawer } from './drawer';
import { LINE } from './lineSet';
import type { LineSet } from './lineSet';
import { FIELD_RAD } from './orbit';
import type { Orbit } from './orbit';
import type { SpaceModel } from './spaceModel';

/** One set of lines on the card. */
class Lines {
  readonly object: LineSegments<BufferGeometry, LineBasicMaterial>;
  #points: Float32Array;

  constructor(readonly set: LineSet) {
    this.#points = new Float32Array(set.data.length);
    const material = new LineBasicMaterial({ transparent: true, opacity: set.opacity, depthWrite: false });
    this.object = new LineSegments(new BufferGeometry(), material);
    this.object.frustumCulled = false;
    this.#attach();
  }

  /** East, up, south: the axes of the card. */
  update(): void {
    const { data, count } = this.set;
    if (this.#points.length < data.length) {
      this.#points = new Float32Array(data.length);
      this.object.geometry.dispose();
      this.object.geometry = new BufferGeometry();
      this.#attach();
    }
    this.object.visible = count > 0;
    const p = this.#points;
    for (let at = 0; at < count * LINE; at += 3) {
      p[at] = data[at + 1] ?? 0;
      p[at + 1] = data[at + 2] ?? 0;
      p[at + 2] = -(data[at] ?? 0);
    }
    const attribute = this.object.geometry.getAttribute('position') as BufferAttribute;
    attribute.clearUpdateRanges();
    attribute.addUpdateRange(0, count * LINE);
    attribute.needsUpdate = true;
    this.object.geometry.setDrawRange(0, count * 2);
  }

  #attach(): void {
    this.object.geometry.setAttribute('position', new BufferAttribute(this.#points, 3).setUsage(DynamicDrawUsage));
  }
}

function dart(): BufferGeometry {
  const faces = [
    ['nose', 'right', 'tail', 1], ['nose', 'tail', 'left', 0.86], ['nose', 'keel', 'right', 0.55], ['nose', 'left', 'keel', 0.6],
    ['right', 'keel', 'tail', 0.45], ['left', 'tail', 'keel', 0.5],
  ] as const;
  const points: number[] = [];
  const shades: number[] = [];
  for (const [a, b, c, shade] of faces) {
    for (const corner of [a, b, c]) {
      const [forward, right, up] = DART[corner];
      points.push(right, up, -forward);
      shades.push(shade, shade, shade);
    }
  }
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(new Float32Array(points), 3));
  geometry.setAttribute('color', new BufferAttribute(new Float32Array(shades), 3));
  return geometry;
}

export class WebglDrawer implements Drawer {
  readonly kind = 'webgl';
  readonly #renderer: WebGLRenderer;
  readonly #scene = new Scene();
  readonly #camera = new PerspectiveCamera((FIELD_RAD * 180) / Math.PI, 1, 0.5, 1e5);
  readonly #fog = new Fog(0, 1, 2);
  readonly #dart = dart();
  #lines: Lines[] = [];
  #solid: InstancedMesh<BufferGeometry, MeshBasicMaterial>;
  #hollow: InstancedMesh<BufferGeometry, MeshBasicMaterial>;
  #walls: Mesh<BufferGeometry, MeshBasicMaterial>[] = [];
  #wallsOf: { zones: readonly PlacedZone[]; looks: string } = { zones: [], looks: '' };
  readonly #matrix = new Matrix4();
  readonly #place = new Vector3();
  readonly #turn = new Quaternion();
  readonly #euler = new Euler(0, 0, 0, 'YXZ');
  readonly #size = new Vector3();
  readonly #colour = new Color();

  constructor(canvas: HTMLCanvasElement, context: WebGL2RenderingContext) {
    this.#renderer = new WebGLRenderer({ canvas, context, antialias: true });
    this.#scene.fog = this.#fog;
    this.#solid = this.#darts(64, false);
    this.#hollow = this.#darts(64, true);
  }

  resize(width: number, height: number, ratio: number): void {
    this.#renderer.setPixelRatio(ratio);
    this.#renderer.setSize(width, height, false);
    this.#camera.aspect = width / height;
    this.#camera.updateProjectionMatrix();
  }

  draw(model: SpaceModel, orbit: Orbit, palette: Palette): void {
    if (this.#lines.length === 0) this.#begin(model);
    const eye = orbit.eye();
    this.#camera.position.set(eye.east, eye.up, -eye.north);
    this.#camera.lookAt(orbit.east, orbit.up, -orbit.north);
    this.#camera.near = Math.max(0.3, orbit.distanceM / 300);
    this.#camera.far = orbit.distanceM * 8;
    this.#camera.updateProjectionMatrix();
    this.#renderer.setClearColor(palette.bg);
    this.#fog.color.set(palette.bg);
    this.#fog.near = orbit.distanceM * 1.3;
    this.#fog.far = orbit.distanceM * 3;
    for (const lines of this.#lines) {
      lines.object.material.color.set(palette[lines.set.ink]);
      lines.update();
    }
    this.#drawCraft(model, orbit, palette, eye);
    this.#drawWalls(model, palette);
    this.#renderer.render(this.#scene, this.#camera);
  }

  dispose(): void {
    for (const { object } of this.#lines) {
      object.geometry.dispose();
      object.material.dispose();
    }
    for (const wall of this.#walls) wall.geometry.dispose();
    this.#dart.dispose();
    this.#renderer.dispose();
  }

  #begin(model: SpaceModel): void {
    this.#lines = model.sets().map((set) => new Lines(set));
    this.#lines.forEach(({ object }, k) => {
      object.renderOrder = k;
      object.material.fog = model.ground().includes(this.#lines[k]?.set ?? model.drops);
      this.#scene.add(object);
    });
  }

  #darts(capacity: number, hollow: boolean): InstancedMesh<BufferGeometry, MeshBasicMaterial> {
    const material = new MeshBasicMaterial({ vertexColors: true, side: DoubleSide, wireframe: hollow, fog: false });
    const mesh = new InstancedMesh(this.#dart, material, capacity);
    mesh.frustumCulled = false;
    mesh.renderOrder = 100;
    this.#scene.add(mesh);
    return mesh;
  }

  #drawCraft(model: SpaceModel, orbit: Orbit, palette: Palette, eye: { north: number; east: number; up: number }): void {
    const { craft } = model;
    if (craft.count > this.#solid.instanceMatrix.count) {
      const capacity = 2 ** Math.ceil(Math.log2(craft.count));
      for (const mesh of [this.#solid, this.#hollow]) {
        this.#scene.remove(mesh);
        mesh.material.dispose();
        mesh.dispose();
      }
      this.#solid = this.#darts(capacity, false);
      this.#hollow = this.#darts(capacity, true);
    }
    this.#solid.count = this.#hollow.count = 0;
    for (let k = 0; k < craft.count; k++) {
      const p = k * POSE;
      const [n, e, u] = [craft.poses[p] ?? 0, craft.poses[p + 1] ?? 0, craft.poses[p + 2] ?? 0];
      const distance = Math.hypot(n - eye.north, e - eye.east, u - eye.up);
      const length = Math.max(CRAFT_M, CRAFT_PX * orbit.metresPerPixel(distance));
      this.#euler.set(craft.poses[p + 4] ?? 0, -(craft.poses[p + 3] ?? 0), -(craft.poses[p + 5] ?? 0));
      this.#matrix.compose(this.#place.set(e, u, -n), this.#turn.setFromEuler(this.#euler), this.#size.setScalar(length));
      const mesh = craft.hollow[k] ? this.#hollow : this.#solid;
      mesh.setMatrixAt(mesh.count, this.#matrix);
      mesh.setColorAt(mesh.count, this.#colour.set(levelColour(palette, craft.level[k] ?? 0)));
      mesh.count++;
    }
    for (const mesh of [this.#solid, this.#hollow]) {
      mesh.instanceMatrix.needsUpdate = true;
      if (mesh.instanceColor) mesh.instanceColor.needsUpdate = true;
    }
  }

  /** Walls and lids of the zones, made anew only when they are others. */
  #drawWalls(model: SpaceModel, palette: Palette): void {
    const zones = model.zones();
    const bands = zones.map((zone) => model.band(zone));
    // A zone without a ceiling grows with the highest vehicle, by whole metres.
    const looks = [palette.warning, palette.fence, ...bands.map((band) => Math.round(band.ceilingM))].join('|');
    if (zones === this.#wallsOf.zones && looks === this.#wallsOf.looks) return;
    this.#wallsOf = { zones, looks };
    for (const wall of this.#walls) {
      this.#scene.remove(wall);
      wall.geometry.dispose();
      wall.material.dispose();
    }
    this.#walls = zones.map((zone, k) => {
      const { floorM, ceilingM } = bands[k] ?? { floorM: 0, ceilingM: 0 };
      const colour = zone.kind === 'exclusion' ? palette.warning : palette.fence;
      const material = new MeshBasicMaterial({
        color: colour, transparent: true, opacity: FILL_OPACITY[zone.kind], side: DoubleSide, depthWrite: false, fog: false,
      });
      const wall = new Mesh(volume(zone.corners, floorM, ceilingM, zone.kind === 'exclusion'), material);
      wall.renderOrder = 50;
      this.#scene.add(wall);
      return wall;
    });
  }
}

/** Walls about an outline, and a lid. */
function volume(corners: readonly { north: number; east: number }[], floorM: number, ceilingM: number, lid: boolean): BufferGeometry {
  const points: number[] = [];
  const index: number[] = [];
  for (const up of [floorM, ceilingM]) for (const { north, east } of corners) points.push(east, up, -north);
  const n = corners.length;
  for (let k = 0; k < n; k++) {
    const next = (k + 1) % n;
    index.push(k, next, n + next, k, n + next, n + k);
  }
  if (lid) {
    const faces = ShapeUtils.triangulateShape(corners.map((c) => new Vector2(c.east, c.north)), []);
    for (const face of faces) index.push(...face.map((corner) => n + corner));
  }
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(new Float32Array(points), 3));
  geometry.setIndex(index);
  return geometry;
}
