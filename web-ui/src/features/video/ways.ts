// The ways by their names.

import type { VideoWay } from '../../model/videoWay';
import { JpegReceiver } from './jpeg';
import type { Asked, Receiver } from './receiver';
import { WebcodecsReceiver } from './webcodecs';
import { WhepReceiver } from './whep';

export type OpenWay = (way: VideoWay, asked: Asked) => Receiver;

export const openWay: OpenWay = (way, asked) => {
  switch (way) {
    case 'webcodecs':
      return new WebcodecsReceiver(asked);
    case 'webrtc':
      return new WhepReceiver(asked);
    case 'jpeg':
      return new JpegReceiver(asked);
  }
};
