// Degrees on Earth to metres about the swarm's origin and back: the spherical azimuthal equidistant projection that the
// server uses for the swarm frame, so that what is drawn and what is flown agree. Pure.

import type { Geodetic } from '../protocol/types';

/** Radius of the sphere of the projection in metres (the server's value). */
export const EARTH_RADIUS_M = 6_371_000;

const RAD = Math.PI / 180;

/** A projection about one origin; results go into `north`/`east` fields to make no garbage on the hot path. */
export class SwarmProjection {
  north = 0;
  east = 0;
  latitudeDeg = 0;
  longitudeDeg = 0;
  readonly #lat0: number;
  readonly #sin0: number;
  readonly #cos0: number;

  constructor(readonly origin: Geodetic) {
    this.#lat0 = origin.latitude_deg * RAD;
    this.#sin0 = Math.sin(this.#lat0);
    this.#cos0 = Math.cos(this.#lat0);
  }

  /** Degrees to metres north and east of the origin. */
  project(latitudeDeg: number, longitudeDeg: number): this {
    const lat = latitudeDeg * RAD;
    const dLon = (longitudeDeg - this.origin.longitude_deg) * RAD;
    // Haversine form: acos of the cosine would lose centimetres near the origin.
    const sinHalfLat = Math.sin((lat - this.#lat0) / 2);
    const sinHalfLon = Math.sin(dLon / 2);
    const cosLat = Math.cos(lat);
    const h = sinHalfLat * sinHalfLat + this.#cos0 * cosLat * sinHalfLon * sinHalfLon;
    const c = 2 * Math.asin(Math.min(1, Math.sqrt(h)));
    const k = (c < 1e-12 ? 1 : c / Math.sin(c)) * EARTH_RADIUS_M;
    this.north = k * (this.#cos0 * Math.sin(lat) - this.#sin0 * cosLat * Math.cos(dLon));
    this.east = k * cosLat * Math.sin(dLon);
    return this;
  }

  /** Metres north and east of the origin to degrees. */
  unproject(north: number, east: number): this {
    const x = north / EARTH_RADIUS_M;
    const y = east / EARTH_RADIUS_M;
    const c = Math.hypot(x, y);
    if (c < 1e-15) {
      this.latitudeDeg = this.origin.latitude_deg;
      this.longitudeDeg = this.origin.longitude_deg;
      return this;
    }
    const sinC = Math.sin(c);
    const cosC = Math.cos(c);
    this.latitudeDeg = Math.asin(cosC * this.#sin0 + (x * sinC * this.#cos0) / c) / RAD;
    this.longitudeDeg =
      this.origin.longitude_deg + Math.atan2(y * sinC, c * this.#cos0 * cosC - x * this.#sin0 * sinC) / RAD;
    return this;
  }
}
