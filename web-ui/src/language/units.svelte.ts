// The units of the page: metres and metres per second, or feet, knots and nautical miles. All there is inside of the page, and all that is
// sent, is metric; a figure changes its unit here, on its way to the screen, and back on its way from a field. English and German write
// these units alike. Must never change a figure that the program has put into words itself.

import { remember, remembered } from '../app/remembered';

export const UNIT_SYSTEMS = ['metric', 'aviation'] as const;
export type UnitSystem = (typeof UNIT_SYSTEMS)[number];

/** What a figure is of. A height goes up from somewhere, a length along the ground or between two; a climb is a speed up or down. */
export type Measure = 'length' | 'height' | 'speed' | 'climb';

const FOOT_M = 0.3048;
const MILE_M = 1852;
const KNOT_M_S = MILE_M / 3600;

/** What one of it is in metres or metres per second, and the digits it is read with. */
type Scale = { unit: string; si: number; digits: number };
const METRE: Scale = { unit: 'm', si: 1, digits: 1 };
const METRE_PER_S: Scale = { unit: 'm/s', si: 1, digits: 1 };

const SCALES: Record<UnitSystem, Record<Measure, Scale>> = {
  metric: { length: METRE, height: METRE, speed: METRE_PER_S, climb: METRE_PER_S },
  aviation: {
    length: { unit: 'ft', si: FOOT_M, digits: 1 },
    height: { unit: 'ft', si: FOOT_M, digits: 0 },
    speed: { unit: 'kn', si: KNOT_M_S, digits: 1 },
    climb: { unit: 'ft/min', si: FOOT_M / 60, digits: 0 },
  },
};

const KEY = 'skein-units';

class Units {
  name = $state<UnitSystem>('metric');

  /** The units chosen before, else metric. */
  start(): void {
    this.name = remembered(KEY, UNIT_SYSTEMS) ?? 'metric';
  }

  choose(name: UnitSystem): void {
    remember(KEY, name);
    this.name = name;
  }
}

export const units = new Units();

const metric = (): boolean => units.name === 'metric';
const scaleOf = (measure: Measure): Scale => SCALES[units.name][measure];

/** The name of the unit: `m`, `kn`. */
export function unitName(measure: Measure): string {
  return scaleOf(measure).unit;
}

/** A figure in metres or metres per second as the number that is shown. */
export function shown(measure: Measure, si: number): number {
  return si / scaleOf(measure).si;
}

/** The same for a line of a chart. */
export function shownAll(measure: Measure, values: (number | null)[]): (number | null)[] {
  return metric() ? values : values.map((value) => (value === null ? null : shown(measure, value)));
}

/** Digits after the point of a figure that is read as it changes; of how far something is off its place with `fine`. */
export function digitsOf(measure: Measure, fine = false): number {
  return fine ? (metric() ? 2 : 1) : scaleOf(measure).digits;
}

function fixed(value: number, digits: number): string {
  return value.toFixed(digits).replace(/^-(0(\.0*)?)$/, '$1');
}

/** `12.3 m`, `40 ft`, `4.5 kn`. */
export function figureText(measure: Measure, si: number): string {
  const { unit, digits } = scaleOf(measure);
  return `${fixed(shown(measure, si), digits)} ${unit}`;
}

/** How far something is off its place: finer while it is little. */
export function errorText(metres: number): string {
  const off = shown('length', metres);
  if (metric()) return `${fixed(off, off < 10 ? 2 : 0)} m`;
  return `${fixed(off, off < 99.95 ? 1 : 0)} ft`;
}

/** A measured distance: centimetres below ten metres, metres above a hundred, kilometres from ten; or tenths of a foot below a hundred
    feet, feet above, nautical miles from one. */
export function lengthText(metres: number): string {
  if (!metric()) return metres < MILE_M ? errorText(metres) : milesText(metres);
  if (metres < 10) return `${metres.toFixed(2)} m`;
  if (metres < 100) return `${metres.toFixed(1)} m`;
  if (metres < 10_000) return `${Math.round(metres)} m`;
  return `${(metres / 1000).toFixed(2)} km`;
}

/** The length of a way: whole metres, or feet and from one on nautical miles. */
export function wayText(metres: number): string {
  if (metric()) return `${metres.toFixed(0)} m`;
  return metres < MILE_M ? `${(metres / FOOT_M).toFixed(0)} ft` : milesText(metres);
}

/** A distance from the origin as the pointer reads it, without its sign. */
export function placeText(metres: number): string {
  return metric() ? `${Math.abs(metres).toFixed(1)} m` : wayText(Math.abs(metres));
}

function milesText(metres: number): string {
  return `${(metres / MILE_M).toFixed(2)} NM`;
}

/** How much higher something is: `+1.5 m`, `−5 ft`. */
export function riseText(metres: number): string {
  const { unit, digits } = scaleOf('height');
  const text = fixed(shown('height', metres), digits);
  return `${text.startsWith('-') ? '−' : '+'}${text.replace('-', '')} ${unit}`;
}

// Fields: what stands in one is what is sent, so it is rounded before it is sent and not only for the screen.

const FIELD_DIGITS = 1;

/** A figure as the number in a field. */
export function toField(measure: Measure, si: number): number {
  return Number(shown(measure, si).toFixed(metric() ? 3 : FIELD_DIGITS));
}

/** A number typed into a field in metres or metres per second. */
export function fromField(measure: Measure, typed: number): number {
  return metric() ? typed : Number(typed.toFixed(FIELD_DIGITS)) * scaleOf(measure).si;
}

/** The least and the most of a field, rounded to where it is still allowed. */
export function fieldRange(measure: Measure, min: number, max: number): { min: number; max: number } {
  if (metric()) return { min, max };
  const power = 10 ** FIELD_DIGITS;
  return { min: Math.ceil(shown(measure, min) * power) / power + 0, max: Math.floor(shown(measure, max) * power) / power };
}

/** A figure that somebody has set, as the field has it: `10 m`, `32.8 ft`. */
export function setText(measure: Measure, si: number): string {
  return `${toField(measure, si)} ${unitName(measure)}`;
}

/** A value of the node with its unit; one that is no length and no speed stays what it is. */
export function inUnits(value: number, unit: string): { value: number; unit: string } {
  const measure = unit === 'm' ? 'length' : unit === 'm/s' ? 'speed' : null;
  return measure === null ? { value, unit } : { value: shown(measure, value), unit: unitName(measure) };
}

// Rulers: grid, scale bar and ladder are divided at round numbers of what is shown.

/** Above so many feet a ruler is divided in nautical miles. */
const MOST_RULE_FT = 500;
const LEAST_RULE_MILES = 0.1;

/** The largest of 1, 2, 5 times a power of ten that is not above `limit`. */
export function roundStep(limit: number): number {
  const power = 10 ** Math.floor(Math.log10(limit));
  const lead = limit / power;
  return (lead >= 5 ? 5 : lead >= 2 ? 2 : 1) * power;
}

/** The smallest of 1, 2, 5 times a power of ten that is not below `least`. */
export function roundStepUp(least: number): number {
  let step = roundStep(least);
  while (step < least) step = roundStep(step * 2.5);
  return step;
}

/** The longest round step, in metres, that is not above a limit. */
export function ruleStep(limitM: number): number {
  if (metric()) return roundStep(limitM);
  return limitM >= LEAST_RULE_MILES * MILE_M ? roundStep(limitM / MILE_M) * MILE_M : roundStep(limitM / FOOT_M) * FOOT_M;
}

/** The shortest round step, in metres, that is not below `leastM`. */
export function ruleStepUp(leastM: number): number {
  if (metric()) return roundStepUp(leastM);
  return leastM > MOST_RULE_FT * FOOT_M ? roundStepUp(leastM / MILE_M) * MILE_M : roundStepUp(leastM / FOOT_M) * FOOT_M;
}

/** A length on a ruler whose finest step is `stepM`: all of it is read in one unit. */
export function ruleText(metres: number, stepM: number): string {
  const round = (value: number): number => Math.round(value * 1000) / 1000;
  if (!metric()) return stepM > (MOST_RULE_FT + 1) * FOOT_M ? `${round(metres / MILE_M)} NM` : `${round(metres / FOOT_M)} ft`;
  if (metres >= 1000) return `${round(metres / 1000)} km`;
  if (metres < 1) return `${Math.round(metres * 100)} cm`;
  return `${round(metres)} m`;
}
