// The words of the JSON side of the wire: the server's own types, generated from Rust, in the spelling the page uses.
// Must never hold behaviour: only shapes.

export type * from './generated/types';
