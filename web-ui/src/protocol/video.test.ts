// The wire of live video: headers as they come and as they must not, words, addresses.

import { describe, expect, it } from 'vitest';
import { KEY_TEXT, PICTURE, PICTURE_HEADER_BYTES, addressOf, keyOf, pingText, readPicture, readVideoMessage, videoPath, videoSocketUrl } from './video';

type Header = Partial<Record<keyof typeof PICTURE, number>>;

function message(header: Header, bytes: number[] = [1, 2, 3]): ArrayBuffer {
  const buffer = new ArrayBuffer(PICTURE_HEADER_BYTES + bytes.length);
  const view = new DataView(buffer);
  view.setUint8(PICTURE.version, header.version ?? 1);
  view.setUint8(PICTURE.kind, header.kind ?? 1);
  view.setUint8(PICTURE.flags, header.flags ?? 0);
  view.setUint16(PICTURE.width_px, header.width_px ?? 640, true);
  view.setUint16(PICTURE.height_px, header.height_px ?? 480, true);
  view.setUint32(PICTURE.sequence, header.sequence ?? 7, true);
  view.setUint32(PICTURE.age_us, header.age_us ?? 12_000, true);
  view.setFloat64(PICTURE.time_us, header.time_us ?? 5_000_000_000, true);
  view.setUint32(PICTURE.left_out, header.left_out ?? 3, true);
  new Uint8Array(buffer, PICTURE_HEADER_BYTES).set(bytes);
  return buffer;
}

describe('a picture on the socket', () => {
  it('is read', () => {
    const picture = readPicture(message({ flags: 1 }))!;
    expect(picture).toMatchObject({
      kind: 'h264', key: true, gap: false, widthPx: 640, heightPx: 480, sequence: 7, ageUs: 12_000, timeUs: 5_000_000_000, leftOut: 3,
    });
    expect([...picture.data]).toEqual([1, 2, 3]);
    expect(readPicture(message({ kind: 2, flags: 2 }))).toMatchObject({ kind: 'jpeg', key: false, gap: true });
    expect(readPicture(message({ flags: 3 }))).toMatchObject({ key: true, gap: true });
  });

  it('holds numbers as large as they come', () => {
    expect(readPicture(message({ width_px: 0xffff, sequence: 0xffffffff, age_us: 0xffffffff, time_us: 2 ** 52, left_out: 0xffffffff }))).toMatchObject({
      widthPx: 0xffff, sequence: 0xffffffff, ageUs: 0xffffffff, timeUs: 2 ** 52, leftOut: 0xffffffff,
    });
  });

  it('is none where the message is cut off, or of a version or kind that is not known', () => {
    for (let bytes = 0; bytes <= PICTURE_HEADER_BYTES; bytes++) expect(readPicture(message({}).slice(0, bytes)), `${bytes} bytes`).toBeNull();
    for (const version of [0, 2, 255]) expect(readPicture(message({ version }))).toBeNull();
    for (const kind of [0, 3, 255]) expect(readPicture(message({ kind }))).toBeNull();
  });
});

describe('a word on the socket', () => {
  const view = { vehicle: 2, payload: 'camera', state: 'live', reason: '', codec: 'avc1.42c01f', width_px: 640, height_px: 480, rate_hz: 30, bytes_per_s: 2e5, lost: 0, age_s: 0.03, viewers: 1 };

  it('is the state of the stream, or the answer to a ping', () => {
    expect(readVideoMessage(JSON.stringify({ type: 'state', ...view }))).toEqual({ type: 'state', view: { type: 'state', ...view } });
    expect(readVideoMessage('{"type":"pong","id":3,"time_us":1234567890123}')).toEqual({ type: 'pong', id: 3, timeUs: 1234567890123 });
  });

  it('is nothing else', () => {
    for (const text of ['', '{', '7', 'null', '[]', '{}', '{"type":"news"}', '{"type":"state","state":"merry"}', '{"type":"pong","id":3}', '{"type":"pong","id":"3","time_us":1}', '{"type":"pong","time_us":1}']) {
      expect(readVideoMessage(text), text).toBeNull();
    }
  });

  it('of the page is a ping or the wish for a key picture', () => {
    expect(JSON.parse(pingText(4))).toEqual({ type: 'ping', id: 4 });
    expect(JSON.parse(KEY_TEXT)).toEqual({ type: 'key' });
  });
});

describe('where a stream is', () => {
  it('stands beside the page, with its own scheme', () => {
    const of = { vehicle: 2, payload: 'nose camera/1' };
    expect(videoSocketUrl('http://127.0.0.1:8080/', of, 'h264', 'main')).toBe('ws://127.0.0.1:8080/api/v1/vehicles/2/payloads/nose%20camera%2F1/video?way=h264&quality=main');
    expect(videoSocketUrl('https://gcs.local/skein/', of, 'none', 'sub')).toBe('wss://gcs.local/skein/api/v1/vehicles/2/payloads/nose%20camera%2F1/video?way=none&quality=sub');
    expect(videoPath(of, '/recording')).toBe('vehicles/2/payloads/nose%20camera%2F1/video/recording');
  });

  it('has a key, and is found by it', () => {
    for (const of of [{ vehicle: 2, payload: 'camera' }, { vehicle: 65535, payload: 'nose/1' }]) expect(addressOf(keyOf(of))).toEqual(of);
    for (const key of [null, '', '2', '2/', '/camera', 'x/camera', '1234567/camera']) expect(addressOf(key), `${key}`).toBeNull();
  });
});
