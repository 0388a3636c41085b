// Live video on the wire: the pictures and words on the socket of a stream, and where that socket is. Must never decode a picture: only what stands
// before it is read.

import type { VideoRecording, VideoRecordingAnswer, VideoRecordingList, VideoStateWord, VideoStreamView } from './types';

export type { VideoStreamList, VideoStreamView } from './types';

/** How a stream is, as the node has it. */
export const VIDEO_STATES = ['live', 'starting', 'stalled', 'no_key_picture', 'no_pictures', 'failed'] as const satisfies readonly VideoStateWord[];
export type VideoState = VideoStateWord;

/** The whole picture, or a smaller one for where many are looked at. */
export type VideoQuality = 'main' | 'sub';

/** Which stream: a payload by its name, and the vehicle that carries it. */
export type VideoAddress = { vehicle: number; payload: string };

/** What became of a recording that was begun or ended. */
export type RecordingReceipt = VideoRecordingAnswer;
export type Recording = VideoRecording;
export type RecordingList = VideoRecordingList;

/** What the node says as text on the socket of a stream. */
export type VideoMessage = { type: 'state'; view: VideoStreamView } | { type: 'pong'; id: number; timeUs: number };

/** What the socket carries beside words: pictures as H.264, as JPEG, or none. */
export type SocketWay = 'h264' | 'jpeg' | 'none';

/** A picture as it came. */
export type Picture = {
  kind: 'h264' | 'jpeg';
  /** It can be decoded without those before it. */
  key: boolean;
  /** Pictures before it were left out. */
  gap: boolean;
  widthPx: number;
  heightPx: number;
  sequence: number;
  /** From being taken to being sent. */
  ageUs: number;
  /** When it was taken, on the node's clock. */
  timeUs: number;
  /** Pictures that were left out for this viewer so far. */
  leftOut: number;
  data: Uint8Array<ArrayBuffer>;
};

/** Where what stands in the header, little endian. */
export const PICTURE = { version: 0, kind: 1, flags: 2, width_px: 4, height_px: 6, sequence: 8, age_us: 12, time_us: 16, left_out: 24 } as const;
export const PICTURE_HEADER_BYTES = 32;
export const PICTURE_VERSION = 1;
export const PICTURE_KINDS: Readonly<Record<number, Picture['kind']>> = { 1: 'h264', 2: 'jpeg' };
export const PICTURE_FLAG = { key: 1, gap: 2 } as const;

/** The picture in a message; null for a version or a kind that is not known here, and for a message that is cut off. */
export function readPicture(buffer: ArrayBuffer): Picture | null {
  if (buffer.byteLength <= PICTURE_HEADER_BYTES) return null;
  const view = new DataView(buffer);
  const kind = PICTURE_KINDS[view.getUint8(PICTURE.kind)];
  if (view.getUint8(PICTURE.version) !== PICTURE_VERSION || kind === undefined) return null;
  const flags = view.getUint8(PICTURE.flags);
  return {
    kind,
    key: (flags & PICTURE_FLAG.key) !== 0,
    gap: (flags & PICTURE_FLAG.gap) !== 0,
    widthPx: view.getUint16(PICTURE.width_px, true),
    heightPx: view.getUint16(PICTURE.height_px, true),
    sequence: view.getUint32(PICTURE.sequence, true),
    ageUs: view.getUint32(PICTURE.age_us, true),
    timeUs: view.getFloat64(PICTURE.time_us, true),
    leftOut: view.getUint32(PICTURE.left_out, true),
    data: new Uint8Array(buffer, PICTURE_HEADER_BYTES),
  };
}

/** What a text message says; null for what is no message of the node, or one that is not known here. */
export function readVideoMessage(text: string): VideoMessage | null {
  let said: unknown;
  try {
    said = JSON.parse(text);
  } catch {
    return null;
  }
  if (typeof said !== 'object' || said === null) return null;
  const { type, id, time_us: timeUs, state } = said as Record<string, unknown>;
  if (type === 'pong') return typeof id === 'number' && typeof timeUs === 'number' ? { type, id, timeUs } : null;
  if (type === 'state' && VIDEO_STATES.some((known) => known === state)) return { type, view: said as VideoStreamView };
  return null;
}

export const pingText = (id: number): string => JSON.stringify({ type: 'ping', id });

/** How long it takes from glass to glass, for the node's metrics. */
export const seenText = (p50Ms: number, p99Ms: number): string => JSON.stringify({ type: 'seen', p50_s: Math.max(0, p50Ms / 1000), p99_s: Math.max(0, p99Ms / 1000) });

/** The decoder needs a picture that stands alone. */
export const KEY_TEXT = JSON.stringify({ type: 'key' });

/** Path of what a payload offers of its video, below the API's. */
export function videoPath({ vehicle, payload }: VideoAddress, what = ''): string {
  return `vehicles/${vehicle}/payloads/${encodeURIComponent(payload)}/video${what}`;
}

/** Address of a stream's socket beside the page, whatever prefix the page is served under. */
export function videoSocketUrl(base: string, of: VideoAddress, way: SocketWay, quality: VideoQuality): string {
  const url = new URL(`api/v1/${videoPath(of)}`, base);
  url.searchParams.set('way', way);
  url.searchParams.set('quality', quality);
  url.protocol = url.protocol === 'https:' ? 'wss:' : 'ws:';
  return url.href;
}

/** The same stream has the same key. */
export function keyOf({ vehicle, payload }: VideoAddress): string {
  return `${vehicle}/${payload}`;
}

/** The stream whose key this is; null if it is none. */
export function addressOf(key: string | null): VideoAddress | null {
  const [, vehicle, payload] = /^(\d{1,5})\/(.+)$/.exec(key ?? '') ?? [];
  return vehicle === undefined || payload === undefined ? null : { vehicle: Number(vehicle), payload };
}
