// How well a track's place is known, as shapes: the ellipse of two standard deviations on the map, three of its outlines in space. Pure.

/** As the protocol has it: north-north, north-east, north-down, east-east, east-down, down-down, in square metres. */
export type Covariance = readonly [number, number, number, number, number, number];

/** Two standard deviations along both axes; the longer one lies in this direction, clockwise from north. */
export type ErrorEllipse = { longM: number; shortM: number; headingRad: number };

/** So many standard deviations are drawn and said. */
const SIGMAS = 2;
const RING_CORNERS = 32;

const isKnown = (covariance: Covariance | null): covariance is Covariance => covariance !== null && covariance.every(Number.isFinite);

/** The ellipse on the ground; null if nobody says how well the place is known, or it cannot be true. */
export function errorEllipse(covariance: Covariance | null): ErrorEllipse | null {
  if (!isKnown(covariance)) return null;
  const [nn, ne, , ee] = covariance;
  if (nn < 0 || ee < 0) return null;
  const middle = (nn + ee) / 2;
  const spread = Math.hypot((nn - ee) / 2, ne);
  return {
    longM: SIGMAS * Math.sqrt(middle + spread),
    // What rounding has made a little less than nothing is nothing.
    shortM: SIGMAS * Math.sqrt(Math.max(0, middle - spread)),
    headingRad: spread === 0 ? 0 : Math.atan2(2 * ne, nn - ee) / 2,
  };
}

/** Two standard deviations in height; null if it is not known. */
export function heightErrorM(covariance: Covariance | null): number | null {
  return isKnown(covariance) && covariance[5] >= 0 ? SIGMAS * Math.sqrt(covariance[5]) : null;
}

export type Offset = { north: number; east: number; up: number };

/** Three closed lines on the ellipsoid of two standard deviations, as offsets from its middle. */
export function errorRings(covariance: Covariance | null): Offset[][] {
  if (!isKnown(covariance)) return [];
  // Its root carries the unit sphere onto the ellipsoid, and three great circles of the one onto lines of the other.
  const [nn, ne, nd, ee, ed, dd] = covariance;
  const a = Math.sqrt(Math.max(0, nn));
  const b = a > 0 ? ne / a : 0;
  const c = a > 0 ? nd / a : 0;
  const d = Math.sqrt(Math.max(0, ee - b * b));
  const e = d > 0 ? (ed - b * c) / d : 0;
  const f = Math.sqrt(Math.max(0, dd - c * c - e * e));
  const onEllipsoid = (x: number, y: number, z: number): Offset => ({
    north: SIGMAS * a * x, east: SIGMAS * (b * x + d * y), up: -SIGMAS * (c * x + e * y + f * z),
  });
  const ring = (at: (cos: number, sin: number) => Offset): Offset[] =>
    Array.from({ length: RING_CORNERS }, (_, k) => at(Math.cos((2 * Math.PI * k) / RING_CORNERS), Math.sin((2 * Math.PI * k) / RING_CORNERS)));
  return [ring((u, v) => onEllipsoid(u, v, 0)), ring((u, v) => onEllipsoid(u, 0, v)), ring((u, v) => onEllipsoid(0, u, v))];
}
