import { describe, expect, it } from 'vitest';
import type { VehicleControl } from '../protocol/types';
import { NOBODY, askingFor, divide, authorityOf, refusalsText } from './authority';

const ANNA = { id: 'a', name: 'Anna' };
const BEN = { id: 'b', name: 'Ben' };
const CLEO = { id: 'c', name: 'Cleo' };
type Name = typeof ANNA;
const control = (vehicle: number, console: Name, over: Partial<VehicleControl> = {}): VehicleControl => ({ vehicle, console, since: 0, is_heard: true, requests: [], ...over });
const none = new Set<string>();

describe('who has control authority over a vehicle', () => {
  it('is told from where one sits', () => {
    expect(authorityOf(undefined, ANNA)).toBe(NOBODY);
    expect(authorityOf(control(1, ANNA), ANNA)).toEqual({ whose: 'mine', name: 'Anna', heard: true, asked: false });
    expect(authorityOf(control(1, ANNA), BEN)).toEqual({ whose: 'others', name: 'Anna', heard: true, asked: false });
    expect(authorityOf(control(1, ANNA, { requests: [{ console: BEN, since: 5 }] }), BEN).asked).toBe(true);
    expect(authorityOf(control(1, ANNA, { requests: [{ console: BEN, since: 5 }] }), CLEO).asked).toBe(false);
  });

  it('goes by the id, whatever the name', () => {
    expect(authorityOf(control(1, { id: 'x12345', name: 'Anna' }), ANNA)).toMatchObject({ whose: 'others', name: 'Anna (x123)' });
  });

  it('does not doubt that oneself is there', () => {
    expect(authorityOf(control(1, ANNA, { is_heard: false }), ANNA).heard).toBe(true);
    expect(authorityOf(control(1, ANNA, { is_heard: false }), BEN).heard).toBe(false);
  });
});

describe('what can be done about it', () => {
  it('is to take what nobody has or who is silent, and to ask for the rest once', () => {
    const known = new Map([
      [1, control(1, ANNA)],
      [2, control(2, BEN)],
      [3, control(3, BEN, { is_heard: false })],
      [4, control(4, CLEO, { requests: [{ console: ANNA, since: 1 }] })],
      [5, control(5, CLEO, { is_heard: false, requests: [{ console: ANNA, since: 1 }] })],
    ]);
    expect(divide([1, 2, 3, 4, 5, 6], (id) => authorityOf(known.get(id), ANNA))).toEqual({
      mine: [1], others: [2, 3, 4, 5], nobodys: [6], takeable: [3, 5, 6], askable: [2], asked: [4], names: ['Ben', 'Cleo'],
    });
  });
});

describe('who asks', () => {
  const asked = [
    control(1, ANNA, { requests: [{ console: CLEO, since: 30 }, { console: BEN, since: 40 }] }),
    control(2, ANNA, { requests: [{ console: BEN, since: 20 }] }),
    control(3, BEN, { requests: [{ console: CLEO, since: 10 }] }),
  ];

  it('stands together with all that he asks for, the first first, and of others nothing', () => {
    expect(askingFor(asked, ANNA, none)).toEqual([
      { console: BEN, name: 'Ben', vehicles: [1, 2], keys: ['b 1 40', 'b 2 20'] },
      { console: CLEO, name: 'Cleo', vehicles: [1], keys: ['c 1 30'] },
    ]);
    expect(askingFor(asked, CLEO, none)).toEqual([]);
  });

  it('is not shown again for what was declined, but for asking again', () => {
    const declined = new Set(['b 1 40', 'b 2 20']);
    expect(askingFor(asked, ANNA, declined).map(({ console }) => console.name)).toEqual(['Cleo']);
    const again = [control(2, ANNA, { requests: [{ console: BEN, since: 90 }] })];
    expect(askingFor(again, ANNA, declined)).toEqual([{ console: BEN, name: 'Ben', vehicles: [2], keys: ['b 2 90'] }]);
  });
});

describe('refusals', () => {
  it('are said once each', () => {
    expect(refusalsText([{ vehicle: 1, refusal: null }])).toBe('');
    const held = { vehicle: 1, refusal: { reason: 'no_control_authority', vehicle: 1, holder: 'Ben' } } as const;
    expect(refusalsText([held])).toBe('vehicle 1 is under the control of Ben');
    const more = { vehicle: 9, refusal: { reason: 'unknown_vehicle', vehicle: 9 } } as const;
    expect(refusalsText([held, { vehicle: 2, refusal: null }, more])).toBe('vehicle 1 is under the control of Ben; and 1 more');
  });
});
