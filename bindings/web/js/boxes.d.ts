import type { BoxSet, Disposal, Numbers } from './core/boxes.js';

export { BoxSet, CulletError, init, type CulletErrorCode, type Numbers, type Source } from './core/boxes.js';

/**
 * Occluders, and the buffer that they are drawn into: which boxes of a {@link BoxSet} they hide from a camera.
 *
 * Conservative at every resolution: a box is hidden only where all of it that is in view is proved to lie behind occluders, so
 * no sample of an image of any size would have shown it. What an occluder hides must be opaque; give shapes that lie within
 * what is drawn.
 *
 * ```js
 * import { BoxSet, init, OccluderSet } from 'cullet/boxes';
 *
 * await init();
 * const set = new BoxSet(100);
 * for (let i = 0; i < 100; i++) set.boxes.set([i - 50, 0, -20, i - 49.5, 1, -19], 6 * i);
 * set.commit();
 * const occluders = new OccluderSet(640, 360);
 * occluders.addBox([-5, -1, -11, 5, 4, -10]);
 * // Each frame: planes as in THREE.Frustum, then the camera, world to clip space.
 * set.cull([1, 0, 0, 40, -1, 0, 0, 40, 0, 1, 0, 9, 0, -1, 0, 9, 0, 0, 1, 99, 0, 0, -1, 0]);
 * occluders.draw([1, 0, 0, 0, 0, 1.8, 0, 0, 0, 0, -1, -1, 0, 0, -0.1, 0]);
 * const visible = occluders.visible(set);
 * ```
 */
export class OccluderSet {
  /**
   * A buffer of so many pixels, 1 to 4096 each way. A half or a quarter of the screen's proves nearly as much; its shape should be
   * that of the screen. Two to three bytes a pixel.
   *
   * @throws {CulletError} `not-ready`, `argument`, `memory`.
   */
  constructor(width: number, height: number);
  readonly isDisposed: boolean;
  /**
   * Adds a box: x, y, z of its least corner, then of its greatest, in its own space. The cheapest occluder.
   *
   * @returns its id, which no later one takes.
   * @throws {CulletError} `argument` for a number that is not finite, and for corners the wrong way round.
   */
  addBox(corners: Numbers): number;
  /**
   * Adds triangles: positions, three numbers each, and corners. What closes a convex body is drawn as one, all else as a surface in
   * which neighbours cover pixels together; a microsecond a triangle, once.
   *
   * @param options `twoSided: false`: they hide only from where they are counter-clockwise. Default true.
   * @returns its id, which no later one takes.
   * @throws {CulletError} `argument` for numbers that are not finite and for indices without a vertex, `memory`.
   */
  addTriangles(positions: Float32Array, indices: Uint32Array | Uint16Array | readonly number[], options?: { twoSided?: boolean }): number;
  /** Places an occluder: its own space to the world, column-major. Where it is added it stands at the origin. O(shapes). */
  setMatrix(id: number, matrix: Numbers): void;
  /** Removes an occluder. O(shapes). */
  remove(id: number): void;
  /**
   * Empties the buffer, turns it to a camera and draws what is in view, the nearest first, without what is hidden by then.
   *
   * @param clipFromWorld world to clip space, column-major.
   * @param depth `standard` 0 to 1 (default), `reversed` 1 to 0, `webgl` −1 to 1.
   * @returns how many shapes were drawn.
   * @throws {CulletError} `camera` for a matrix that shows no volume; the buffer stays as it was.
   */
  draw(clipFromWorld: Numbers, depth?: 'standard' | 'reversed' | 'webgl'): number;
  /**
   * Of the boxes that the last {@link BoxSet.cull} of a view listed, those that are not hidden, ascending; all before the first
   * {@link draw}.
   *
   * @returns a view of the engine's memory, good until the next call for this view, or until the memory grows.
   */
  visible(set: BoxSet, view?: number): Uint32Array;
  /** Gives the memory back to the engine; a forgotten set is disposed of when it is collected. Further calls throw `disposed`. */
  dispose(): void;
}
export interface OccluderSet extends Disposal {}
