import { describe, expect, it } from 'vitest';
import { build, initialOf } from './formValues';
import { formsOf } from './schemaForm';
import type { Form } from './schemaForm';
import { schemaLines } from './schemaState';
import { unitOf } from './units';

const SCHEMA = JSON.stringify({
  $defs: {
    Frame: { oneOf: [{ const: 'vehicle', description: 'Zero is the nose.' }, { const: 'north', description: 'Zero is north.' }] },
    Place: {
      type: 'object', required: ['latitude_deg', 'altitude_amsl_m'],
      properties: { latitude_deg: { type: 'number' }, altitude_amsl_m: { type: 'number' } },
    },
    Target: {
      oneOf: [
        { type: 'object', required: ['kind', 'vehicle'], properties: { kind: { const: 'vehicle' }, vehicle: { type: 'integer', minimum: 1 } } },
        { type: 'object', required: ['kind'], properties: { kind: { const: 'nothing' } } },
      ],
    },
    Loop: { type: 'object', required: ['again'], properties: { again: { $ref: '#/$defs/Loop' } } },
  },
  oneOf: [
    {
      type: 'object', description: 'Point.', required: ['command', 'pitch_rad'],
      properties: {
        command: { const: 'angles' }, pitch_rad: { type: 'number', minimum: -1.5707963267948966, description: 'Up, in radians.' },
        frame: { $ref: '#/$defs/Frame', default: 'north' }, speed_rad_s: { type: ['number', 'null'], default: null },
      },
    },
    { type: 'object', required: ['command', 'place'], properties: { command: { const: 'point_at' }, place: { $ref: '#/$defs/Place' } } },
    { type: 'object', required: ['command', 'target'], properties: { command: { const: 'look' }, target: { $ref: '#/$defs/Target' } } },
    { type: 'object', required: ['command'], 'x-danger': 'hold', 'x-when': 'ground', properties: { command: { const: 'reset' } } },
    { type: 'object', required: ['command', 'marks'], properties: { command: { const: 'mark' }, marks: { type: 'array', items: {} } } },
    { type: 'object', required: ['command', 'loop'], properties: { command: { const: 'loop' }, loop: { $ref: '#/$defs/Loop' } } },
  ],
});

const forms = formsOf(SCHEMA);
const named = (key: string): Form => forms.find((form) => form.key === key)!;

describe('a panel from a schema', () => {
  it('has a form for everything that can be asked, and ends where a schema does not', () => {
    expect(forms.map((form) => form.words)).toEqual(['Angles', 'Point at', 'Look', 'Reset', 'Mark', 'Loop']);
    expect(named('reset')).toMatchObject({ danger: 'hold', when: 'ground', fields: [] });
    expect(formsOf('{')).toEqual([]);
    expect(formsOf(null)).toEqual([]);
    expect(formsOf('{"enum": ["on", "off"]}').map((form) => form.fixed)).toEqual(['on', 'off']);
  });

  it('shows radians as degrees and sends radians, and leaves out what is left out', () => {
    const angles = named('angles');
    expect(angles.fields[0]).toMatchObject({ words: 'Pitch', unit: '°', kind: 'number', required: true, min: -90, help: 'Up, in degrees.' });
    expect(angles.fields[1]).toMatchObject({ kind: 'choice', choices: [{ words: 'Vehicle' }, { words: 'North', help: 'Zero is north.' }] });
    expect(angles.fields[2]).toMatchObject({ words: 'Speed', unit: '°/s', required: false });
    expect(build(angles, initialOf(angles)).problems).toEqual({ pitch_rad: 'is needed' });
    const built = build(angles, { ...initialOf(angles), pitch_rad: -45 });
    expect(built.problems).toEqual({});
    expect(built.command).toEqual({ command: 'angles', pitch_rad: -Math.PI / 4, frame: 'north' });
    expect(build(angles, { ...initialOf(angles), pitch_rad: -91 }).problems).toEqual({ pitch_rad: 'is -90 at least' });
  });

  it('lays objects flat and puts them together again', () => {
    const form = named('point_at');
    expect(form.fields.map((field) => field.words)).toEqual(['Latitude', 'Altitude']);
    const { command } = build(form, { 'place.latitude_deg': 47, 'place.altitude_amsl_m': 500 });
    expect(command).toEqual({ command: 'point_at', place: { latitude_deg: 47, altitude_amsl_m: 500 } });
  });

  it('offers what may be one of several', () => {
    const form = named('look');
    expect(form.fields[0]).toMatchObject({ kind: 'variant' });
    expect(build(form, { target: { key: 'vehicle', values: { vehicle: 3 } } }).command).toEqual({ command: 'look', target: { kind: 'vehicle', vehicle: 3 } });
    expect(build(form, { target: { key: 'vehicle', values: { vehicle: 1.5 } } }).problems).toEqual({ target: 'vehicle is a whole number' });
    expect(build(form, { target: { key: 'nothing', values: {} } }).command).toEqual({ command: 'look', target: { kind: 'nothing' } });
  });

  it('lets anything else be typed', () => {
    const form = named('mark');
    expect(build(form, { marks: '[1, 2' }).problems).toEqual({ marks: 'is no JSON' });
    expect(build(form, { marks: '[1, 2]' }).command).toEqual({ command: 'mark', marks: [1, 2] });
  });
});

describe('the state from a schema', () => {
  it('is in the order of the schema, in units and words; what is wrong stands out', () => {
    const schema = JSON.stringify({
      properties: {
        connected: { type: 'boolean' }, pitch_rad: { type: 'number' }, mode: { type: 'string' }, place: { type: 'object' }, streams: { type: 'array' },
        fault: { type: 'string' },
      },
    });
    const state = { fault: 'jammed', pitch_rad: Math.PI / 2, mode: 'point_at', connected: false, place: null, streams: [1, 2], extra: 7 };
    expect(schemaLines(schema, state)).toEqual([
      { name: 'Connected', value: 'no', warn: true },
      { name: 'Pitch', value: '90.0 °' },
      { name: 'Mode', value: 'point at' },
      { name: 'Place', value: '–' },
      { name: 'Streams', value: '2' },
      { name: 'Fault', value: 'jammed', warn: true },
      { name: 'Extra', value: '7' },
    ]);
    expect(schemaLines(null, null)).toEqual([]);
  });

  it('tells units by their ending', () => {
    expect(unitOf('speed_m_s')).toEqual({ words: 'speed', unit: 'm/s', scale: 1 });
    expect(unitOf('interval_s').unit).toBe('s');
    expect(unitOf('count')).toEqual({ words: 'count', unit: '', scale: 1 });
    expect(unitOf('gain', 'dB').unit).toBe('dB');
  });
});
