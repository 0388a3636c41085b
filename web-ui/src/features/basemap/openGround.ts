// Which kind of file the operator has chosen: what it begins with decides, not its name.

import { t } from '../../language/language.svelte';
import { BaseMapError } from './ground';
import type { Ground } from './ground';
import { WebTiles } from './webTiles';

const PMTILES = 'PMTiles';
/** TIFF, little and big endian, and BigTIFF likewise. */
const TIFF = ['II*\0', 'MM\0*', 'II+\0', 'MM\0+'];

/** Opens a file, or says with a `BaseMapError` why it is no ground. */
export async function openGround(file: File): Promise<Ground> {
  const bytes = new Uint8Array(await file.slice(0, PMTILES.length).arrayBuffer());
  const start = String.fromCharCode(...bytes);
  if (start === PMTILES || (/\.pmtiles$/i.test(file.name) && !TIFF.includes(start.slice(0, 4)))) return WebTiles.open(file);
  if (TIFF.includes(start.slice(0, 4))) return (await import('./orthophoto')).Orthophoto.open(file);
  if (/\.tiff?$/i.test(file.name)) throw new BaseMapError(t('{file} is no GeoTIFF file', { file: file.name }));
  throw new BaseMapError(t('{file} is neither a PMTiles nor a GeoTIFF file', { file: file.name }));
}
