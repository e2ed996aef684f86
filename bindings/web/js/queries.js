// Boxes, scenes with every stage, and queries of scenes.

import { Boxes } from './core/boxes.js';
import { Engine } from './core/engine.js';
import { QueryScenes } from './core/queries.js';

export { CulletError } from './core/error.js';
export { LIGHT_REASONS, NONE, QueryView as View } from './core/queries.js';
export { STAGES } from './core/view.js';

// Bundlers look for this very form.
const engine = new Engine(() => new URL('./cullet-queries.wasm', import.meta.url));

export const init = (source) => engine.init(source);

export class BoxSet extends Boxes {
  constructor(length) { super(engine, length); }
}

export class Scene extends QueryScenes {
  constructor() { super(engine); }
}
