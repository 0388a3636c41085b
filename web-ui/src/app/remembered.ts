// Choices of whoever sits at this browser, kept in it. Storage can be forbidden: then they hold as long as the page is open.
// Must never keep anything of a flight.

/** What was chosen before, if it is still one of the choices. */
export function remembered<T extends string>(key: string, choices: readonly T[]): T | null {
  try {
    const value = localStorage.getItem(key);
    return choices.find((choice) => choice === value) ?? null;
  } catch {
    return null;
  }
}

/** What was written before, whatever it is. */
export function rememberedText(key: string): string | null {
  try {
    return localStorage.getItem(key);
  } catch {
    return null;
  }
}

export function remember(key: string, value: string): void {
  try {
    localStorage.setItem(key, value);
  } catch {
    // not kept, that is all
  }
}
