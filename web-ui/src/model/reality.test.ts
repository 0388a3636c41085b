import { describe, expect, it } from 'vitest';
import type { VehicleInfo } from '../protocol/types';
import { realityOf } from './reality';

const vehicles = (...simulated: unknown[]) => simulated.map((said) => ({ simulated: said })) as Pick<VehicleInfo, 'simulated'>[];

describe('realityOf', () => {
  it('counts both kinds', () => {
    expect(realityOf(vehicles(true, false, true))).toEqual({ real: 1, simulated: 2 });
    expect(realityOf([])).toEqual({ real: 0, simulated: 0 });
  });

  it('takes for real whoever is not said to be simulated, as by a node that does not know the word', () => {
    expect(realityOf(vehicles(undefined, null, 'true', 1))).toEqual({ real: 4, simulated: 0 });
  });
});
