import { Boxes } from './boxes.js';
import { numbers, options, typed, whole, word } from './check.js';
import { CulletError } from './error.js';

const DEPTHS = ['standard', 'reversed', 'webgl'];
const NONE = 2 ** 32 - 2;

const lost = new FinalizationRegistry(({ engine, number }) => {
  try { engine.call('occluders_free', number); } catch { /* The engine is gone, and all with it. */ }
});

const finite = (what, values) => {
  const at = values.findIndex((v) => !Number.isFinite(Math.fround(v)));
  if (at >= 0) throw new CulletError('argument', `number ${at} of ${what} is ${values[at]}; it must be finite`);
};

export class OccluderSet {
  #engine;
  #number;
  #list;

  constructor(engine, width, height) {
    void engine.wasm;
    whole('the width of the buffer', width, 1, 4096);
    whole('the height of the buffer', height, 1, 4096);
    this.#engine = engine;
    this.#number = engine.call('occluders_new', width, height);
    if (this.#number === 0) throw new CulletError('memory', `no memory for a buffer of ${width} x ${height} pixels`);
    lost.register(this, { engine, number: this.#number }, this);
  }

  get isDisposed() { return this.#number === 0; }

  #live() {
    if (this.#number === 0) throw new CulletError('disposed', 'this OccluderSet was disposed of');
    return this.#number;
  }

  #added(number) {
    if (number > NONE) throw new CulletError('memory', 'no memory for these triangles');
    if (number === NONE) throw new CulletError('argument', 'this is no occluder');
    return number;
  }

  addBox(corners) {
    const set = this.#live();
    numbers('a box', corners, 6);
    finite('a box', corners);
    for (let a = 0; a < 3; a++) {
      if (corners[a] > corners[a + 3]) throw new CulletError('argument', `the least ${'xyz'[a]} of a box, ${corners[a]}, is above its greatest, ${corners[a + 3]}`);
    }
    const at = this.#engine.scratch(24);
    new Float32Array(this.#engine.buffer, at, 6).set(corners);
    return this.#added(this.#engine.call('occluders_add_box', set));
  }

  addTriangles(positions, indices, given) {
    const set = this.#live();
    const { twoSided = true } = options('the options of triangles', given, ['twoSided']);
    typed('positions', positions, Float32Array, 3);
    finite('positions', positions);
    const triangles = indices instanceof Uint16Array ? Uint32Array.from(indices) : typed('indices', indices, Uint32Array, 3);
    const vertices = positions.length / 3;
    triangles.forEach((v, i) => { if (v >= vertices) throw new CulletError('argument', `index ${i} is ${v}, but there are ${vertices} vertices`); });
    const at = this.#engine.scratch((positions.length + triangles.length) * 4);
    new Float32Array(this.#engine.buffer, at, positions.length).set(positions);
    new Uint32Array(this.#engine.buffer, at + positions.length * 4, triangles.length).set(triangles);
    return this.#added(this.#engine.call('occluders_add', set, vertices, triangles.length, twoSided ? 1 : 0));
  }

  #matrix(what, matrix) {
    numbers(what, matrix, 16);
    const at = this.#engine.scratch(128);
    new Float64Array(this.#engine.buffer, at, 16).set(matrix);
  }

  #there(id, call, ...values) {
    const set = this.#live();
    whole('the id of an occluder', id, 0, 2 ** 32 - 1);
    if (!this.#engine.call(call, set, id, ...values)) throw new CulletError('id', `id ${id} names no occluder of this set, or it was removed`);
  }

  setMatrix(id, matrix) {
    this.#live();
    this.#matrix('a matrix', matrix);
    this.#there(id, 'occluders_place');
  }

  remove(id) { this.#there(id, 'occluders_remove'); }

  draw(clipFromWorld, depth = 'standard') {
    const set = this.#live();
    const at = word('depth', depth, DEPTHS);
    this.#matrix('clipFromWorld', clipFromWorld);
    if (!this.#engine.call('occluders_draw', set, at)) {
      throw new CulletError('camera', 'clipFromWorld shows no volume: a number is not finite, it has no inverse, or its near plane is at the other end of the depth range');
    }
    return this.#engine.wasm.answer_len();
  }

  visible(set, view = 0) {
    const occluders = this.#live();
    if (!(set instanceof Boxes)) throw new CulletError('argument', 'visible() takes a BoxSet, then the number of a view');
    whole('the view', view, 0, 1023);
    const engine = this.#engine;
    engine.call('boxes_hide', set.numberIn(engine), view, occluders);
    const { wasm } = engine;
    const [at, length] = [wasm.answer_at(), wasm.answer_len()];
    const list = this.#list;
    if (list && list.buffer === wasm.memory.buffer && list.byteOffset === at && list.length === length) return list;
    return (this.#list = new Uint32Array(wasm.memory.buffer, at, length));
  }

  dispose() {
    if (this.#number === 0) return;
    lost.unregister(this);
    const number = this.#number;
    this.#number = 0;
    this.#list = undefined;
    this.#engine.call('occluders_free', number);
  }

  [Symbol.dispose ?? Symbol.for('Symbol.dispose')]() { this.dispose(); }
}
