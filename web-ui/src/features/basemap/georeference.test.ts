import { describe, expect, it } from 'vitest';
import { Georeference, affineOf, codeOf, definitionOf } from './georeference';
import type { GeoTags } from './georeference';

const tags = (given: Partial<GeoTags>): GeoTags => ({ pixelScale: null, tiepoints: null, transformation: null, keys: {}, ...given });
const IDENTITY = [1, 0, 0, 0, 1, 0] as const;
/** Metres of a degree of latitude, roughly. */
const DEGREE_M = 111_000;
const DECIMETRE = 0.1;

describe('projections', () => {
  // Eastings and northings by integrating the meridian's arc over complex latitudes, which shares nothing with the series of the library; the
  // first two stand in every table of UTM. LV95: swisstopo's own example. Lambert-93: the origin as it is defined.
  it.each([
    ['UTM 32 north, on the meridian', 32632, 500_000, 4_982_950.4, 45, 9],
    ['UTM 32 north, at the edge of the zone', 32632, 166_021.443, 0, 0, 6],
    ['UTM 32 north, Zurich', 32632, 465_710.759, 5_249_465.364, 47.397742, 8.545594],
    ['UTM 32 of ETRS89, Zurich', 25832, 465_710.759, 5_249_465.364, 47.397742, 8.545594],
    ['UTM 56 south, Sydney', 32756, 334_900.261, 6_252_290.522, -33.856784, 151.215297],
    ['UTM 27 north, Reykjavik', 32627, 454_138.377, 7_113_689.869, 64.1466, -21.9426],
    ['WGS 84', 4326, 8.545594, 47.397742, 47.397742, 8.545594],
    ['Web Mercator', 3857, 20_037_508.343 / 2, 0, 0, 90],
    ['Lambert-93', 2154, 700_000, 6_600_000, 46.5, 3],
  ])('%s', (_, code, x, y, latitudeDeg, longitudeDeg) => {
    const reference = new Georeference(IDENTITY, definitionOf(code)!);
    const place = reference.toDegrees(x, y);
    expect(Math.abs(place.latitudeDeg - latitudeDeg) * DEGREE_M).toBeLessThan(DECIMETRE);
    expect(Math.abs(place.longitudeDeg - longitudeDeg) * DEGREE_M).toBeLessThan(DECIMETRE);
    const pixel = reference.toPixel({ latitudeDeg, longitudeDeg });
    const perUnit = code === 4326 ? DEGREE_M : 1;
    expect(Math.abs(pixel.column - x) * perUnit).toBeLessThan(DECIMETRE);
    expect(Math.abs(pixel.row - y) * perUnit).toBeLessThan(DECIMETRE);
  });

  it('the Swiss grid, to a metre', () => {
    const place = new Georeference(IDENTITY, definitionOf(2056)!).toDegrees(2_700_000, 1_100_000);
    expect(Math.abs(place.latitudeDeg - (46 + 2 / 60 + 38.87 / 3600)) * DEGREE_M).toBeLessThan(1);
    expect(Math.abs(place.longitudeDeg - (8 + 43 / 60 + 49.79 / 3600)) * DEGREE_M).toBeLessThan(1);
  });

  it('knows no others, and no zones that there are not', () => {
    for (const code of [32661, 32600, 32700, 32761, 25827, 25839, 27700, 31468, 0, 32767]) expect(definitionOf(code), `${code}`).toBeNull();
  });
});

describe('codeOf', () => {
  it.each([
    [{ GTModelTypeGeoKey: 1, ProjectedCSTypeGeoKey: 32632 }, 32632],
    [{ GTModelTypeGeoKey: 1, ProjectedCSTypeGeoKey: 32632, GeographicTypeGeoKey: 4326 }, 32632],
    [{ GTModelTypeGeoKey: 2, GeographicTypeGeoKey: 4326 }, 4326],
    [{ ProjectedCSTypeGeoKey: 3857 }, 3857],
    [{ GTModelTypeGeoKey: 1, ProjectedCSTypeGeoKey: 32767, GeographicTypeGeoKey: 4326, ProjectionGeoKey: 16032 }, 32632],
    [{ GTModelTypeGeoKey: 1, ProjectedCSTypeGeoKey: 32767, GeographicTypeGeoKey: 4326, ProjectionGeoKey: 16156 }, 32756],
    [{ GTModelTypeGeoKey: 1, ProjectedCSTypeGeoKey: 32767, GeographicTypeGeoKey: 4267, ProjectionGeoKey: 16032 }, 'own'],
    [{ GTModelTypeGeoKey: 1, ProjectedCSTypeGeoKey: 32767 }, 'own'],
    [{ GTModelTypeGeoKey: 3 }, 'own'],
    [{}, null],
  ])('%o is %s', (keys, code) => expect(codeOf(keys)).toBe(code));
});

describe('affineOf', () => {
  const scale = { pixelScale: [0.5, 0.25, 0], tiepoints: [0, 0, 0, 1000, 2000, 0] };

  it('goes down from a tie point', () => {
    expect(affineOf(tags(scale))).toEqual([0.5, 0, 1000, 0, -0.25, 2000]);
    expect(affineOf(tags({ ...scale, tiepoints: [10, 20, 0, 1000, 2000, 0] }))).toEqual([0.5, 0, 995, 0, -0.25, 2005]);
  });

  it('takes a matrix, and takes it before the tie point', () => {
    const transformation = [0.3, 0.4, 0, 500, 0.4, -0.3, 0, 900, 0, 0, 0, 0, 0, 0, 0, 1];
    expect(affineOf(tags({ ...scale, transformation }))).toEqual([0.3, 0.4, 500, 0.4, -0.3, 900]);
  });

  it('a point is the middle of its pixel', () => {
    expect(affineOf(tags({ ...scale, keys: { GTRasterTypeGeoKey: 2 } }))).toEqual([0.5, 0, 999.75, 0, -0.25, 2000.125]);
    expect(affineOf(tags({ ...scale, keys: { GTRasterTypeGeoKey: 1 } }))).toEqual([0.5, 0, 1000, 0, -0.25, 2000]);
  });

  it('makes nothing of what says nothing', () => {
    expect(affineOf(tags({}))).toBeNull();
    expect(affineOf(tags({ pixelScale: [1, 1, 0] }))).toBeNull();
    expect(affineOf(tags({ ...scale, pixelScale: [0, 0, 0] }))).toBeNull();
    expect(affineOf(tags({ ...scale, tiepoints: [0, 0, 0, NaN, 0, 0] }))).toBeNull();
    // Control points of a picture that is not rectified.
    expect(affineOf(tags({ ...scale, tiepoints: [0, 0, 0, 1, 1, 0, 9, 0, 0, 2, 1, 0, 0, 9, 0, 1, 2, 0] }))).toBeNull();
  });
});

describe('Georeference', () => {
  it('there and back, turned and in a zone', () => {
    const reference = new Georeference([0.03, 0.04, 465_000, 0.04, -0.03, 5_249_000], definitionOf(32632)!);
    const pixel = reference.toPixel(reference.toDegrees(1234.5, 678.25));
    expect(pixel.column).toBeCloseTo(1234.5, 4);
    expect(pixel.row).toBeCloseTo(678.25, 4);
    expect(reference.pixelM(0, 0)).toBeCloseTo(0.05, 3);
  });

  it('a picture of a zone is turned by the convergence of its meridian', () => {
    // At Zurich, 0.4544 degrees west of the middle of the zone: sin(latitude) times that, anticlockwise.
    const reference = new Georeference([1, 0, 465_710.759, 0, -1, 5_249_465.364], definitionOf(32632)!);
    const [from, to] = [reference.toDegrees(0, 0), reference.toDegrees(1000, 0)];
    const north = (to.latitudeDeg - from.latitudeDeg) * DEGREE_M;
    const east = (to.longitudeDeg - from.longitudeDeg) * DEGREE_M * Math.cos((47.4 * Math.PI) / 180);
    expect((Math.atan2(north, east) * 180) / Math.PI).toBeCloseTo(0.4544 * Math.sin((47.397742 * Math.PI) / 180), 1);
  });

  it('lies in the degrees of all its sides', () => {
    const piece = new Georeference([0.1, 0, 8, 0, -0.1, 48], definitionOf(4326)!).pieceOf(10, 20);
    for (const [side, deg] of [[piece.south, 46], [piece.west, 8], [piece.north, 48], [piece.east, 9]] as const) expect(side).toBeCloseTo(deg, 9);
  });
});
