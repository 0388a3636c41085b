// The language of the page. English stands in the code; another language is a dictionary from it, fetched when it is chosen. What the
// program itself says (events, refusals it words) is shown as it came. Must never change a name, a number or a code of the protocol.

import type { Dictionary } from './de';
import { chosenLanguage, rememberLanguage } from './choice';
import type { LanguageName } from './choice';

/** Every text there is a translation of; anything else is refused by the type checker. */
type Known = Extract<keyof Dictionary, string>;
/** Those without a place for a value. */
export type Text = Exclude<Known, `${string}{${string}}${string}`>;

/** The names in braces in a text. */
type Names<T extends string> = T extends `${string}{${infer Name}}${infer Rest}` ? Name | Names<Rest> : never;
type Values<T extends string> = [Names<T>] extends [never] ? [] : [Record<Names<T>, string | number>];

class Language {
  name = $state<LanguageName>('en');
  #words = $state.raw<Readonly<Record<string, string>>>({});

  async start(): Promise<void> {
    await this.#apply(chosenLanguage());
  }

  async choose(name: LanguageName): Promise<void> {
    rememberLanguage(name);
    await this.#apply(name);
  }

  /** Without its dictionary the page stays in the language it is in. */
  async #apply(name: LanguageName): Promise<void> {
    try {
      const { de, codes } = name === 'de' ? await import('./de') : { de: {}, codes: {} };
      this.#words = { ...codes, ...de };
    } catch {
      return;
    }
    this.name = name;
    document.documentElement.lang = name;
  }

  /** What `text` is in the language of the page, or the text itself. */
  of(text: string): string {
    return this.#words[text] ?? text;
  }
}

export const language = new Language();

/** A text of the page in its language, the names in braces replaced by their values. */
export function t<T extends Known>(text: T, ...values: Values<T>): string {
  const given: Record<string, string | number> = values[0] ?? {};
  return language.of(text).replace(/\{(\w+)\}/g, (name, key: string) => String(given[key] ?? name));
}

/** A word for a code of the protocol; one that is not known is shown as it is. */
export function said(word: string): string {
  return language.of(word);
}
