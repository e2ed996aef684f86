// Boxes against planes, and behind occluders: no scene.

import { Boxes } from './core/boxes.js';
import { Engine } from './core/engine.js';
import { OccluderSet as Occluders } from './core/occluders.js';

export { CulletError } from './core/error.js';

// Bundlers look for this very form.
const engine = new Engine(() => new URL('./cullet-boxes.wasm', import.meta.url));

export const init = (source) => engine.init(source);

export class BoxSet extends Boxes {
  constructor(length) { super(engine, length); }
}

export class OccluderSet extends Occluders {
  constructor(width, height) { super(engine, width, height); }
}
