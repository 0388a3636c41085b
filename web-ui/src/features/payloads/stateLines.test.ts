import { describe, expect, it } from 'vitest';
import { stateLines } from './stateLines';

describe('state lines', () => {
  it('reads a gimbal in degrees and names who steers it', () => {
    const state = {
      connected: true, mode: 'point_at', owner: { kind: 'other', system_id: 255, component_id: 190 }, roll_rad: 0, pitch_rad: -Math.PI / 4,
      yaw_vehicle_rad: Math.PI / 2, yaw_north_rad: null, fault: '',
    };
    const lines = stateLines('gimbal', state);
    expect(lines).toContainEqual({ name: 'Pitch', value: '-45°' });
    expect(lines).toContainEqual({ name: 'Yaw, north', value: '–' });
    expect(lines).toContainEqual({ name: 'Steered by', value: '255/190', warn: true });
  });

  it('puts what is wrong first', () => {
    const lines = stateLines('radio', { connected: false, fault: 'no wireless interface', warning: true, range_m: 812.4 });
    expect(lines.slice(0, 2).map((line) => line.value)).toEqual(['not heard', 'no wireless interface']);
    expect(lines).toContainEqual({ name: 'Range', value: '812 m', warn: true });
  });

  it('shows what it has no words for as it came, and nothing of nothing', () => {
    expect(stateLines('detector', { found: 3, where: [1, 2] })).toEqual([
      { name: 'found', value: '3' },
      { name: 'where', value: '[1,2]' },
    ]);
    expect(stateLines('camera', null)).toEqual([]);
  });
});
