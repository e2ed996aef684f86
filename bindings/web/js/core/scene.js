import { numbers, options, typed, whole, word } from './check.js';
import { CulletError } from './error.js';
import { viewsOf } from './view.js';

const lost = new FinalizationRegistry(({ engine, number }) => {
  try { engine.call('scene_free', number); } catch { /* The engine is gone, and all with it. */ }
});

const ALPHA = ['opaque', 'masked', 'blended'];
const U32 = 2 ** 32 - 1;

const kindOf = ({ twoSided = true, alpha = 'opaque' }) => (twoSided ? 0 : 1) | [0, 2, 4][word('alpha', alpha, ALPHA)];
const flagsOf = (o) => (o.alwaysVisible ? 1 : 0) | (o.occluder === false ? 2 : 0) | (o.twoSided ? 4 : 0) | (o.blended ? 8 : 0) | (o.dynamic ? 16 : 0);
const STATE = ['layers', 'alwaysVisible', 'occluder', 'twoSided', 'blended', 'dynamic'];

// Says of a constructor that its number is that of a scene which is there already.
export const OPENED = Symbol('opened');

export class Scenes {
  #engine;
  #number;

  constructor(engine, opened) {
    void engine.wasm;
    this.#engine = engine;
    this.#number = opened?.[OPENED] ?? engine.call('scene_new');
    lost.register(this, { engine, number: this.#number }, this);
  }

  get isDisposed() { return this.#number === 0; }

  /** For views: the number of a scene that is there. */
  get number() {
    if (this.#number === 0) throw new CulletError('disposed', 'this Scene was disposed of');
    return this.#number;
  }

  get instanceCount() { return this.#engine.call('scene_count', this.number, 0); }
  get meshCount() { return this.#engine.call('scene_count', this.number, 1); }
  get triangleCount() { return this.#engine.call('scene_count', this.number, 2); }
  get idCount() { return this.#engine.call('scene_count', this.number, 3); }

  addMesh(positions, indices, given) {
    const scene = this.number;
    const o = options('the options of a mesh', given, ['twoSided', 'alpha', 'material', 'deformable', 'parts']);
    typed('positions', positions, Float32Array, 3);
    const triangles = indices instanceof Uint16Array ? Uint32Array.from(indices) : typed('indices', indices, Uint32Array, 3);
    const rows = o.parts ?? [{ triangles: triangles.length / 3, material: o.material ?? 0, twoSided: o.twoSided, alpha: o.alpha }];
    const parts = rows.flatMap((part, i) => {
      const p = options(`part ${i}`, part, ['triangles', 'material', 'twoSided', 'alpha']);
      return [whole(`the triangles of part ${i}`, p.triangles, 0, U32), whole(`the material of part ${i}`, p.material ?? 0, 0, U32), kindOf(p)];
    });
    const engine = this.#engine;
    const [a, b] = [positions.length, triangles.length];
    const at = engine.scratch((a + b + parts.length) * 4);
    const { buffer } = engine;
    new Float32Array(buffer, at, a).set(positions);
    const rest = new Uint32Array(buffer, at + a * 4, b + parts.length);
    rest.set(triangles);
    rest.set(parts, b);
    engine.check('scene_add_mesh', scene, a, b, parts.length, o.deformable ? 8 : 0);
    return engine.wasm.answer_at();
  }

  addBox(box) {
    const [a, b, c, x, y, z] = numbers('a box', box, 6);
    const positions = new Float32Array([a, b, c, x, b, c, a, y, c, x, y, c, a, b, z, x, b, z, a, y, z, x, y, z]);
    const indices = new Uint32Array([0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4, 2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5]);
    // What is drawn there is not known: it hides nothing, and no part of it is culled by itself.
    return this.addMesh(positions, indices, { alpha: 'masked', deformable: true });
  }

  add(mesh, matrix, given) {
    numbers('a matrix', matrix, 16);
    return this.addMany(mesh, matrix, given)[0];
  }

  addMany(mesh, matrices, given) {
    const scene = this.number;
    whole('a mesh', mesh, 0, U32);
    const o = options('the options of an instance', given, STATE);
    const count = this.#writeMatrices(matrices, 0);
    this.#engine.check('scene_add', scene, mesh, count, whole('layers', o.layers ?? 1, 0, U32), flagsOf(o));
    return this.#engine.answer(Uint32Array).slice();
  }

  /** Writes matrices to where arguments go, with room behind them; how many. */
  #writeMatrices(matrices, more) {
    numbers('matrices', matrices);
    if (matrices.length % 16 !== 0) throw new CulletError('argument', `matrices have ${matrices.length} numbers, which is not a multiple of 16`);
    const at = this.#engine.scratch(matrices.length * 8 + more);
    new Float64Array(this.#engine.buffer, at, matrices.length).set(matrices);
    return matrices.length / 16;
  }

  setTransform(id, matrix) {
    const scene = this.number;
    whole('an id', id, 0, U32);
    numbers('a matrix', matrix, 16);
    this.#writeMatrices(matrix, 4);
    const engine = this.#engine;
    new Uint32Array(engine.buffer, engine.scratch(132) + 128, 1)[0] = id;
    engine.check('scene_set_transforms', scene, 1);
  }

  setTransforms(ids, matrices) {
    const scene = this.number;
    typed('ids', ids, Uint32Array);
    numbers('matrices', matrices, ids.length * 16);
    const count = this.#writeMatrices(matrices, ids.length * 4);
    const engine = this.#engine;
    new Uint32Array(engine.buffer, engine.scratch(count * 132) + count * 128, count).set(ids);
    engine.check('scene_set_transforms', scene, count);
  }

  setState(id, given) {
    const scene = this.number;
    whole('an id', id, 0, U32);
    const o = options('the state of an instance', given, STATE);
    this.#engine.check('scene_set_state', scene, id, whole('layers', o.layers ?? 1, 0, U32), flagsOf(o));
  }

  remove(id) {
    const scene = this.number;
    this.#engine.check('scene_remove', scene, whole('an id', id, 0, U32));
  }

  commit() { this.#engine.check('scene_commit', this.number); }

  refit() { this.#engine.check('scene_refit', this.number); }

  setPlace(mesh, firstIndex, baseVertex = 0) {
    const scene = this.number;
    whole('a mesh', mesh, 0, U32);
    whole('the first index', firstIndex, 0, U32);
    whole('the base vertex', baseVertex, -(2 ** 31), 2 ** 31 - 1);
    this.#engine.check('scene_set_place', scene, mesh, firstIndex, baseVertex);
  }

  indices(mesh) {
    const scene = this.number;
    this.#engine.check('scene_indices', scene, whole('a mesh', mesh, 0, U32));
    return this.#engine.answer(Uint32Array).slice();
  }

  view(given) { return viewsOf(this.#engine, this, given); }

  cull(view) { return view.cull(this); }

  dispose() {
    if (this.#number === 0) return;
    lost.unregister(this);
    const number = this.#number;
    this.#number = 0;
    this.#engine.call('scene_free', number);
  }

  [Symbol.dispose ?? Symbol.for('Symbol.dispose')]() { this.dispose(); }
}
