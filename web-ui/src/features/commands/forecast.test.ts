import { describe, expect, it } from 'vitest';
import { OFFERS } from './commandSet';
import type { Verb } from './commandSet';
import { forecast } from './forecast';
import type { Subject } from './forecast';

const subject = (id: number, over: Partial<Subject> = {}): Subject => ({
  id, airborne: false, armed: false, readyToArm: true, staleness: 'live', flightState: 'idle', stopped: false, ...over,
});
const offer = (verb: Verb) => OFFERS.find((o) => o.verb === verb)!;

describe('whom a command reaches where nothing is selected', () => {
  it('is all for what brings to safety, and nobody for anything else', () => {
    expect(OFFERS.filter((one) => one.unselected === 'all').map((one) => one.verb)).toEqual(['hold', 'land', 'return']);
  });
});

describe('what a command will do', () => {
  it('says the height and who', () => {
    const said = forecast([subject(1), subject(2), subject(3)], offer('take_off'), 12);
    expect(said).toEqual({ text: 'Arm if need be, climb to 12 m and hold there: 1–3', doubts: [], able: 3 });
  });

  it('tells who will refuse and why, and keeps nobody from trying', () => {
    const mixed = [
      subject(1), subject(2, { airborne: true, armed: true }), subject(3, { staleness: 'lost' }), subject(4, { readyToArm: false }),
      subject(5, { airborne: true, flightState: 'pilot_control' }), subject(6, { airborne: true, armed: true }),
    ];
    const said = forecast(mixed, offer('take_off'), 10);
    expect(said.able).toBe(1);
    expect(said.doubts).toEqual(['2 in the air: 2, 6', '1 not heard: 3', '1 not ready to arm: 4', '1 flown by a pilot: 5']);
    expect(forecast(mixed, offer('land'), 10).text).toBe('Land where it is: 2, 6');
    expect(forecast([subject(1)], offer('hold'), 10)).toEqual({ text: 'Stop and hold the position: nobody', doubts: ['1 on the ground: 1'], able: 0 });
  });

  it('tells what is under the control of another one, but for what anybody may command', () => {
    const three = [subject(1), subject(2), subject(3, { airborne: true, armed: true })];
    const heldBy = (id: number): string => (id === 2 ? 'Ben' : id === 3 ? 'Cleo' : '');
    expect(forecast(three, offer('take_off'), 10, heldBy)).toEqual({
      text: 'Arm if need be, climb to 10 m and hold there: 1', doubts: ['1 under the control of Ben: 2', '1 under the control of Cleo: 3'], able: 1,
    });
    for (const verb of ['hold', 'land', 'return'] as const) expect(forecast(three, offer(verb), 10, heldBy)).toEqual(forecast(three, offer(verb), 10));
  });

  it('knows what is armed already', () => {
    expect(forecast([subject(1, { armed: true })], offer('arm'), 10).doubts).toEqual(['1 armed already: 1']);
    expect(forecast([subject(1)], offer('disarm'), 10).doubts).toEqual(['1 disarmed already: 1']);
    expect(forecast([subject(1, { armed: true, readyToArm: false })], offer('take_off'), 10).able).toBe(1);
  });
});
