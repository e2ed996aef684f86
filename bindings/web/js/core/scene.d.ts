import type { Disposal, Numbers } from './boxes.js';

/** A kind of culling, in the order in which they run. */
export type Stage = 'layer' | 'frustum' | 'pvs' | 'portal' | 'detail' | 'lod' | 'occlusion' | 'backface' | 'degenerate';
/** What a stage counts. */
export type Unit = 'instances' | 'clusters' | 'triangles';

/** Names of the numbers in {@link View.reasons}: 0 is `visible`. */
export const STAGES: readonly ['visible', ...Stage[]];

/** A material's part in culling. */
export interface Surface {
  /** Whether both sides are drawn. Default true; false lets fronts turned away be culled. */
  twoSided?: boolean;
  /** Whether it hides what is behind it: only `opaque` (default) does. */
  alpha?: 'opaque' | 'masked' | 'blended';
  /** A number of yours, which {@link Draws.keys} repeat. Default 0. */
  material?: number;
}

/** Options of a mesh. */
export interface MeshOptions extends Surface {
  /** Vertices move (skinned, morphed) within the positions' box: it is culled as a whole, and hides nothing. */
  deformable?: boolean;
  /** Ranges of triangles with surfaces of their own, in order, which cover all triangles; in place of the options above. */
  parts?: readonly (Surface & { triangles: number })[];
}

/** State of an instance. */
export interface InstanceState {
  /** A bit for each layer that it is in, u32; 0 is never drawn. Default 1. */
  layers?: number;
  /** No stage but the layers may cull it. */
  alwaysVisible?: boolean;
  /** `false`: it hides nothing. */
  occluder?: boolean;
  /** Both sides are drawn, whatever its mesh says. */
  twoSided?: boolean;
  /** It is blended, whatever its mesh says. */
  blended?: boolean;
  /** It is going to move: kept apart from what stands, so that it loosens nothing there. A hint. */
  dynamic?: boolean;
}

/** Settings of a view. */
export interface ViewOptions {
  /** `exact` finds as much as can be proved, `balanced` (default) what pays, `fast` what is found soonest. None loses anything. */
  preset?: 'exact' | 'balanced' | 'fast';
  /** `false`: without occlusion. */
  occlusion?: boolean;
  /** How finely {@link View.draws} draw: whole instances, `clusters` of up to 124 triangles (default), or single triangles. */
  output?: Unit;
  /** Record {@link View.reasons}. Two bytes an instance a frame. */
  reasons?: boolean;
  /**
   * Depth in clip space: `standard` 0 to 1 (WebGPU; default), `reversed` 1 to 0, `webgl` −1 to 1 as `THREE.Camera` has it
   * under WebGL.
   */
  depth?: 'standard' | 'reversed' | 'webgl';
  /** Layers seen, u32. Default all. */
  layers?: number;
  /** Microseconds that a draw takes, by which it is decided whether occlusion pays. Default 1. */
  drawMicroseconds?: number;
}

/** Numbers of instances, of their clusters and of their triangles. */
export interface Counts { instances: number; clusters: number; triangles: number }

/** What one stage was given, and what it left to the next. */
export interface FunnelRow { stage: Stage; unit: Unit; entered: Counts; left: Counts }

/** Draws of a frame: views of the engine's memory, good until the next `draws` of this view, or until the memory grows. */
export interface Draws {
  /** Five u32 a draw, as `drawIndexedIndirect` reads them: index count, instance count, first index, base vertex (i32), first entry of `instances`. */
  commands: Uint32Array;
  /** Five u32 a draw: state (1 two-sided, 2 mirrored, 4 masked, 8 blended), material, mesh, part, level of detail. Sorted by them. */
  keys: Uint32Array;
  /** Ids that the draws refer to. */
  instances: Uint32Array;
  /** With the output `triangles`, the indices that the draws are of; else empty: they are of {@link Scene.indices}. */
  indices: Uint32Array;
}

/** Why an instance is drawn or not. */
export interface Explanation {
  /** The stage that dropped it, and for the frustum the number of the plane; null where something of it is drawn. */
  reason: { stage: Stage; detail: number } | null;
  /** Where it is hidden, the ids of what hides it, nearest first. */
  hiddenBy: number[];
  /** Every stage that it came to, with the stage's own words and numbers. */
  steps: { stage: Stage; unit: Unit; entered: number; left: number; finding: string }[];
}

/** One camera on one scene, with what it remembers from frame to frame; made by {@link Scene.view}. Use one for each camera. */
export class View {
  protected constructor();
  readonly isDisposed: boolean;
  /**
   * Sets camera and viewport.
   *
   * @param clipFromWorld world to clip space, column-major, sixteen numbers (`projectionMatrix × matrixWorldInverse`); in f64
   * where the world is large.
   * @param width of the viewport in pixels, 1 to 65,536; as is `height`.
   * @param layers those that it sees, as bits; default those of the view's options.
   * @throws {CulletError} `camera` where the matrix shows no volume; the camera stays as it was.
   */
  setCamera(clipFromWorld: Numbers, width: number, height: number, layers?: number): this;
  /**
   * The ids of what is visible, ascending: a superset of what is truly visible. A view of the engine's memory, good until
   * the next `cull` of this view, or until the memory grows. Allocates nothing from frame to frame.
   *
   * @throws {CulletError} `camera` before {@link setCamera}.
   */
  cull(scene?: Scene): Uint32Array;
  /** Triangles that the last cull left to draw. */
  readonly triangleCount: number;
  /**
   * The stage that took each instance in the last cull, by id: a number of {@link STAGES}. Needs the option `reasons`, and the scene
   * as it was culled.
   */
  reasons(): Uint8Array;
  /** Draws of the last cull. @throws {CulletError} `argument` where the scene has changed since. */
  draws(): Draws;
  /** Counts in and out of each stage that ran in the last cull, in their order. */
  funnel(): FunnelRow[];
  /** Replays the stages for one instance. Takes as long as a cold cull. */
  explain(id: number): Explanation;
  /** Gives the memory back to the engine. */
  dispose(): void;
}
export interface View extends Disposal {}

/**
 * Meshes, instances of them, and views that cull them by every stage, with occlusion. Occluders are made of the meshes
 * by {@link commit}.
 *
 * ```js
 * import { init, Scene } from 'cullet';
 *
 * await init();
 * const scene = new Scene();
 * const mesh = scene.addMesh(positions, indices);
 * const ids = scene.addMany(mesh, matrices);
 * scene.commit();
 * const view = scene.view();
 * // Each frame:
 * for (const id of view.setCamera(clipFromWorld, 1280, 720).cull()) draw(id);
 * ```
 */
export class Scene {
  /** @throws {CulletError} `not-ready`. */
  constructor();
  readonly isDisposed: boolean;
  readonly instanceCount: number;
  readonly meshCount: number;
  /** Triangles of all instances. */
  readonly triangleCount: number;
  /** All ids are below. */
  readonly idCount: number;
  /**
   * Adds a mesh; returns its number. The arrays are copied.
   *
   * @param positions x, y, z of each vertex.
   * @param indices three a triangle, counter-clockwise seen from the front.
   * @throws {CulletError} `mesh` for indices beyond the vertices and positions that are not finite.
   */
  addMesh(positions: Float32Array, indices: Uint32Array | Uint16Array | readonly number[], options?: MeshOptions): number;
  /** Adds a mesh of which only the box is known, least corner and greatest: it is culled as a whole, and hides nothing. */
  addBox(box: Numbers): number;
  /**
   * Adds an instance; returns its id, a small whole number that stays until {@link remove}, and which a later instance may
   * then be given. Call {@link commit} after adding many.
   *
   * @param matrix own to world space, column-major, sixteen numbers, the last row 0, 0, 0, 1. One that is not finite makes
   * an instance that is always visible.
   */
  add(mesh: number, matrix: Numbers, state?: InstanceState): number;
  /** As {@link add}, sixteen numbers for each; returns the ids. */
  addMany(mesh: number, matrices: Numbers, state?: InstanceState): Uint32Array;
  /** Moves an instance; call {@link refit} after the moves of a frame. */
  setTransform(id: number, matrix: Numbers): void;
  /** Moves instances, sixteen numbers for each. @throws {CulletError} `id` at the first that is not there; those before it are moved. */
  setTransforms(ids: Uint32Array | readonly number[], matrices: Numbers): void;
  /** Sets the whole state of an instance: what is left out takes its default. */
  setState(id: number, state: InstanceState): void;
  remove(id: number): void;
  /** Sorts instances by place and prepares meshes that came since: after loading, and after much was added or moved far. */
  commit(): void;
  /** Fits the hierarchy to what moved: makes the next cull faster, never different. Costs what moved. */
  refit(): void;
  /** Says where your buffers hold a mesh, for {@link Draws.commands}. Default 0 and 0. */
  setPlace(mesh: number, firstIndex: number, baseVertex?: number): void;
  /** The indices of a mesh in the order that {@link Draws.commands} refer to: a copy, to be uploaded once. */
  indices(mesh: number): Uint32Array;
  /** Makes a view of this scene. */
  view(options?: ViewOptions): View;
  /** `view.cull()`. */
  cull(view: View): Uint32Array;
  /** Gives the memory back to the engine; its views throw `disposed`. */
  dispose(): void;
}
export interface Scene extends Disposal {}
