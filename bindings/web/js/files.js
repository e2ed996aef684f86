// Scenes that are read from files.

import { Boxes } from './core/boxes.js';
import { Engine } from './core/engine.js';
import { CulletError } from './core/error.js';
import { OPENED, Scenes } from './core/scene.js';

export { CulletError } from './core/error.js';
export { STAGES, View } from './core/view.js';

// Bundlers look for this very form.
const engine = new Engine(() => new URL('./cullet-files.wasm', import.meta.url));
const encoder = new TextEncoder();

export const init = (source) => engine.init(source);

const asBytes = (what, bytes) => {
  const file = bytes instanceof ArrayBuffer ? new Uint8Array(bytes) : bytes;
  if (!(file instanceof Uint8Array)) throw new CulletError('argument', `${what} must be a Uint8Array or an ArrayBuffer, and is ${typeof bytes}`);
  return file;
};

/** Calls an export with parts that lie one after the other where arguments go; it is told the length of each. */
const tell = (name, ...parts) => {
  const at = engine.scratch(parts.reduce((sum, part) => sum + part.length, 0));
  let to = at;
  for (const part of parts) {
    new Uint8Array(engine.buffer, to, part.length).set(part);
    to += part.length;
  }
  engine.check(name, ...parts.map((part) => part.length));
};

/** A list of files as one array: the lengths of a name and of a file, then both, for each. */
const pack = (files) => {
  const entries = Object.entries(files).map(([name, bytes]) => [encoder.encode(name), asBytes(`the file ${name}`, bytes)]);
  const all = new Uint8Array(entries.reduce((sum, [name, bytes]) => sum + 8 + name.length + bytes.length, 0));
  const view = new DataView(all.buffer);
  let at = 0;
  for (const [name, bytes] of entries) {
    view.setUint32(at, name.length, true);
    view.setUint32(at + 4, bytes.length, true);
    all.set(name, at + 8);
    all.set(bytes, at + 8 + name.length);
    at += 8 + name.length + bytes.length;
  }
  return all;
};

export function filesNamed(bytes, name = 'model.glb') {
  void engine.wasm;
  tell('file_beside', encoder.encode(String(name)), asBytes('a file', bytes));
  const text = engine.answerText();
  return text === '' ? [] : text.split('\n');
}

export function info(bytes, name = 'model.glb', files = {}) {
  void engine.wasm;
  tell('file_info', encoder.encode(String(name)), asBytes('a file', bytes), pack(files));
  return JSON.parse(engine.answerText());
}

export class BoxSet extends Boxes {
  constructor(length) { super(engine, length); }
}

export class Scene extends Scenes {
  constructor(opened) { super(engine, opened); }

  static open(bytes, name = 'model.glb') {
    void engine.wasm;
    tell('file_open', encoder.encode(String(name)), asBytes('a file', bytes));
    return new Scene({ [OPENED]: engine.wasm.answer_at() });
  }
}
