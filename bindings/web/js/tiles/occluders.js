// What the tiles that are drawn hide: a scene of the engine with the meshes of those tiles, and the boxes of the tiles that are asked for.

import { isMorphed, Kind, kindOf } from '../three/bounds.js';
import { Scene } from '../three/engine.js';
import { callsBack, judge, May } from '../three/hiding.js';

// Where a box is in a picture.
const [OUTSIDE, HIDDEN, SEEN] = [0, 1, 2];
// A buffer of this width is enough for any screen: proofs hold at every resolution.
const WIDTH = 1280;
// A box is tested in a picture so many times as wide and as high as the camera's: one that shows beside the screen is not hidden, and is
// there when the camera turns.
const WIDER = 2;
// Beyond this distance from the eye, the engine's coordinates begin anew there: they are f32, and so within a millimetre of it.
const FAR = 1e4;
const IN_VIEW = { layers: 1 };
const NOT_IN_VIEW = { layers: 0, occluder: false };
const UNIT = [-1, -1, -1, 1, 1, 1];
const NOWHERE = [0, 0, 0];

export class Occluders {
  #scene = null;
  // By camera, the engine's views: of what is not hidden now, of that ahead, and of all in a picture.
  #views = new Map();
  #viewsAhead = new Map();
  #viewsOfAll = new Map();
  #settings;
  #hides;
  #unit = 0;
  // Of each tile whose box is tested, and of each whose meshes were taken, what the engine knows it by.
  #boxes = new Map();
  #meshes = new Map();
  #anchor = [0, 0, 0];
  #isNew = false;
  #waste = 0;

  constructor({ preset, drawMicroseconds, occludes }) {
    this.#settings = { preset, drawMicroseconds, output: 'instances' };
    this.#hides = occludes ?? (() => true);
    // Now, and not in the first frame, it is told if the engine is not loaded.
    this.#ready();
  }

  /** How many tiles are tested. */
  get count() { return this.#boxes.size; }

  has(tile) { return this.#boxes.has(tile); }

  /** Adds the box of a tile, to be tested from the next `cull` on. */
  add(tile) {
    const matrix = boxOf(tile.engineData.boundingVolume);
    if (!matrix.every(Number.isFinite)) { this.#boxes.set(tile, null); return; }
    const scene = this.#ready();
    this.#boxes.set(tile, { id: scene.add(this.#unit, this.#placed(matrix), IN_VIEW), matrix });
    this.#isNew = true;
  }

  /** Forgets the boxes of tiles that are `old`. */
  prune(old) {
    for (const [tile, box] of this.#boxes) {
      if (!old(tile)) continue;
      if (box) this.#scene?.remove(box.id);
      this.#boxes.delete(tile);
    }
  }

  /** Forgets the meshes of a tile that is unloaded. */
  unload(tile) {
    const taken = this.#meshes.get(tile);
    if (!taken) return;
    for (const { id } of taken) this.#scene.remove(id);
    this.#meshes.delete(tile);
    // The engine keeps their triangles: it is made anew once those are more than what is left.
    this.#waste += taken.length;
    let left = 0;
    for (const meshes of this.#meshes.values()) left += meshes.length;
    if (this.#waste > 64 && this.#waste > left) this.#clear();
  }

  /**
   * The tiles whose boxes are hidden by the meshes of `drawn` tiles, for all of `cameras`; `null` where nothing can be known.
   * `group` holds the tiles. Tiles that are `kept`, hidden before, stay so while they are outside of the picture: what hid them may be
   * outside, too, and so not drawn.
   */
  cull(drawn, cameras, group, kept) {
    if (cameras.length === 0 || drawn.size === 0) return null;
    const inverse = group.matrixWorldInverse.elements;
    const [x, y, z] = eyeOf(cameras[0], inverse);
    if (![x, y, z].every(Number.isFinite)) return null;
    const scene = this.#ready();
    const [ax, ay, az] = this.#anchor;
    if (Math.hypot(x - ax, y - ay, z - az) > FAR) this.#move([x, y, z]);
    const layers = cameras.reduce((bits, camera) => bits & camera.layers.mask, -1);
    for (const tile of drawn) if (!this.#meshes.has(tile)) this.#take(tile, inverse);
    let hides = false;
    for (const [tile, taken] of this.#meshes) {
      const isDrawn = drawn.has(tile);
      if (isDrawn && this.#spoils(tile)) return null;
      for (const mesh of taken) {
        const is = isDrawn && this.#isOpaque(mesh.object, layers, group, mesh.twoSided);
        if (is !== mesh.is) scene.setState(mesh.id, is ? { ...IN_VIEW, occluder: true } : NOT_IN_VIEW);
        mesh.is = is;
        hides ||= is;
      }
    }
    if (!hides) return null;
    if (this.#isNew) scene.commit();
    else scene.refit();
    this.#isNew = false;
    return this.#hidden(cameras, group, this.#views, NOWHERE, kept);
  }

  /** Those of the `kept` tiles that nobody would see if all cameras had moved by `shift`, in the space of the tiles, and others that would be hidden. */
  ahead(cameras, group, shift, kept) { return this.#hidden(cameras, group, this.#viewsAhead, shift, kept); }

  dispose() { this.#clear(); }

  #hidden(cameras, group, views, shift, kept) {
    let wide;
    let within = null;
    try {
      wide = cameras.map((camera) => this.#pictureOf(camera, group, views, shift, WIDER));
      if (views === this.#views && kept.size > 0) within = cameras.map((camera) => this.#pictureOf(camera, group, null, shift, 1));
    } catch (error) {
      // A matrix that shows no volume.
      if (error.code === 'camera') return null;
      throw error;
    }
    const hidden = new Set();
    for (const [tile, box] of this.#boxes) {
      if (!box) continue;
      const isKept = kept.has(tile);
      let isHidden = isKept;
      let isSeen = false;
      wide.forEach((picture, i) => {
        const isOutside = picture[box.id] === OUTSIDE || (isKept && within?.[i][box.id] === OUTSIDE);
        isHidden ||= picture[box.id] === HIDDEN;
        isSeen ||= picture[box.id] === SEEN && !isOutside;
      });
      if (isHidden && !isSeen) hidden.add(tile);
    }
    return hidden;
  }

  // Where each instance is in a camera's picture, which is so many times as wide: seen or hidden as `views` find, hidden without them.
  #pictureOf(camera, group, views, shift, wider) {
    const { elements } = camera.projectionMatrix;
    const height = Math.max(1, Math.min(4096, Math.round((WIDTH * elements[0]) / Math.abs(elements[5])) || 1));
    const clip = this.#clipOf(camera, group, shift, wider);
    const picture = new Uint8Array(this.#scene.idCount);
    for (const id of this.#viewOf(camera, this.#viewsOfAll).setCamera(clip, WIDTH, height).cull()) picture[id] = HIDDEN;
    if (views) for (const id of this.#viewOf(camera, views).setCamera(clip, WIDTH, height).cull()) picture[id] = SEEN;
    return picture;
  }

  #viewOf(camera, views) {
    let depth = 'webgl';
    if (camera.reversedDepth) depth = 'reversed';
    else if (camera.coordinateSystem === 2001) depth = 'standard';
    const made = views.get(camera);
    if (made?.depth === depth) return made.view;
    made?.view.dispose();
    const view = this.#scene.view({ ...this.#settings, occlusion: views !== this.#viewsOfAll, depth });
    views.set(camera, { view, depth });
    return view;
  }

  // From coordinates relative to the anchor to clip space. The large translations meet here, in f64.
  #clipOf(camera, group, shift, wider) {
    const local = multiply(camera.matrixWorldInverse.elements, group.matrixWorld.elements);
    const [x, y, z] = this.#anchor.map((a, axis) => a - shift[axis]);
    for (let r = 0; r < 3; r++) local[12 + r] += local[r] * x + local[4 + r] * y + local[8 + r] * z;
    const clip = multiply(camera.projectionMatrix.elements, local);
    for (let c = 0; c < 16; c += 4) for (let r = 0; r < 2; r++) clip[c + r] /= wider;
    return clip;
  }

  #placed(matrix) {
    const to = Float64Array.from(matrix);
    for (let a = 0; a < 3; a++) to[12 + a] -= this.#anchor[a];
    return to;
  }

  #move(anchor) {
    this.#anchor = anchor;
    for (const box of this.#boxes.values()) if (box) this.#scene.setTransform(box.id, this.#placed(box.matrix));
    for (const taken of this.#meshes.values()) for (const mesh of taken) this.#scene.setTransform(mesh.id, this.#placed(mesh.matrix));
    this.#isNew = true;
  }

  // Takes the meshes of a tile that could hide others.
  #take(tile, inverse) {
    const taken = [];
    this.#meshes.set(tile, taken);
    const scene = this.#ready();
    tile.engineData.scene?.traverse((object) => {
      if (!object.isMesh || kindOf(object) !== Kind.Mesh || object.isSkinnedMesh || isMorphed(object)) return;
      if (Array.isArray(object.material) || !(judge(object.material, false) & (May.Hide | May.HideTwoSided))) return;
      const twoSided = Boolean(judge(object.material, false) & May.HideTwoSided);
      const matrix = multiply(inverse, object.matrixWorld.elements);
      const mesh = matrix.every(Number.isFinite) ? meshOf(scene, object.geometry, twoSided) : null;
      if (mesh === null) return;
      taken.push({ id: scene.add(mesh, this.#placed(matrix), NOT_IN_VIEW), matrix, object, twoSided, is: false });
      this.#isNew = true;
    });
  }

  // Whether an object hides now what it hid when it was taken: materials change.
  #isOpaque(object, layers, group, twoSided) {
    for (let o = object; o && o !== group; o = o.parent) if (!o.visible) return false;
    const bits = Array.isArray(object.material) ? 0 : judge(object.material, false);
    const { start, count } = object.geometry.drawRange;
    return Boolean(object.layers.mask & layers) && start === 0 && count === Infinity && kindOf(object) === Kind.Mesh && !callsBack(object)
      && Boolean(bits & (twoSided ? May.HideTwoSided : May.Hide | May.HideTwoSided)) && this.#hides(object);
  }

  // Whether something of a tile may make depth farther, so that what was hidden shows.
  #spoils(tile) {
    let spoils = false;
    tile.engineData.scene?.traverse(({ material }) => {
      for (const m of Array.isArray(material) ? material : [material]) if (m && judge(m, true) & May.ResetDepth) spoils = true;
    });
    return spoils;
  }

  #ready() {
    if (this.#scene) return this.#scene;
    this.#scene = new Scene();
    this.#unit = this.#scene.addBox(UNIT);
    for (const [tile, box] of this.#boxes) if (box) this.#boxes.set(tile, { ...box, id: this.#scene.add(this.#unit, this.#placed(box.matrix), IN_VIEW) });
    this.#isNew = true;
    return this.#scene;
  }

  // What is drawn is taken again by the next `cull`.
  #clear() {
    for (const views of [this.#views, this.#viewsAhead, this.#viewsOfAll]) {
      for (const { view } of views.values()) view.dispose();
      views.clear();
    }
    this.#meshes.clear();
    this.#scene?.dispose();
    this.#scene = null;
    this.#waste = 0;
  }
}

/** Where a camera is, in the space of the tiles. */
export function eyeOf(camera, inverse) {
  const [x, y, z] = camera.matrixWorld.elements.slice(12, 15);
  return [0, 1, 2].map((r) => inverse[r] * x + inverse[4 + r] * y + inverse[8 + r] * z + inverse[12 + r]);
}

// The matrix that takes the box from −1 to 1 to the box of a tile.
function boxOf({ obb, regionObb, sphere }) {
  const oriented = obb ?? regionObb;
  if (!oriented) {
    const { center: c, radius: r } = sphere;
    return [r, 0, 0, 0, 0, r, 0, 0, 0, 0, r, 0, c.x, c.y, c.z, 1];
  }
  const { box: { min, max }, transform: { elements } } = oriented;
  const to = Float64Array.from(elements);
  const [low, high] = [[min.x, min.y, min.z], [max.x, max.y, max.z]];
  for (let a = 0; a < 3; a++) {
    for (let r = 0; r < 3; r++) {
      to[12 + r] += elements[4 * a + r] * ((low[a] + high[a]) / 2);
      to[4 * a + r] = elements[4 * a + r] * ((high[a] - low[a]) / 2);
    }
  }
  return to;
}

function meshOf(scene, geometry, twoSided) {
  const { position } = geometry.attributes;
  const positions = new Float32Array(3 * position.count);
  for (let v = 0; v < position.count; v++) { positions[3 * v] = position.getX(v); positions[3 * v + 1] = position.getY(v); positions[3 * v + 2] = position.getZ(v); }
  const { index } = geometry;
  const indices = new Uint32Array(3 * Math.floor((index ?? position).count / 3));
  for (let k = 0; k < indices.length; k++) indices[k] = index ? index.getX(k) : k;
  const isMesh = indices.length > 0 && positions.every(Number.isFinite) && indices.every((v) => v < position.count);
  return isMesh ? scene.addMesh(positions, indices, { twoSided }) : null;
}

function multiply(a, b) {
  const to = new Float64Array(16);
  for (let c = 0; c < 16; c += 4) for (let r = 0; r < 4; r++) to[c + r] = a[r] * b[c] + a[4 + r] * b[c + 1] + a[8 + r] * b[c + 2] + a[12 + r] * b[c + 3];
  return to;
}
