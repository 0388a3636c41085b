// Whether real vehicles are commanded: what the nodes say of each. Must never take a vehicle for simulated that is not said to be. Pure.

import type { VehicleInfo } from '../protocol/types';

export type Reality = { real: number; simulated: number };

export function realityOf(vehicles: readonly Pick<VehicleInfo, 'simulated'>[]): Reality {
  const simulated = vehicles.filter((vehicle) => vehicle.simulated === true).length;
  return { real: vehicles.length - simulated, simulated };
}
