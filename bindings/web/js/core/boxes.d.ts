/** What {@link init} takes in place of the module that lies beside the package's JavaScript. */
export type Source =
  | string | URL | Response | ArrayBuffer | ArrayBufferView | WebAssembly.Module
  | PromiseLike<string | URL | Response | ArrayBuffer | ArrayBufferView | WebAssembly.Module>;

/** Numbers that are only read: arrays of f32 or f64, or ordinary ones such as three.js's `matrix.elements`. */
export type Numbers = Float32Array | Float64Array | readonly number[];

/**
 * Kind of a {@link CulletError}:
 *
 * | code | what to do |
 * |---|---|
 * | `argument` | mend the call: the message names the item, its value and the limit |
 * | `id` | an instance or mesh that is not there (any more) |
 * | `mesh` | triangles or positions that make no mesh |
 * | `camera` | a matrix that shows no volume, or a view without a camera |
 * | `file` | a file that is invalid or of no known kind |
 * | `limit` | a file with more triangles or instances than are read |
 * | `memory` | fewer boxes, instances or triangles: a module has 4 GiB at the most |
 * | `not-ready` | `await init()` first |
 * | `disposed` | the object was disposed of |
 * | `load` | the module is not where it should be, or is another |
 * | `no-simd`, `no-wasm` | Chrome or Edge before 91, Firefox before 89, Safari before 16.4: draw without culling |
 * | `dead` | an error of ours ended the engine: load the page or worker anew, and report it |
 */
export type CulletErrorCode =
  | 'argument' | 'id' | 'mesh' | 'camera' | 'file' | 'limit' | 'memory' | 'not-ready' | 'disposed' | 'load' | 'no-simd' | 'no-wasm' | 'dead';

/** What every call of this package throws where it refuses. Nothing has changed then, unless the call says so. */
export class CulletError extends Error {
  constructor(code: CulletErrorCode, message: string, options?: ErrorOptions);
  readonly name: 'CulletError';
  /** For programs; `message` is for people. */
  readonly code: CulletErrorCode;
}

/**
 * Loads the engine of this entry, once: later calls wait for the first. After a failure the next call tries again.
 *
 * Each entry (`cullet`, `cullet/frustum`, `cullet/boxes`, `cullet/three`, `cullet/queries`, `cullet/files`) and each worker has an engine and memory of its own.
 *
 * @param source where the module is, or the module; a compiled `WebAssembly.Module` may be sent to workers.
 * @throws {CulletError} `no-simd`, `no-wasm`, `load`.
 */
export function init(source?: Source): Promise<void>;

/** `[Symbol.dispose]`, for `using`, where the types in use know it (`lib: esnext.disposable`, Node's own); nothing where they do not. */
export type Disposal = SymbolConstructor extends { readonly dispose: infer D extends symbol } ? { [K in D]: () => void } : {};

/**
 * Boxes under fixed numbers, and which of them a frustum leaves.
 *
 * The boxes lie in a hierarchy of sixteen-fold nodes, and each view remembers what it found: a view that stands over
 * boxes that stand costs nothing, one that moves what lies at its sides. The answer is always that of testing
 * each box against each plane. Conservative: what touches the frustum is listed.
 *
 * ```js
 * import { BoxSet, init } from 'cullet/frustum';
 *
 * await init();
 * const set = new BoxSet(1000);
 * for (let i = 0; i < 1000; i++) set.boxes.set([i, 0, -5, i + 0.5, 1, -4], 6 * i);
 * set.commit();
 * // |x| ≤ 10, y and z as they are: inward normals and constants, as in THREE.Plane.
 * const visible = set.cull([1, 0, 0, 10, -1, 0, 0, 10, 0, 1, 0, 9, 0, -1, 0, 9, 0, 0, 1, 9, 0, 0, -1, 9]);
 * ```
 */
export class BoxSet {
  /**
   * Boxes that are nowhere, until they are written and committed. Some 100 bytes each.
   *
   * @throws {CulletError} `not-ready`, `argument`, `memory`.
   */
  constructor(length: number);
  /** How many boxes; 0 once disposed of. */
  readonly length: number;
  readonly isDisposed: boolean;
  /**
   * The boxes, to be written: x, y, z of the least corner, then of the greatest; six numbers each. A view of the
   * engine's memory, without a copy: **take it anew for each use**, for when the memory grows, which making any object may
   * cause, older views become empty and what is written there is lost. Takes effect with {@link commit}.
   *
   * A NaN or infinite number makes a box that is always listed; a least corner beyond the greatest one a box that never is.
   */
  readonly boxes: Float32Array;
  /** World matrices, to be written for {@link commitMoved}: column-major, sixteen numbers each. Take it anew for each use. */
  readonly matrices: Float32Array;
  /**
   * Takes boxes over, `count` from `first` on: all that remain, where it is not given. The cost is that of what is taken
   * over; of a quarter or more, that of all. Boxes that come for the first time are sorted by the next {@link cull}.
   *
   * @throws {CulletError} `argument` for a range that is not there.
   */
  commit(first?: number, count?: number): void;
  /** As {@link commit}, each box taken to the world by its matrix, and rounded outward: holds what the matrix makes of it. */
  commitMoved(first?: number, count?: number): void;
  /** Sorts the boxes by place: call it now and then where many move far, for {@link cull} to stay fast. O(length log length). */
  sort(): void;
  /**
   * The numbers of the boxes that six planes do not reject, ascending.
   *
   * @param planes 24 numbers: for each plane an inward normal and a constant, as `THREE.Plane` has them; a point is inside
   * where n·p + c ≥ 0. A plane with a number that is not finite, or without a normal, rejects nothing.
   * @param view whose memory to use, 0 to 1023: give each camera and each shadow map a number of its own.
   * @returns a view of the engine's memory, good until the next `cull` of this view, or until the memory grows. The same
   * object as before where nothing changed. Allocates nothing from frame to frame.
   */
  cull(planes: Numbers, view?: number): Uint32Array;
  /** Gives back what a view remembers. */
  forget(view?: number): void;
  /** Gives the memory back to the engine; a forgotten set is disposed of when it is collected. Further calls throw `disposed`. */
  dispose(): void;
}
export interface BoxSet extends Disposal {}
