// The words an operator reads for how the reading of parameters stands, and for why one was not written.
// Must never guess: what is not known here is shown as the server says it.

import { said, t } from '../../language/language.svelte';
import { ApiError } from '../../protocol/rest';
import type { ParameterValue, Refusal } from '../../protocol/types';
import { refusalText } from '../../protocol/words';
import { valueText } from './parameterLines';
import type { Known, Problem } from './parameterLines';

type Fact = Record<string, unknown>;

const value = (fact: unknown): string => (typeof fact === 'object' && fact !== null && 'type' in fact ? valueText(fact as ParameterValue) : '?');
const text = (fact: unknown): string => (typeof fact === 'string' ? fact : '');

/** Why it was refused, in the language of the page. */
export function errorText(error: unknown): string {
  if (!(error instanceof ApiError)) return String(error);
  const fact = error.detail as Fact | null;
  if (fact === null || typeof fact !== 'object' || typeof fact.reason !== 'string') return error.message;
  const name = text(fact.name);
  switch (fact.reason) {
    case 'armed':
      return t('{name} is not written while the vehicle is armed: disarm it first', { name });
    case 'unknown':
      return t('the autopilot has no parameter {name}', { name });
    case 'no_answer':
      return t('no answer about {name}; the autopilot may not have it', { name });
    case 'wrong_type':
      return t('{name} is {type}: {value} does not fit', { name, type: said(text(fact.actual)), value: value(fact.value) });
    case 'out_of_range':
      return t('{value} is out of the range of {name}', { name, value: value(fact.value) });
    case 'not_taken':
      return t('the autopilot keeps {name} at {kept} instead of {asked}', { name, kept: value(fact.kept), asked: value(fact.asked) });
    case 'busy':
      return t('too many writes are waiting already');
    case 'broken_off':
      return t('broken off: {why}', { why: text(fact.why) });
    case 'invalid_name':
      return error.message;
    default:
      return refusalText(fact as Refusal);
  }
}

/** What is wrong with what was typed. */
export function problemText(problem: Problem): string {
  switch (problem) {
    case 'empty':
      return t('Type a value.');
    case 'no_number':
      return t('That is no number.');
    case 'not_whole':
      return t('This parameter takes whole numbers.');
    case 'too_large':
      return t('That is more than 32 bits hold.');
  }
}

/** How the reading stands. */
export function readingText({ reading, read, total }: Known): string {
  const of = { read, total: total ?? '?' };
  switch (reading.state) {
    case 'not_begun':
      return t('Not read yet.');
    case 'reading':
      return total === null ? t('Asking the autopilot') : t('Reading, {read} of {total}', of);
    case 'complete':
      return t('All {total} read', of);
    case 'ended':
      return t('Read {read} of {total}: {why}', { ...of, why: said(reading.why) });
  }
}

/** The type as it is shown. */
export function typeText(type: ParameterValue['type']): string {
  return type === 'integer' ? t('whole') : t('real');
}
