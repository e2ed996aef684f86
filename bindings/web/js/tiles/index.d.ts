import type { Mesh } from 'three';

/** Loads the engine, once for `cullet/three` and this entry; without it, as in a browser that lacks SIMD, the horizon alone hides. */
export { init } from 'cullet/three';

/** How a {@link CullingPlugin} works; all may be left out. */
export interface CullingPluginOptions {
  /**
   * Whether the ellipsoid of the renderer hides what lies behind its horizon. Default: where the root tile's volume holds the centre of
   * the ellipsoid, as for a globe. Give `true` for tiles of a region if the globe is drawn by something else.
   */
  horizon?: boolean;
  /**
   * Height of the lowest ground that is drawn, in metres above the ellipsoid. Default −500, which holds for all dry land of the earth.
   * Ground below it may be hidden by mistake; with the sea floor give −11500. Horizon occlusion points in the tileset
   * (`3DTILES_horizon_occlusion_point`) are lowered as much; with 0 they are tested as they stand, as in CesiumJS.
   */
  lowest?: number;
  /** Whether tiles are hidden by the meshes of drawn tiles. Default `true`. The horizon alone needs no engine, and so no `init()`. */
  occlusion?: boolean;
  /** How much time occlusion may take: `'fast'` (the default), `'balanced'` or `'exact'`, which finds most. */
  preset?: 'exact' | 'balanced' | 'fast';
  /** Microseconds that a tile saves where it is hidden, by which it is decided how long to look for hidden tiles. Default 1000. */
  drawMicroseconds?: number;
  /**
   * Frames that are looked ahead along the way of the first camera: a hidden tile that would be seen from there is loaded, and not drawn
   * yet. Default 30; 0 for none.
   */
  ahead?: number;
  /** Tells whether an opaque mesh may hide others. Default: all do. */
  occludes?: (mesh: Mesh) => boolean;
}

/** Counts of a {@link CullingPlugin}. */
export interface CullingPluginStats {
  /** Updates of the renderer so far. */
  readonly updates: number;
  /** Passes so far: an update is repeated where its own tiles show that one is visible after all. */
  readonly passes: number;
  /** Tiles that the last pass left out since they, or their horizon occlusion points, lie behind the horizon. */
  readonly beyondHorizon: number;
  /** Tiles that the last pass left out since others hide them. */
  readonly hidden: number;
  /** Tiles whose boxes are tested for being hidden. */
  readonly tested: number;
}

/**
 * Plugin for `TilesRenderer` of the package `3d-tiles-renderer`: tiles behind the horizon, and tiles that are hidden by the meshes of drawn
 * tiles, are neither drawn nor refined nor loaded.
 *
 * A tile counts as hidden only by what is drawn in the same frame, and only if no camera of the renderer sees it. Pictures are those without
 * the plugin once all that is visible is loaded. Shadows of hidden tiles are missing.
 *
 * ```js
 * import { CullingPlugin, init } from 'cullet/tiles';
 *
 * await init();
 * tiles.registerPlugin(new CullingPlugin());
 * ```
 */
export class CullingPlugin {
  /** @throws TypeError for a number that is out of range */
  constructor(options?: CullingPluginOptions);
  readonly name: 'CULLET_CULLING_PLUGIN';
  /** Counts: one object, overwritten by each update. */
  readonly stats: CullingPluginStats;
  /**
   * Called by `registerPlugin`.
   * @throws CulletError `not-ready` if `init()` has not finished, and occlusion is wanted
   */
  init(tiles: object): void;
  /** Called by `unregisterPlugin`, and by `dispose` of the renderer: gives back the memory of the engine. */
  dispose(): void;
}
