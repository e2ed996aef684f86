// Arguments, before they reach the module.

import { CulletError } from './error.js';

const shown = (value) => (ArrayBuffer.isView(value) ? `${value.constructor.name} of ${value.length}` : Array.isArray(value) ? `an array of ${value.length}` : typeof value === 'number' ? String(value) : Object.prototype.toString.call(value).slice(8, -1).toLowerCase());

/** A whole number of a range. */
export function whole(what, value, least, most) {
  if (!(Number.isInteger(value) && value >= least && value <= most)) {
    throw new CulletError('argument', `${what} is ${shown(value)}; it must be a whole number from ${least} to ${most}`);
  }
  return value;
}

/** Numbers, in an ordinary array or in one of f32 or f64, of a length. */
export function numbers(what, value, length) {
  if (!(value instanceof Float32Array || value instanceof Float64Array || Array.isArray(value))) {
    throw new CulletError('argument', `${what} must be a Float32Array, a Float64Array or an array of numbers, and is ${shown(value)}`);
  }
  if (length !== undefined && value.length !== length) {
    throw new CulletError('argument', `${what} has ${value.length} numbers; it must have ${length}`);
  }
  return value;
}

/** An array of one type; ordinary arrays are taken over. */
export function typed(what, value, Type, each = 1) {
  const array = Array.isArray(value) ? Type.from(value) : value;
  if (!(array instanceof Type)) throw new CulletError('argument', `${what} must be a ${Type.name}, and is ${shown(value)}`);
  if (array.length % each !== 0) throw new CulletError('argument', `${what} has ${array.length} numbers, which is not a multiple of ${each}`);
  return array;
}

/** One of some words: its place among them. */
export function word(what, value, words) {
  const at = words.indexOf(value);
  if (at < 0) throw new CulletError('argument', `${what} is ${JSON.stringify(value) ?? 'undefined'}; it must be one of ${words.join(', ')}`);
  return at;
}

/** Options of known names. */
export function options(what, given, known) {
  if (given === undefined) return {};
  if (typeof given !== 'object' || given === null) throw new CulletError('argument', `${what} must be an object, and is ${shown(given)}`);
  for (const name of Object.keys(given)) {
    if (!known.includes(name)) throw new CulletError('argument', `${what} has no ${name}; there are ${known.join(', ')}`);
  }
  return given;
}
