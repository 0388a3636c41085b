// Light or dark: the system's wish until the operator chooses; the choice is kept in the browser.

const KEY = 'skein-theme';

export type ThemeName = 'dark' | 'light';

function stored(): ThemeName | null {
  try {
    const value = localStorage.getItem(KEY);
    return value === 'dark' || value === 'light' ? value : null;
  } catch {
    return null; // storage can be forbidden; the page works without
  }
}

export class Theme {
  name = $state<ThemeName>('dark');

  constructor() {
    const light = matchMedia('(prefers-color-scheme: light)');
    this.name = stored() ?? (light.matches ? 'light' : 'dark');
    light.addEventListener('change', () => {
      if (!stored()) this.#apply(light.matches ? 'light' : 'dark');
    });
    this.#apply(this.name);
  }

  toggle(): void {
    this.#apply(this.name === 'dark' ? 'light' : 'dark');
    try {
      localStorage.setItem(KEY, this.name);
    } catch {
      // not kept, that is all
    }
  }

  #apply(name: ThemeName): void {
    this.name = name;
    document.documentElement.dataset.theme = name;
  }
}
