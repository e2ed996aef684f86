import { numbers, whole } from './check.js';
import { CulletError } from './error.js';

// Numbers that were freed with the object that held them.
const lost = new FinalizationRegistry(({ engine, number }) => {
  try { engine.call('boxes_free', number); } catch { /* The engine is gone, and all with it. */ }
});

export class Boxes {
  #engine;
  #set;
  #length;
  #buffer;
  #boxes;
  #matrices;
  #planes;
  #planesAt = 0;
  // The list of each view, made anew only where memory, place or length changed: a frame allocates nothing.
  #lists = [];

  constructor(engine, length) {
    void engine.wasm;
    whole('the length of a BoxSet', length, 0, 2 ** 28);
    this.#engine = engine;
    this.#set = engine.call('boxes_new', length);
    if (this.#set === 0) throw new CulletError('memory', `no memory for ${length} boxes`);
    this.#length = length;
    lost.register(this, { engine, number: this.#set }, this);
  }

  get length() { return this.#length; }

  get isDisposed() { return this.#set === 0; }

  #live() {
    if (this.#set === 0) throw new CulletError('disposed', 'this BoxSet was disposed of');
    return this.#set;
  }

  /** For occluders: the number of a set that is there, in an engine. */
  numberIn(engine) {
    if (engine !== this.#engine) throw new CulletError('argument', 'this BoxSet is of another entry of the package: import both from one');
    return this.#live();
  }

  // Views are empty once the memory grew, which any object may cause: made again where that happened.
  #views() {
    const { buffer } = this.#engine;
    if (this.#buffer === buffer) return;
    this.#buffer = buffer;
    this.#boxes = this.#matrices = this.#planes = undefined;
  }

  get boxes() {
    const set = this.#live();
    this.#views();
    this.#boxes ??= new Float32Array(this.#buffer, this.#engine.call('boxes_at', set), 6 * this.#length);
    return this.#boxes;
  }

  get matrices() {
    const set = this.#live();
    this.#views();
    if (!this.#matrices) {
      const at = this.#engine.call('boxes_matrices', set);
      if (at === 0) throw new CulletError('memory', `no memory for ${this.#length} matrices`);
      this.#views();
      this.#matrices = new Float32Array(this.#buffer, at, 16 * this.#length);
    }
    return this.#matrices;
  }

  #commit(first, count, moved) {
    const set = this.#live();
    whole('the first box', first, 0, this.#length);
    whole(`the number of boxes from ${first} on`, count, 0, this.#length - first);
    if (!this.#engine.call('boxes_commit', set, first, count, moved)) throw new CulletError('memory', `no memory for ${this.#length} matrices`);
  }

  commit(first = 0, count = this.#length - first) { this.#commit(first, count, 0); }

  commitMoved(first = 0, count = this.#length - first) { this.#commit(first, count, 1); }

  sort() { this.#engine.call('boxes_sort', this.#live()); }

  cull(planes, view = 0) {
    const set = this.#live();
    numbers('planes', planes, 24);
    whole('the view', view, 0, 1023);
    const engine = this.#engine;
    const at = engine.scratch(192);
    this.#views();
    if (!this.#planes || this.#planesAt !== at) {
      this.#planes = new Float64Array(this.#buffer, at, 24);
      this.#planesAt = at;
    }
    this.#planes.set(planes);
    engine.call('boxes_cull', set, view);
    const { wasm } = engine;
    const [start, length] = [wasm.answer_at(), wasm.answer_len()];
    const list = this.#lists[view];
    if (list && list.buffer === wasm.memory.buffer && list.byteOffset === start && list.length === length) return list;
    return (this.#lists[view] = new Uint32Array(wasm.memory.buffer, start, length));
  }

  forget(view = 0) {
    whole('the view', view, 0, 1023);
    this.#engine.call('boxes_forget', this.#live(), view);
    this.#lists[view] = undefined;
  }

  dispose() {
    if (this.#set === 0) return;
    lost.unregister(this);
    const set = this.#set;
    this.#set = 0;
    this.#length = 0;
    this.#lists.length = 0;
    this.#boxes = this.#matrices = this.#planes = this.#buffer = undefined;
    this.#engine.call('boxes_free', set);
  }

  [Symbol.dispose ?? Symbol.for('Symbol.dispose')]() { this.dispose(); }
}
