// The binary telemetry frame: its layout comes from the server's own table (generated), its header is checked here.
// Must never interpret records: what the scaled numbers mean is the telemetry store's part.

import { FRAME_MAGIC, HEADER, HEADER_BYTES, RECORD_BYTES } from './generated/frame';

export { FLAG, HEADER_BYTES, RECORD, RECORD_BYTES, UNKNOWN_PERCENT, UNKNOWN_U16 } from './generated/frame';

export type FrameHeader = { sequence: number; count: number; serverTimeMs: number };

/** Why a frame was not taken. */
export class FrameError extends Error {
  override name = 'FrameError';
}

/** Checks magic and length and gives the header. */
export function readHeader(view: DataView): FrameHeader {
  if (view.byteLength < HEADER_BYTES) throw new FrameError(`frame of ${view.byteLength} bytes is shorter than its header`);
  const magic = view.getUint32(HEADER.magic, true);
  if (magic !== FRAME_MAGIC) throw new FrameError(`frame begins with 0x${magic.toString(16)}: another protocol version`);
  const count = view.getUint32(HEADER.count, true);
  const expected = HEADER_BYTES + count * RECORD_BYTES;
  if (view.byteLength !== expected) {
    throw new FrameError(`frame of ${count} vehicles has ${view.byteLength} bytes instead of ${expected}`);
  }
  return {
    sequence: view.getUint32(HEADER.sequence, true),
    count,
    serverTimeMs: view.getUint32(HEADER.server_time_ms, true),
  };
}
