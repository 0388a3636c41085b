// Who sits at this page, as other operators see it: the tab is a console with an id of its own (`model/tab`), its operator has a name, which is
// kept in the browser.

import { remember, rememberedText } from '../app/remembered';
import type { Console } from '../protocol/types';
import { tabId } from './tab';

const NAME_KEY = 'skein-operator';
/** More the node does not take, of either. */
const MOST_BYTES = 64;

/** What the node takes for a name: nothing that cannot be shown, and not too long. Empty if nothing is left. */
export function soundName(text: string): string {
  const encoder = new TextEncoder();
  let name = '';
  let bytes = 0;
  for (const char of text.replace(/\p{Cc}/gu, ' ').trim()) {
    bytes += encoder.encode(char).length;
    if (bytes > MOST_BYTES) break;
    name += char;
  }
  return name.trim();
}

export class Operator {
  readonly id: string;
  /** As it was given by hand; empty if it was not. */
  given = $state('');

  constructor(id = tabId()) {
    this.id = id;
    this.given = soundName(rememberedText(NAME_KEY) ?? '');
  }

  get name(): string {
    return this.given === '' ? `Console ${this.id.slice(0, 4)}` : this.given;
  }

  rename(text: string): void {
    this.given = soundName(text);
    remember(NAME_KEY, this.given);
  }

  /** As the node is told. */
  wire(): Console {
    return { id: this.id, name: this.name };
  }
}
