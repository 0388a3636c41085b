import { describe, expect, it } from 'vitest';
import { ageText, bytesText, frozenText, lengthText, rateText, shareText, sizeText, stillName, wayText } from './videoWords';

describe('what is said of a stream', () => {
  it('has the digits that count', () => {
    expect([rateText(0), rateText(4.98), rateText(29.97)]).toEqual(['0.0/s', '5.0/s', '30/s']);
    expect([shareText(0), shareText(0.004), shareText(0.123), shareText(1)]).toEqual(['0 %', '0.4 %', '12 %', '100 %']);
    expect([sizeText(0, 0), sizeText(640, 480)]).toEqual(['–', '640×480']);
    expect([ageText(null), ageText(0.04), ageText(2.34)]).toEqual(['–', '0.0 s', '2.3 s']);
    expect(frozenText(2.34)).toBe('last picture 2.3 s ago');
    expect([bytesText(12_345), bytesText(1_234_567), bytesText(2.5e9)]).toEqual(['12 kB', '1.2 MB', '2.50 GB']);
    expect([lengthText(5.9), lengthText(65), lengthText(3725)]).toEqual(['0:05', '1:05', '1:02:05']);
  });

  it('names the ways', () => {
    expect([wayText('automatic'), wayText('webrtc'), wayText('webcodecs'), wayText('jpeg'), wayText(null)]).toEqual(['automatic', 'WebRTC', 'WebCodecs', 'JPEG', '–']);
  });

  it('gives a picture a name that every disk takes', () => {
    expect(stillName('uav-2', 'nose camera/1', new Date(2026, 10, 7, 8, 5, 9))).toBe('uav-2_nose-camera-1_20261107-080509.jpg');
  });
});
