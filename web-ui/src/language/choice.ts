// Which language the page is in. Of no framework, since its dictionary is fetched before the page is there.

import { remember, remembered } from '../app/remembered';

export const LANGUAGES = ['en', 'de'] as const;
export type LanguageName = (typeof LANGUAGES)[number];

const KEY = 'skein-language';

/** The language chosen before, else the first of the browser's that there is. */
export function chosenLanguage(): LanguageName {
  const wanted = navigator.languages.map((tag) => LANGUAGES.find((name) => tag.toLowerCase().startsWith(name)));
  return remembered(KEY, LANGUAGES) ?? wanted.find((name) => name !== undefined) ?? 'en';
}

export function rememberLanguage(name: LanguageName): void {
  remember(KEY, name);
}
