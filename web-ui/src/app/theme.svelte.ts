// Light, dark, or for a screen the sun shines on: the system's wish until the operator chooses; the choice is kept in the browser.

import { remember, remembered } from './remembered';

const KEY = 'skein-theme';

export const THEMES = ['dark', 'light', 'sunlight'] as const;
export type ThemeName = (typeof THEMES)[number];

export class Theme {
  name = $state<ThemeName>('dark');

  constructor() {
    const light = matchMedia('(prefers-color-scheme: light)');
    const contrast = matchMedia('(prefers-contrast: more)');
    const follow = (): void => this.#apply(remembered(KEY, THEMES) ?? (contrast.matches ? 'sunlight' : light.matches ? 'light' : 'dark'));
    for (const query of [light, contrast]) query.addEventListener('change', follow);
    follow();
  }

  choose(name: ThemeName): void {
    this.#apply(name);
    remember(KEY, name);
  }

  #apply(name: ThemeName): void {
    this.name = name;
    document.documentElement.dataset.theme = name;
  }
}
