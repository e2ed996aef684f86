// Boxes against planes: the smallest module.

import { Boxes } from './core/boxes.js';
import { Engine } from './core/engine.js';

export { CulletError } from './core/error.js';

// Bundlers look for this very form.
const engine = new Engine(() => new URL('./cullet-frustum.wasm', import.meta.url));

export const init = (source) => engine.init(source);

export class BoxSet extends Boxes {
  constructor(length) { super(engine, length); }
}
