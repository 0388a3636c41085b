// How long the soak is, in seconds, and of how many vehicles.

export const SOAK_S = Number(process.env.SKEIN_SOAK_S ?? 3600);
export const VEHICLES = 50;
