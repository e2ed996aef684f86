// Scenes that are read from files.

import { Boxes } from './core/boxes.js';
import { Engine } from './core/engine.js';
import { CulletError } from './core/error.js';
import { OPENED, Scenes } from './core/scene.js';

export { CulletError } from './core/error.js';
export { STAGES, View } from './core/view.js';

// Bundlers look for this very form.
const engine = new Engine(() => new URL('./cullet-files.wasm', import.meta.url));

export const init = (source) => engine.init(source);

export class BoxSet extends Boxes {
  constructor(length) { super(engine, length); }
}

export class Scene extends Scenes {
  constructor(opened) { super(engine, opened); }

  static open(bytes, name = 'model.glb') {
    void engine.wasm;
    const file = bytes instanceof ArrayBuffer ? new Uint8Array(bytes) : bytes;
    if (!(file instanceof Uint8Array)) throw new CulletError('argument', `a file must be a Uint8Array or an ArrayBuffer, and is ${typeof bytes}`);
    const words = new TextEncoder().encode(String(name));
    const at = engine.scratch(words.length + file.length);
    const to = new Uint8Array(engine.buffer, at, words.length + file.length);
    to.set(words);
    to.set(file, words.length);
    engine.check('file_open', words.length, file.length);
    return new Scene({ [OPENED]: engine.wasm.answer_at() });
  }
}
