// From a plugin's JSON Schema to a panel: what can be asked of it, with which figures, in which units; and what it says of its state. Pure.
//
// What is understood of JSON Schema 2020-12, as schemars makes it: `$ref` into `$defs`; `oneOf` whose members differ in a constant; objects,
// in which constants are kept and objects within are laid flat; numbers, integers, switches, texts and choices; null for "left out". Whatever
// else there is can be typed as JSON. Beside it the hints `x-unit`, `x-order`, `x-danger` (hold) and `x-when` (armed, airborne, ground).
// The node checks what is sent: a form that is wrong here is refused there. Must never run anything that comes with a schema.

import { spoken } from '../../protocol/words';
import { unitOf } from './units';

type Json = Record<string, unknown>;

export type Choice = { value: unknown; words: string; help: string };

export type Field = {
  /** Where it stands in the command. */
  path: readonly string[];
  words: string;
  help: string;
  kind: 'number' | 'integer' | 'switch' | 'choice' | 'text' | 'json' | 'variant';
  required: boolean;
  unit: string;
  /** A value of the schema times this is what is shown. */
  scale: number;
  /** As shown. */
  min: number | null;
  max: number | null;
  initial: unknown;
  choices: readonly Choice[];
  variants: readonly Form[];
};

export type Form = {
  key: string;
  words: string;
  help: string;
  /** What is always part of it: a value, or an object that the fields are put into. */
  fixed: unknown;
  fields: readonly Field[];
  danger: 'none' | 'hold';
  when: 'always' | 'armed' | 'airborne' | 'ground';
  order: number;
};

const isJson = (value: unknown): value is Json => typeof value === 'object' && value !== null && !Array.isArray(value);
const text = (value: unknown): string => (typeof value === 'string' ? value : '');
const capital = (words: string): string => words.charAt(0).toUpperCase() + words.slice(1);

/** How deep objects may lie within each other; a schema may refer to itself. */
const DEEPEST = 4;

export class SchemaReader {
  readonly #defs: Json;

  constructor(readonly root: Json) {
    this.#defs = isJson(root.$defs) ? root.$defs : {};
  }

  /** A schema with its reference followed; what stands beside the reference wins. */
  #follow(schema: unknown): Json {
    if (!isJson(schema)) return {};
    const name = /^#\/\$defs\/(.+)$/.exec(text(schema.$ref))?.[1];
    const target = name === undefined ? undefined : this.#defs[name];
    return isJson(target) ? { ...this.#follow(target), ...schema, $ref: undefined } : schema;
  }

  /** Everything that can be asked. */
  forms(): Form[] {
    return this.#formsOf(this.root, 0).sort((a, b) => a.order - b.order);
  }

  #formsOf(schema: unknown, depth: number): Form[] {
    const whole = this.#follow(schema);
    const members = [whole.oneOf, whole.anyOf].find(Array.isArray) as unknown[] | undefined;
    if (members) return members.flatMap((member) => this.#formsOf(member, depth));
    if (Array.isArray(whole.enum)) return whole.enum.map((value, k) => form(whole, String(value), value, [], k));
    if ('const' in whole) return [form(whole, String(whole.const), whole.const, [], 0)];
    if (!isJson(whole.properties)) return [];
    const { fixed, fields } = this.#inside(whole, [], depth);
    const tag = Object.values(fixed)[0];
    return [form(whole, typeof tag === 'string' ? tag : text(whole.title) || 'send', fixed, fields, 0)];
  }

  /** What is constant in an object, and a field for all the rest; objects within are laid flat. */
  #inside(schema: Json, path: readonly string[], depth: number): { fixed: Json; fields: Field[] } {
    const fixed: Json = {};
    const fields: Field[] = [];
    const required = Array.isArray(schema.required) ? schema.required : [];
    for (const [name, raw] of Object.entries(isJson(schema.properties) ? schema.properties : {})) {
      const own = this.#follow(raw);
      if ('const' in own) fixed[name] = own.const;
      else if (isJson(own.properties) && required.includes(name) && depth < DEEPEST) {
        const within = this.#inside(own, [...path, name], depth + 1);
        fields.push(...within.fields);
        if (Object.keys(within.fixed).length > 0) fixed[name] = within.fixed;
      } else if (own.readOnly !== true) fields.push(this.#field(name, own, [...path, name], required.includes(name), depth));
    }
    return { fixed, fields };
  }

  #field(name: string, raw: Json, path: readonly string[], required: boolean, depth: number): Field {
    const { schema, nullable } = this.#withoutNull(raw);
    const { words, unit, scale } = unitOf(name, text(raw['x-unit']));
    const shown = (value: unknown): number | null => (typeof value === 'number' ? value * scale : null);
    const said = text(raw.description) || text(schema.description);
    const base: Field = {
      path, words: capital(words), help: scale === 1 ? said : said.replace(/\bradians\b/g, 'degrees'), kind: 'json', required: required && !nullable, unit,
      scale, min: shown(schema.minimum), max: shown(schema.maximum), initial: raw.default ?? null, choices: [], variants: [],
    };
    const choices = this.#choices(schema);
    if (choices) return { ...base, kind: 'choice', choices };
    if (Array.isArray(schema.oneOf) && depth < DEEPEST) return { ...base, kind: 'variant', variants: this.#formsOf(schema, depth + 1) };
    if (schema.type === 'number' || schema.type === 'integer') return { ...base, kind: schema.type };
    if (schema.type === 'boolean') return { ...base, kind: 'switch', initial: raw.default ?? false };
    return schema.type === 'string' ? { ...base, kind: 'text' } : base;
  }

  /** `X or null` is X that may be left out. */
  #withoutNull(schema: Json): { schema: Json; nullable: boolean } {
    if (Array.isArray(schema.type) && schema.type.includes('null')) {
      return { schema: { ...schema, type: schema.type.find((type) => type !== 'null') }, nullable: true };
    }
    const members = Array.isArray(schema.anyOf) ? schema.anyOf : [];
    const other = members.filter((member) => !isJson(member) || member.type !== 'null');
    if (members.length !== 2 || other.length !== 1) return { schema, nullable: false };
    return { schema: this.#follow(other[0]), nullable: true };
  }

  /** The values of an enumeration, with what is said of each. */
  #choices(schema: Json): Choice[] | null {
    const plain = (value: unknown): Choice => ({ value, words: capital(spoken(String(value))), help: '' });
    if (Array.isArray(schema.enum)) return schema.enum.map(plain);
    if (!Array.isArray(schema.oneOf)) return null;
    const members = schema.oneOf.map((member) => this.#follow(member));
    if (!members.every((member) => 'const' in member)) return null;
    return members.map((member) => ({ ...plain(member.const), help: text(member.description) }));
  }
}

function form(schema: Json, key: string, fixed: unknown, fields: Field[], order: number): Form {
  const when = (['armed', 'airborne', 'ground'] as const).find((state) => state === schema['x-when']);
  return {
    key, words: capital(spoken(key)), help: text(schema.description), fixed, fields, danger: schema['x-danger'] === 'hold' ? 'hold' : 'none',
    when: when ?? 'always', order: typeof schema['x-order'] === 'number' ? schema['x-order'] : order,
  };
}

/** The forms of a schema as it comes over the wire; none if it cannot be read. */
export function formsOf(schemaJson: string | null): Form[] {
  if (schemaJson === null) return [];
  try {
    const schema: unknown = JSON.parse(schemaJson);
    return isJson(schema) ? new SchemaReader(schema).forms() : [];
  } catch {
    return [];
  }
}
