import type { Source } from 'cullet';
import type { BatchedMesh, BufferGeometry, Camera, InstancedMesh, Mesh, Object3D } from 'three';

/**
 * Loads the engine, once. In a browser that cannot run it (Chrome and Edge before 91, Firefox before 89, Safari before 16.4, and all
 * with WebAssembly turned off) it warns in the console and gives `false`: every {@link Culling} then does nothing, and three.js
 * draws as without this package.
 *
 * @returns whether the engine runs.
 * @throws {CulletError} `load` where the module is not found.
 */
export function init(source?: Source): Promise<boolean>;

/** How a {@link Culling} works; all may be left out. */
export interface CullingOptions {
  /**
   * Whether nothing below the root moves unless {@link Culling.update} is told. Default `false`: before each `render()` the position,
   * rotation and scale of every object are compared with those of the last, but for objects with `matrixAutoUpdate = false`. With `true`
   * that is left out: what stands still costs nothing.
   */
  still?: boolean;
  /**
   * Cameras whose passes also drop what is hidden behind other meshes and instances; other passes do not. Default none.
   * It is conservative at every resolution, so the picture is the same to the pixel. Only meshes that are known to write opaque depth hide
   * others, and {@link CullingStats.noOcclusion} says why nothing was hidden. The root must be in a `Scene` that is rendered.
   */
  occlusion?: Camera | readonly Camera[];
  /**
   * Which casters shadow passes draw. `'all'` (the default): those in the light's frustum. `'seen'`: of those, the ones whose shadow may
   * fall on what the camera's pass draws, and a light that reaches nothing of that keeps its old map. Pictures stay the same, as
   * long as nobody but three.js's own materials looks up the maps: an effect after the scene that reads `light.shadow.map` needs `'all'`.
   * {@link CullingStats.allCast} says why all casters were drawn. The root must be in a `Scene` that is rendered.
   */
  shadows?: 'all' | 'seen';
  /** How much time occlusion may take: `'fast'`, `'balanced'` (the default) or `'exact'`, which finds most. */
  preset?: 'exact' | 'balanced' | 'fast';
  /**
   * Whether the `onBeforeRender` and `onAfterRender` of objects and materials leave the depth buffer alone. Default `false`: in a pass that
   * draws something with such a callback nothing is hidden, for it may clear depth, and what was hidden would show.
   */
  callbacks?: boolean;
  /**
   * Microseconds that drawing one mesh takes, by which it is decided whether occlusion pays. Default: 8 at first. Once
   * 50 meshes or more are hidden, 16 renders without occlusion take turns with as many with it, and from then on it is what they took longer, from
   * 4 to 50; the preset `exact` measures nothing. {@link CullingStats.drawMicroseconds} is what is used. Give it where decisions must be the
   * same in each run; pictures are the same with any value.
   */
  drawMicroseconds?: number;
  /**
   * Tells of a mesh whether its shaders move vertices out of the bounds of its geometry; such meshes are left to three.js's own test.
   * Default: those with `ShaderMaterial`, `displacementMap`, `onBeforeCompile`, `positionNode`, `vertexNode` or a custom depth material.
   */
  movesVertices?: (mesh: Mesh) => boolean;
}

/** A level of detail: a geometry, and how far it is off. */
export interface Level<G> {
  /** Of an `InstancedMesh` a geometry, of a `BatchedMesh` the number that `addGeometry()` returned. */
  geometry: G;
  /**
   * Greatest distance from any point of the finest level to this one and back, in the geometry's own units; 0 for the finest. Finite, and
   * at least that of the level before.
   */
  error: number;
}

/** How levels are chosen; all may be left out. */
export interface LevelsOptions {
  /** How many pixels an outline may be off at the centre of the picture. Default 1. What is not above 0, NaN included, draws everything in full. */
  pixels?: number;
  /** Whether that holds in the corners of the picture too, where an error is larger by 1/cos² of the angle to the centre. Default `false`. */
  corners?: boolean;
}

/**
 * The levels of a file that `cullet bake` wrote, with their measured errors: for each geometry of the file its chain, as
 * {@link Culling.levels} takes it. Each coarser level is a new geometry with vertices of its own. Empty for other files. Geometries are left
 * out where their chain is missing or does not fit, and where several meshes of the file share vertices. Checksums are not compared:
 * bake a file again once its meshes have changed.
 *
 * @param gltf what three.js's `GLTFLoader` returned
 */
export function bakedLevels(gltf: { readonly parser: object }): Promise<Map<BufferGeometry, Level<BufferGeometry>[]>>;

/** Counts of the last pass (a camera, a shadow map, a face of a point light) of a {@link Culling}. */
export interface CullingStats {
  /** Passes so far. */
  readonly passes: number;
  /** Meshes that are culled here, an `InstancedMesh` or `BatchedMesh` as one. */
  readonly objects: number;
  /** How many of them the pass drew. */
  readonly visible: number;
  /** Instances of `InstancedMesh` and `BatchedMesh` that came to their own test. */
  readonly instances: number;
  /** How many of those instances the pass drew. */
  readonly visibleInstances: number;
  /** How many of the drawn instances are at a coarser level than their finest. */
  readonly coarserInstances: number;
  /** How many meshes the pass left out because others hide them. */
  readonly hidden: number;
  /** How many instances the pass left out because others hide them. */
  readonly hiddenInstances: number;
  /** How many meshes the pass left out because clipping planes take them away. */
  readonly clipped: number;
  /** How many lights kept their shadow maps in the last `render()` of a camera, with `shadows: 'seen'`. */
  readonly keptMaps: number;
  /** Why shadow passes of the last `render()` drew all casters; `null` where some could be left out, and without `shadows: 'seen'`. */
  readonly allCast: string | null;
  /** Why nothing was looked for that others hide; `null` where it was, and in passes of other cameras. */
  readonly noOcclusion: string | null;
  /** Microseconds that a draw counts as, and where they are from. */
  readonly drawMicroseconds: number;
  readonly drawMicrosecondsFrom: 'default' | 'measured' | 'given';
  /** Milliseconds that culling took in the pass. */
  readonly milliseconds: number;
}

/** Why an object is or is not in the picture. */
export interface Explanation {
  /**
   * `drawn`; `outside` of the frustum; `hidden` by other meshes; `clipped` away by planes; `invisible`: it, its material or what it hangs on;
   * `layers`: none in common with the camera; `empty`: nothing to draw; `three`: three.js decides by itself; `unknown`: no pass has seen it yet.
   */
  readonly reason: 'drawn' | 'outside' | 'hidden' | 'clipped' | 'invisible' | 'layers' | 'empty' | 'three' | 'unknown';
  /** One sentence that names the object. */
  readonly text: string;
}

/** Where a {@link Panel} is put, and what it shows; all may be left out. */
export interface PanelOptions {
  /** What the panel's element is appended to. Default `document.body`. */
  parent?: HTMLElement;
  /** The camera whose passes are shown. Default: the last that was rendered. */
  camera?: Camera;
}

/** A small panel: counts of a camera's last pass, what occlusion saved, a map from above, a button that freezes. */
export interface Panel {
  /** The panel's element. */
  readonly element: HTMLElement;
  /** Shows the next pass at once; else it is shown four times a second. */
  refresh(): void;
  /** As {@link Culling.explain}, and writes it into the panel. */
  explain(object: Object3D): Explanation;
  /** Removes the panel, and ends what its button froze. Calling it again does nothing. */
  dispose(): void;
}

/**
 * Culls the meshes below a scene or group in every pass that `WebGLRenderer` or `WebGPURenderer` makes: cameras, array cameras, shadow
 * maps, cascades, faces of point lights. Pictures stay as they are without any culling, to the pixel.
 *
 * Objects that are added or removed are noticed at once, and so are `visible`, `layers`, `castShadow`, `renderOrder`, instances with
 * `needsUpdate`, and calls of a `BatchedMesh`. Moved objects are noticed before each `render()`, or, with {@link CullingOptions.still}, by
 * {@link Culling.update}. Geometry that was changed in place is noticed by {@link Culling.update} alone.
 *
 * Lights, lines, points, sprites, LODs and what hangs on them or on cameras are walked by three.js as ever. Skinned and morphed
 * meshes are always drawn.
 */
export class Culling {
  /**
   * @param root a `THREE.Scene`, `Group` or `Object3D`, which need not have any meshes yet
   * @throws TypeError if `root` is anything else
   * @throws Error if it, or anything below or above it, is culled already, or if `init()` has not finished
   */
  constructor(root: Object3D, options?: CullingOptions);
  /** The scene or group given. */
  readonly root: Object3D;
  /** Whether it culls; `false` gives three.js its own culling back until it is `true` again, and keeps all that was made. */
  enabled: boolean;
  /** As {@link CullingOptions.still}; setting it to `false` looks at everything. */
  still: boolean;
  /**
   * Whether what the passes of cameras draw stays as it is, while cameras go on: to look from elsewhere at what is drawn. The next pass of each
   * camera decides once more, and that is kept. Objects added meanwhile are drawn, and shadow passes draw all casters in the light's frustum.
   */
  frozen: boolean;
  /** Counts of the last pass: one object, overwritten by the next. */
  readonly stats: CullingStats;
  /**
   * Takes over an object and all below it, wherever it was moved and however its geometry was changed; without one, everything is
   * taken anew. World matrices are made up to date too.
   * @throws Error if the object is not below the root, or after {@link dispose}
   */
  update(object?: Object3D): void;
  /**
   * Gives the instances of a mesh levels of detail. In each pass of a camera whose root is in a `Scene`, every instance is drawn at the
   * coarsest level that is off by no more pixels than allowed; shadow maps, and an `ArrayCamera`, get the finest. An instance that is
   * drawn at a coarser level hides nothing. A `BatchedMesh` has a chain for each finest geometry, and instances of that geometry use it. An
   * `InstancedMesh` has a chain for its geometry. A chain takes the place of one with the same finest level. The mesh is not changed. A
   * geometry of a batch that is deleted or set anew is no level any more.
   *
   * @param levels the finest first, at most 255; `null` ends all chains of the mesh
   * @throws TypeError for a mesh of another kind, or levels that make no chain: the message names the level, its value and the limit
   * @throws Error if the mesh is not below the root, or three.js culls it by itself; after {@link dispose}
   */
  levels(mesh: BatchedMesh, levels: readonly Level<number>[] | null, options?: LevelsOptions): void;
  levels(mesh: InstancedMesh, levels: readonly Level<BufferGeometry>[] | null, options?: LevelsOptions): void;
  /**
   * Says why an object is missing, by the last pass of a camera.
   * @throws TypeError if it is no object of three.js
   */
  explain(object: Object3D): Explanation;
  /** Shows a panel, loaded when it is first asked for; the same one until it is disposed. */
  panel(options?: PanelOptions): Promise<Panel>;
  /** Gives three.js its own culling and all objects their own methods back. Calling it again does nothing. */
  dispose(): void;
}
