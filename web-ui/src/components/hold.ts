// How long a guarded button must be held. One figure for every button of the page.

export const HOLD_MS = 800;
