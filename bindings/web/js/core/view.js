import { numbers, options, whole, word } from './check.js';
import { CulletError } from './error.js';

/** The stages by the numbers of `View.reasons`; 0 is none. */
export const STAGES = Object.freeze(['visible', 'layer', 'frustum', 'pvs', 'portal', 'detail', 'lod', 'occlusion', 'backface', 'degenerate']);
const UNITS = ['instances', 'clusters', 'triangles'];
const PRESETS = ['exact', 'balanced', 'fast'];
const DEPTHS = ['standard', 'reversed', 'webgl'];

const lost = new FinalizationRegistry(({ engine, number }) => {
  try { engine.call('view_free', number); } catch { /* The engine is gone, and all with it. */ }
});

// 0: as the engine has it.
const microseconds = (given) => (given === undefined ? 0 : numbers('drawMicroseconds', [given], 1)[0]);

const KEY = Symbol('a scene makes its views');
export const viewsOf = (engine, scene, given, Class = View) => new Class(KEY, engine, scene, given);

export class View {
  #engine;
  #scene;
  #number;
  #depth;
  #layers;
  #hasReasons;
  #matrix;
  #matrixAt = 0;
  #list;

  constructor(key, engine, scene, given) {
    if (key !== KEY) throw new CulletError('argument', 'a view is made by `scene.view()`');
    void scene.number;
    const o = options('the options of a view', given, ['preset', 'occlusion', 'output', 'reasons', 'depth', 'layers', 'drawMicroseconds']);
    this.#depth = word('depth', o.depth ?? 'standard', DEPTHS);
    this.#layers = whole('layers', o.layers ?? 2 ** 32 - 1, 0, 2 ** 32 - 1);
    const flags = (o.occlusion === false ? 1 : 0) | (o.reasons ? 2 : 0);
    this.#number = engine.call('view_new', word('preset', o.preset ?? 'balanced', PRESETS), word('output', o.output ?? 'clusters', UNITS), flags, microseconds(o.drawMicroseconds));
    [this.#engine, this.#scene, this.#hasReasons] = [engine, scene, Boolean(o.reasons)];
    lost.register(this, { engine, number: this.#number }, this);
  }

  get isDisposed() { return this.#number === 0; }

  /** For queries: the number of a view that is there. */
  get number() { return this.#live(); }

  #live() {
    if (this.#number === 0) throw new CulletError('disposed', 'this View was disposed of');
    return this.#number;
  }

  setCamera(clipFromWorld, width, height, layers = this.#layers) {
    const view = this.#live();
    numbers('clipFromWorld', clipFromWorld, 16);
    whole('the width of the viewport', width, 1, 65536);
    whole('the height of the viewport', height, 1, 65536);
    whole('layers', layers, 0, 2 ** 32 - 1);
    const engine = this.#engine;
    const at = engine.scratch(128);
    if (!this.#matrix || this.#matrixAt !== at || this.#matrix.buffer !== engine.buffer) {
      this.#matrix = new Float64Array(engine.buffer, at, 16);
      this.#matrixAt = at;
    }
    this.#matrix.set(clipFromWorld);
    engine.check('view_set_camera', view, this.#depth, width, height, layers);
    return this;
  }

  cull(scene = this.#scene) {
    const view = this.#live();
    if (scene !== this.#scene) throw new CulletError('argument', 'this view is of another scene: make one by `scene.view()`');
    const engine = this.#engine;
    engine.check('view_cull', view, scene.number);
    const { wasm } = engine;
    const [at, length] = [wasm.answer_at(), wasm.answer_len()];
    const list = this.#list;
    if (list && list.buffer === wasm.memory.buffer && list.byteOffset === at && list.length === length) return list;
    return (this.#list = new Uint32Array(wasm.memory.buffer, at, length));
  }

  get triangleCount() { return this.#engine.call('view_triangles', this.#live()); }

  reasons() {
    const view = this.#live();
    if (!this.#hasReasons) throw new CulletError('argument', 'this view records no reasons: make it by `scene.view({ reasons: true })`');
    this.#engine.check('view_reasons', view, this.#scene.number);
    return this.#engine.answer(Uint8Array);
  }

  draws() {
    const view = this.#live();
    const engine = this.#engine;
    engine.check('view_draws', view, this.#scene.number);
    const of = (which, each) => {
      engine.call('view_draws_of', view, which);
      return engine.answer(Uint32Array, each);
    };
    return { commands: of(0, 5), keys: of(1, 5), instances: of(2, 1), indices: of(3, 1) };
  }

  funnel() {
    const view = this.#live();
    this.#engine.check('view_funnel', view);
    const numbers = this.#engine.answer(Float64Array);
    const rows = [];
    for (let i = 0; i < numbers.length; i += 8) {
      const counts = (at) => ({ instances: numbers[at], clusters: numbers[at + 1], triangles: numbers[at + 2] });
      rows.push({ stage: STAGES[numbers[i]], unit: UNITS[numbers[i + 1]], entered: counts(i + 2), left: counts(i + 5) });
    }
    return rows;
  }

  explain(id) {
    const view = this.#live();
    this.#engine.check('view_explain', view, this.#scene.number, whole('an id', id, 0, 2 ** 32 - 1));
    const [reason, hiders, ...steps] = this.#engine.answerText().split('\n');
    const [stage, detail] = reason.split('\t');
    return {
      reason: stage ? { stage, detail: Number(detail) } : null,
      hiddenBy: hiders ? hiders.split('\t').map(Number) : [],
      steps: steps.map((line) => {
        const [name, unit, entered, left, ...finding] = line.split('\t');
        return { stage: name, unit, entered: Number(entered), left: Number(left), finding: finding.join('\t') };
      }),
    };
  }

  dispose() {
    if (this.#number === 0) return;
    lost.unregister(this);
    const number = this.#number;
    this.#number = 0;
    this.#list = this.#matrix = undefined;
    this.#engine.call('view_free', number);
  }

  [Symbol.dispose ?? Symbol.for('Symbol.dispose')]() { this.dispose(); }
}
