// The engine of this entry: boxes, and scenes that tell which instances are visible, without clusters, draws and explanations.

import { Boxes } from '../core/boxes.js';
import { Engine } from '../core/engine.js';
import { Scenes } from '../core/scene.js';

// Bundlers look for this very form.
const engine = new Engine(() => new URL('../cullet-three.wasm', import.meta.url));

export const load = (source) => engine.init(source);

export class BoxSet extends Boxes {
  constructor(length) { super(engine, length); }
}

export class Scene extends Scenes {
  constructor() { super(engine); }
}
