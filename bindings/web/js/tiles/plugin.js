// The plugin for TilesRenderer of 3d-tiles-renderer.
//
// In each update of the renderer a tile is culled if it lies behind the horizon, or if the meshes of other tiles hide its box. The
// renderer takes it then for one outside of the camera, and here it is not loaded with its siblings either.
//
// Which tiles hide others is known for certain only when the update is over: it says what is drawn. So a first pass takes what was drawn
// in the frame before. If a tile of that is not drawn any more, the test is made again with what is drawn now, and where it finds a
// tile visible after all, the update is repeated, in the same frame. That tile then counts as visible for a second, so that it can load.
//
// Hiding has no circles. Along any ray to a hidden tile's box, the first surface of all that hide belongs to a tile that is not hidden
// there, for its box would be entered before. That one is drawn, and so is all that is needed.

import { isInert } from '../three/init.js';
import { Horizon, lowered, loweredOcclusionPoint } from './horizon.js';
import { eyeOf, Occluders } from './occluders.js';

// Passes of an update before it is made without occlusion.
const PASSES = 4;
// Frames for which a tile counts as visible after a pass that found it so against the one before.
const REST = 60;
// Boxes that are kept without looking whether the renderer still visits their tiles.
const MANY = 4096;
// Drafted for 3D Tiles 2.0, where nodes of glTF have it; here it is read from tiles and contents of 1.0 and 1.1.
const POINT = '3DTILES_horizon_occlusion_point';
// Parts of the way ahead that are looked from, one in each frame.
const SHARES = [0.2, 0.5, 1];

export class CullingPlugin {
  name = 'CULLET_CULLING_PLUGIN';
  #settings;
  #tiles = null;
  #occluders = null;
  #horizons = [];
  #radii = null;
  #points = new WeakMap();
  #hidden = new Set();
  #used = new Set();
  #fresh = new Set();
  #resting = new Map();
  #ahead = new Map();
  #eye = null;
  #culled = new WeakMap();
  #pass = 0;
  #frame = 0;
  #began = 0;
  #listeners;
  #stats = { updates: 0, passes: 0, beyondHorizon: 0, hidden: 0, tested: 0 };

  constructor({ horizon, lowest = -500, occlusion = true, preset = 'fast', drawMicroseconds = 1000, ahead = 30, occludes } = {}) {
    if (!(lowest > -Infinity && lowest < Infinity)) throw new TypeError(`cullet: lowest is ${lowest}; give the height of the lowest ground in metres, such as -500`);
    if (!(ahead >= 0 && ahead < Infinity)) throw new TypeError(`cullet: ahead is ${ahead}; give a number of frames from 0 on`);
    this.#settings = { horizon, lowest, occlusion, preset, drawMicroseconds, ahead, occludes };
    this.#listeners = {
      'update-before': () => this.#before(),
      'update-after': () => this.#after(),
      'dispose-model': ({ tile }) => this.#occluders?.unload(tile),
    };
  }

  get stats() { return this.#stats; }

  /** Called by the renderer when the plugin is registered. */
  init(tiles) {
    this.#tiles = tiles;
    if (this.#settings.occlusion && !isInert()) this.#occluders = new Occluders(this.#settings);
    for (const [name, listener] of Object.entries(this.#listeners)) tiles.addEventListener(name, listener);
    tiles.traverse((tile) => { if (tile.traversal) this.preprocessNode(tile); }, null, false);
  }

  /** Called by the renderer, which may skip an update where nothing changed; one that is repeated is not skipped. */
  doTilesNeedUpdate() { return this.#pass === 0 ? null : true; }

  /** Called by the renderer for each tile that it learns of. */
  preprocessNode(tile) {
    // The renderer uses the siblings of what it shows, and their tiles are loaded: what is culled is used by nobody.
    const { traversal } = tile;
    let { used } = traversal;
    Object.defineProperty(traversal, 'used', {
      configurable: true,
      enumerable: true,
      get: () => used,
      set: (to) => { used = to && !this.#isCulled(tile); },
    });
  }

  /** Called by the renderer for each tile that it visits; `true` with `inView = false` makes it skip the tile. */
  calculateTileViewError(tile, target) {
    const isCulled = this.#isBeyond(tile) || this.#isHidden(tile);
    if (!isCulled) return false;
    this.#culled.set(tile, this.#tiles.frameCount);
    if (this.#ahead.has(tile)) this.#load(tile);
    target.inView = false;
    return true;
  }

  /** Called by the renderer when the plugin is unregistered. */
  dispose() {
    const tiles = this.#tiles;
    if (!tiles) return;
    for (const [name, listener] of Object.entries(this.#listeners)) tiles.removeEventListener(name, listener);
    this.#tiles = null;
    this.#forget();
    this.#horizons = [];
    this.#occluders?.dispose();
    this.#occluders = null;
  }

  #isCulled(tile) { return this.#tiles !== null && this.#culled.get(tile) === this.#tiles.frameCount; }

  #isBeyond(tile) {
    if (this.#horizons.length === 0) return false;
    const { sphere, obb, regionObb } = tile.engineData.boundingVolume;
    const oriented = obb ?? regionObb;
    const points = this.#pointsOf(tile);
    const isBeyond = this.#horizons.every((horizon) => points.some((point) => horizon.hidesOcclusionPoint(point))
      || (oriented && horizon.hidesPoints(oriented.points)) || (sphere && horizon.hidesSphere(sphere.center, sphere.radius)));
    if (isBeyond) this.#stats.beyondHorizon += 1;
    return isBeyond;
  }

  // Horizon occlusion points of a tile, for the lowered ground; none where the file has none, or something else in its place. The point of
  // a content stands for the tile only while nothing is below it: tiles come there late, from other files and subtrees.
  #pointsOf(tile) {
    let points = this.#points.get(tile);
    if (!points) {
      const depth = Math.max(0, -this.#settings.lowest);
      points = [tile, tile.content].map((of) => loweredOcclusionPoint(this.#radii, depth, of?.extensions?.[POINT]?.horizonOcclusionPoint));
      this.#points.set(tile, points);
    }
    const [own, content] = points;
    const isAll = content !== null && tile.children.length === 0 && tile.internal.hasRenderableContent;
    return (isAll ? [own, content] : [own]).filter((point) => point !== null);
  }

  // Loads what is hidden yet, so that it is there when it comes in sight. A tile without meshes stands for those below it, each of which
  // is tested by itself.
  #load(tile) {
    const tiles = this.#tiles;
    if (tile.internal.hasContent) {
      tiles.markTileUsed(tile);
      tiles.queueTileForDownload(tile);
    }
    if (tile.internal.hasRenderableContent) return;
    tiles.ensureChildrenArePreprocessed(tile);
    for (const child of tile.children) {
      if (!child.traversal || this.#isBeyond(child)) continue;
      if (!this.#occluders.has(child)) this.#occluders.add(child);
      if (this.#ahead.has(child)) this.#load(child);
    }
  }

  #isHidden(tile) {
    if (!this.#occluders) return false;
    if (this.#hidden.has(tile)) { this.#stats.hidden += 1; return true; }
    if (!this.#occluders.has(tile)) this.#fresh.add(tile);
    return false;
  }

  #before() {
    this.#stats.beyondHorizon = this.#stats.hidden = 0;
    this.#began = this.#tiles.frameCount;
    // A pass after the first has its answer from the check of the one before.
    if (this.#pass !== 0) return;
    this.#stats.updates += 1;
    this.#frame += 1;
    this.#lookAround();
    if (!this.#occluders) return;
    this.#cull(new Set(this.#tiles.visibleTiles));
    this.#lookAhead();
  }

  // Along the way that the first camera went since the last frame, in turns near and far.
  #lookAhead() {
    const { cameras, group } = this.#tiles;
    for (const [tile, until] of this.#ahead) if (until < this.#frame) this.#ahead.delete(tile);
    const eye = cameras.length > 0 ? eyeOf(cameras[0], group.matrixWorldInverse.elements) : null;
    const last = this.#eye;
    this.#eye = eye;
    if (!eye || !last || this.#hidden.size === 0 || eye.every((c, a) => c === last[a])) return;
    const frames = this.#settings.ahead * SHARES[this.#frame % SHARES.length];
    const shift = eye.map((c, a) => (c - last[a]) * frames);
    if (!shift.every(Number.isFinite)) return;
    const hidden = this.#occluders.ahead(cameras, group, shift, this.#hidden);
    if (!hidden) return;
    for (const tile of this.#hidden) if (!hidden.has(tile)) this.#ahead.set(tile, this.#frame + this.#settings.ahead);
  }

  // What the update drew has to hide what it left out.
  #after() {
    // Another plugin may have found that nothing changed.
    if (this.#tiles.frameCount === this.#began) return;
    this.#stats.passes += 1;
    if (!this.#occluders || this.#pass < 0) return;
    const drawn = new Set(this.#tiles.visibleTiles);
    const isKept = [...this.#used].every((tile) => drawn.has(tile) || this.#hidden.has(tile) || !tile.traversal.inFrustum);
    const isNew = this.#addFresh() && drawn.size > 0;
    if ((isKept || this.#hidden.size === 0) && !isNew) { this.#end(); return; }
    const before = this.#hidden;
    this.#cull(drawn);
    let isSame = before.size === this.#hidden.size;
    for (const tile of before) {
      if (this.#hidden.has(tile)) continue;
      // It stays visible in all passes that follow, so these come to an end.
      isSame = false;
      this.#resting.set(tile, this.#frame + REST);
    }
    if (isSame) { this.#end(); return; }
    this.#pass = this.#pass + 1 < PASSES ? this.#pass + 1 : -1;
    if (this.#pass < 0) this.#forget();
    this.#tiles.update();
    if (this.#pass < 0) this.#end();
  }

  #end() {
    this.#pass = 0;
    for (const [tile, until] of this.#resting) if (until < this.#frame) this.#resting.delete(tile);
    this.#stats.tested = this.#occluders.count;
    // Tiles that the renderer came to long ago may be gone.
    const { frameCount } = this.#tiles;
    if (this.#occluders.count > MANY) this.#occluders.prune(({ traversal }) => traversal.lastFrameVisited < frameCount - REST);
  }

  #forget() {
    this.#hidden = new Set();
    this.#used = new Set();
  }

  #cull(drawn) {
    const { cameras, group } = this.#tiles;
    this.#used = drawn;
    this.#hidden = this.#occluders.cull(drawn, cameras, group, this.#hidden) ?? new Set();
    for (const tile of this.#resting.keys()) this.#hidden.delete(tile);
  }

  // Whether tiles came that were never tested; those outside of all cameras wait.
  #addFresh() {
    let isAny = false;
    for (const tile of this.#fresh) {
      if (!tile.traversal.inFrustum) continue;
      this.#occluders.add(tile);
      isAny = true;
    }
    this.#fresh.clear();
    return isAny;
  }

  // The horizon of each camera; none where there is no globe, or where a camera has no eye.
  #lookAround() {
    const { cameras, root, group, ellipsoid } = this.#tiles;
    const { horizon, lowest } = this.#settings;
    this.#horizons = [];
    const isGlobe = horizon ?? (root !== null && holdsCentre(root.engineData?.boundingVolume));
    if (!isGlobe || cameras.some((camera) => camera.projectionMatrix.elements[15] === 1)) return;
    const radii = [ellipsoid.radius.x, ellipsoid.radius.y, ellipsoid.radius.z];
    // A page may change the ellipsoid: points are lowered for one.
    if (radii.some((r, a) => r !== this.#radii?.[a])) this.#points = new WeakMap();
    this.#radii = radii;
    const ground = lowered(radii, Math.max(0, -lowest));
    const inverse = group.matrixWorldInverse.elements;
    this.#horizons = cameras.map((camera) => new Horizon(ground, eyeOf(camera, inverse)));
  }
}

function holdsCentre(volume) {
  if (!volume) return false;
  const { sphere, obb, regionObb } = volume;
  if (sphere) return sphere.center.length() <= sphere.radius;
  const oriented = obb ?? regionObb;
  return Boolean(oriented) && oriented.distanceToPoint({ x: 0, y: 0, z: 0 }) === 0;
}
