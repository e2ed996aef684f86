// Boxes, and scenes with every stage.

import { Boxes } from './core/boxes.js';
import { Engine } from './core/engine.js';
import { Scenes } from './core/scene.js';

export { CulletError } from './core/error.js';
export { STAGES, View } from './core/view.js';

// Bundlers look for this very form.
const engine = new Engine(() => new URL('./cullet.wasm', import.meta.url));

export const init = (source) => engine.init(source);

export class BoxSet extends Boxes {
  constructor(length) { super(engine, length); }
}

export class Scene extends Scenes {
  constructor() { super(engine); }
}
