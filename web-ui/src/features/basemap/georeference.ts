// Where the pixels of a GeoTIFF lie on Earth: its transformation, and the projections that are known here. Pixels are counted from the upper
// left corner of the picture at full size. Pure. Must never guess: a picture in a wrong place is worse than none.

import proj4 from 'proj4';
import type { Degrees, Piece } from './tileMath';

/** What the file says about its place, as it stands in it. */
export type GeoTags = {
  readonly pixelScale: readonly number[] | null;
  readonly tiepoints: readonly number[] | null;
  readonly transformation: readonly number[] | null;
  readonly keys: Readonly<Record<string, unknown>>;
};

/** x = a·column + b·row + c, y = d·column + e·row + f. */
export type Affine = readonly [a: number, b: number, c: number, d: number, e: number, f: number];

const PIXEL_IS_POINT = 2;
const PROJECTED = 1;
const GEOGRAPHIC = 2;
/** "Defined by the file itself." */
const OWN = 32767;

/** How pixels become coordinates of the projection; null: the file does not say. */
export function affineOf({ pixelScale, tiepoints, transformation, keys }: GeoTags): Affine | null {
  const affine = transformation ? fromMatrix(transformation) : fromTiepoint(pixelScale, tiepoints);
  if (!affine) return null;
  const [a, b, c, d, e, f] = affine;
  if (!affine.every(Number.isFinite) || a * e - b * d === 0) return null;
  // What is said of a point is said of the pixel's middle: its corner lies half a pixel before.
  return keys.GTRasterTypeGeoKey === PIXEL_IS_POINT ? [a, b, c - (a + b) / 2, d, e, f - (d + e) / 2] : affine;
}

function fromMatrix(m: readonly number[]): Affine | null {
  const [a, b, , c, d, e, , f] = m;
  return a === undefined || b === undefined || c === undefined || d === undefined || e === undefined || f === undefined ? null : [a, b, c, d, e, f];
}

function fromTiepoint(scale: readonly number[] | null, tiepoints: readonly number[] | null): Affine | null {
  // Several of them are control points, of a picture that is not rectified.
  if (!scale || tiepoints?.length !== 6) return null;
  const [sx, sy] = scale;
  const [column, row, , x, y] = tiepoints;
  if (sx === undefined || sy === undefined || column === undefined || row === undefined || x === undefined || y === undefined) return null;
  return [sx, 0, x - column * sx, 0, -sy, y + row * sy];
}

/** EPSG code of the file's coordinates; 'own': they have none; null: there is no word about them. */
export function codeOf(keys: Readonly<Record<string, unknown>>): number | 'own' | null {
  const [projected, geographic, model] = [keys.ProjectedCSTypeGeoKey, keys.GeographicTypeGeoKey, keys.GTModelTypeGeoKey];
  if (model === undefined && projected === undefined && geographic === undefined) return null;
  // Some writers name both; then the second is only what the projection is based on.
  const isProjected = model === PROJECTED || (model !== GEOGRAPHIC && projected !== undefined);
  const code = isProjected ? projected : geographic;
  if (typeof code === 'number' && code !== OWN && code !== 0) return code;
  return (isProjected ? utmOf(keys) : null) ?? 'own';
}

/** Some writers name the zone alone and what it is based on: 160zz is a northern one, 161zz a southern one. */
function utmOf({ ProjectionGeoKey: zone, GeographicTypeGeoKey: base }: Readonly<Record<string, unknown>>): number | null {
  if (typeof zone !== 'number' || zone < 16001 || zone > 16160) return null;
  return base === 4326 ? zone + 16600 : null;
}

/** National grids whose change to WGS 84 is good to a metre without a table of shifts. */
const NATIONAL: Readonly<Record<number, string>> = {
  // Switzerland, LV95
  2056: '+proj=somerc +lat_0=46.9524055555556 +lon_0=7.43958333333333 +k_0=1 +x_0=2600000 +y_0=1200000 +ellps=bessel +towgs84=674.374,15.056,405.346,0,0,0,0 +units=m +no_defs',
  // France, Lambert-93
  2154: '+proj=lcc +lat_0=46.5 +lon_0=3 +lat_1=49 +lat_2=44 +x_0=700000 +y_0=6600000 +ellps=GRS80 +towgs84=0,0,0,0,0,0,0 +units=m +no_defs',
};

/** An EPSG code in the words of PROJ, or null for those that are not known here. */
export function definitionOf(code: number): string | null {
  // ETRS89 is taken for WGS 84: in Europe they are less than a metre apart.
  if (code === 4326 || code === 4258) return '+proj=longlat +datum=WGS84 +no_defs';
  if (code === 3857) return '+proj=merc +a=6378137 +b=6378137 +lat_ts=0 +lon_0=0 +x_0=0 +y_0=0 +k=1 +units=m +nadgrids=@null +no_defs';
  const zone = code % 100;
  if (code >= 32601 && code <= 32660) return `+proj=utm +zone=${zone} +datum=WGS84 +units=m +no_defs`;
  if (code >= 32701 && code <= 32760) return `+proj=utm +zone=${zone} +south +datum=WGS84 +units=m +no_defs`;
  if (code >= 25828 && code <= 25838) return `+proj=utm +zone=${zone} +ellps=GRS80 +towgs84=0,0,0,0,0,0,0 +units=m +no_defs`;
  return NATIONAL[code] ?? null;
}

/** Pixels to degrees and back. */
export class Georeference {
  readonly #affine: Affine;
  readonly #projection: proj4.Converter;

  constructor(affine: Affine, definition: string) {
    this.#affine = affine;
    this.#projection = proj4(definition);
  }

  toDegrees(column: number, row: number): Degrees {
    const [a, b, c, d, e, f] = this.#affine;
    const [longitudeDeg, latitudeDeg] = this.#projection.inverse([a * column + b * row + c, d * column + e * row + f]);
    return { latitudeDeg: latitudeDeg!, longitudeDeg: longitudeDeg! };
  }

  toPixel({ latitudeDeg, longitudeDeg }: Degrees): { column: number; row: number } {
    const [a, b, c, d, e, f] = this.#affine;
    const [px, py] = this.#projection.forward([longitudeDeg, latitudeDeg]);
    const [x, y] = [px! - c, py! - f];
    const det = a * e - b * d;
    return { column: (e * x - b * y) / det, row: (a * y - d * x) / det };
  }

  /** The degrees that a picture of this size lies in. A degree too much does no harm, one too few would cut it. */
  pieceOf(widthPx: number, heightPx: number): Piece {
    const all = rim([0, 0, widthPx, heightPx]).map(([column, row]) => this.toDegrees(column, row));
    const [lats, lons] = [all.map((p) => p.latitudeDeg), all.map((p) => p.longitudeDeg)];
    return { south: Math.min(...lats), west: Math.min(...lons), north: Math.max(...lats), east: Math.max(...lons) };
  }

  /** Side of a pixel on the ground, at a place of the picture. */
  pixelM(column: number, row: number): number {
    const [here, right, below] = [this.toDegrees(column, row), this.toDegrees(column + 1, row), this.toDegrees(column, row + 1)];
    const perLon = METRES_PER_DEGREE * Math.cos((here.latitudeDeg * Math.PI) / 180);
    const step = (to: Degrees) => [(to.latitudeDeg - here.latitudeDeg) * METRES_PER_DEGREE, (to.longitudeDeg - here.longitudeDeg) * perLon] as const;
    const [[n1, e1], [n2, e2]] = [step(right), step(below)];
    return Math.sqrt(Math.abs(n1 * e2 - n2 * e1));
  }
}

const METRES_PER_DEGREE = 111_195;
const RIM_STEPS = 8;

/** Points along the four sides of a rectangle: curved lines may reach further than the corners do. */
export function rim([left, top, right, bottom]: readonly [number, number, number, number]): [number, number][] {
  const points: [number, number][] = [];
  for (let k = 0; k <= RIM_STEPS; k++) {
    const [x, y] = [left + ((right - left) * k) / RIM_STEPS, top + ((bottom - top) * k) / RIM_STEPS];
    points.push([x, top], [x, bottom], [left, y], [right, y]);
  }
  return points;
}
