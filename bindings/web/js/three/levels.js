// Levels of detail of instances: which of a chain of geometries is drawn, by how far it may be off in the picture.
//
// A level with error e lies within e of the finest geometry, and the instance's matrix stretches that by at most s. The instance's box
// holds all of its levels, so where the eye is at least d away from the box, so is every point on the way from one surface to the other.
// In the picture that way is at most e s k / d pixels long at the centre, k being the pixels of a length of 1 at distance 1, and 1/cos²
// of the angle to the centre as much elsewhere. So where t pixels are allowed, e may be t d / (s k).

import { isBelow, nameOf } from './roots.js';

// More than all roundings on the way, as a share.
const ROUNDING = 1e-6;
const MOST = 255;
/** Numbers kept for an instance: its box in the space of its mesh, and by how much its matrix stretches. */
export const PLACE = 7;

/** Squares of the least and the greatest stretch of a matrix, a little outward where it is skewed: Gershgorin's discs. */
function stretch(m, at) {
  const dot = (a, b) => m[at + 4 * a] * m[at + 4 * b] + m[at + 4 * a + 1] * m[at + 4 * b + 1] + m[at + 4 * a + 2] * m[at + 4 * b + 2];
  const [xx, yy, zz, xy, yz, zx] = [dot(0, 0), dot(1, 1), dot(2, 2), Math.abs(dot(0, 1)), Math.abs(dot(1, 2)), Math.abs(dot(2, 0))];
  return [Math.min(xx - xy - zx, yy - xy - yz, zz - yz - zx), Math.max(xx + xy + zx, yy + xy + yz, zz + yz + zx)];
}

// Keeps what a renderer tells of its viewport; a Vector4 as far as it is asked for.
const viewport = { z: 0, w: 0, copy({ z, w }) { [this.z, this.w] = [z, w]; return this; } };

/** Width and height in pixels of what a render draws into, or more. */
function sizeOf(renderer, camera) {
  const target = renderer.getRenderTarget();
  const ratio = target ? 1 : renderer.getPixelRatio();
  const canvas = target ?? renderer.domElement;
  const own = camera.viewport ?? target?.viewport ?? renderer.getViewport(viewport);
  return [Math.max(canvas.width, own.z * ratio), Math.max(canvas.height, own.w * ratio)];
}

/** Widens a box by another; what is not finite stays so. */
export function widen(to, at, by) {
  for (let r = 0; r < 3; r++) {
    to[at + r] = Math.min(to[at + r], by[r]);
    to[at + 3 + r] = Math.max(to[at + 3 + r], by[3 + r]);
  }
}

/** What a camera's pass says of errors; `null` where that is not known, so that all is drawn in full. */
export function viewOf(renderer, camera) {
  const { elements: p } = camera.projectionMatrix;
  const [width, height] = sizeOf(renderer, camera);
  const [least, largest] = stretch(camera.matrixWorldInverse.elements, 0);
  const isParallel = p[11] === 0;
  if (p[1] !== 0 || p[4] !== 0 || p[3] !== 0 || p[7] !== 0) return null;
  // A perspective camera that is scaled shows the same picture, if it is scaled the same along all axes.
  if (!isParallel && (p[12] !== 0 || p[13] !== 0 || p[15] !== 0 || !(largest <= least * (1 + ROUNDING)))) return null;
  const scale = isParallel ? Math.sqrt(largest) / Math.abs(p[15]) : 1 / Math.abs(p[11]);
  const pixels = Math.max(width * Math.abs(p[0]), height * Math.abs(p[5])) / 2 * scale;
  if (!(pixels > 0 && pixels < Infinity)) return null;
  if (isParallel) return { eye: null, pixels, corners: 1 };
  // Tangents of the farthest corner.
  const [x, y] = [(1 + Math.abs(p[8])) / p[0], (1 + Math.abs(p[9])) / p[5]];
  const eye = camera.matrixWorld.elements.slice(12, 15);
  return eye.every(Number.isFinite) ? { eye, pixels, corners: 1 + x * x + y * y } : null;
}

/** The same in the space of a mesh: where the eye is, and what a distance of 1 counts as. */
export function viewIn(world, { eye, pixels, corners }) {
  const [least, largest] = stretch(world, 0).map(Math.sqrt);
  if (eye === null) return { eye, pixels: pixels * largest + 0 * (world[12] + world[13] + world[14]), per: 1, corners };
  const [a, b, c, d, e, f, g, h, i] = [world[0], world[4], world[8], world[1], world[5], world[9], world[2], world[6], world[10]];
  const [x, y, z] = [eye[0] - world[12], eye[1] - world[13], eye[2] - world[14]];
  const [u, v, w] = [e * i - f * h, f * g - d * i, d * h - e * g];
  const by = 1 / (a * u + b * v + c * w);
  const own = [
    (u * x + (c * h - b * i) * y + (b * f - c * e) * z) * by,
    (v * x + (a * i - c * g) * y + (c * d - a * f) * z) * by,
    (w * x + (b * g - a * h) * y + (a * e - b * d) * z) * by,
  ];
  // NaN, and so the finest level, where the mesh is flat.
  return { eye: own, pixels, per: least / largest, corners };
}

/** Writes what is kept of an instance, at `to[PLACE * k]`: of its box in its own space, and its matrix. */
export function place(to, k, box, from, m, at) {
  const first = PLACE * k;
  for (let r = 0; r < 3; r++) {
    let [low, high] = [m[at + 12 + r], m[at + 12 + r]];
    for (let c = 0; c < 3; c++) {
      const [one, other] = [m[at + 4 * c + r] * box[from + c], m[at + 4 * c + r] * box[from + 3 + c]];
      low += Math.min(one, other);
      high += Math.max(one, other);
    }
    to[first + r] = low;
    to[first + 3 + r] = high;
  }
  to[first + 6] = Math.sqrt(stretch(m, at)[1]);
}

/** The greatest error, in units of the geometry, that an instance may have. NaN, which no error is within, where it is not known. */
export function allowed({ eye, pixels, per, corners }, places, k, chain) {
  const first = PLACE * k;
  const all = chain.corners ? pixels * corners : pixels;
  const t = chain.pixels;
  // Nothing is added but NaN, where the box is not finite.
  if (eye === null) return t / (all * places[first + 6]) * (1 - ROUNDING) + 0 * (places[first] + places[first + 1] + places[first + 2]);
  let away = 0;
  for (let r = 0; r < 3; r++) {
    const off = Math.max(places[first + r] - eye[r], eye[r] - places[first + 3 + r], 0);
    away += off * off;
  }
  return t * Math.sqrt(away) * per / (places[first + 6] * all) * (1 - ROUNDING) + 0 * away;
}

/** Which level of a chain is drawn: the coarsest whose error is within what is allowed. */
export function levelFor(view, places, k, chain) {
  if (!(chain.pixels > 0)) return 0;
  const { errors } = chain;
  const most = allowed(view, places, k, chain);
  let level = errors.length - 1;
  while (level > 0 && !(errors[level] <= most)) level -= 1;
  return level;
}

/** A chain as it was given, checked: `{ geometries, errors, pixels, corners }`. */
function chainOf(fail, part, list, { pixels = 1, corners = false } = {}) {
  if (!Array.isArray(list) || list.length === 0 || list.length > MOST) fail(`takes an array of 1 to ${MOST} levels { geometry, error }, the finest first, or null`);
  if (typeof pixels !== 'number') fail(`pixels is a number, not ${String(pixels)}`);
  const [geometries, errors] = [[], []];
  for (const [k, level] of list.entries()) {
    const { geometry, error } = level ?? {};
    const wrong = part.whyNoLevel(geometry, k);
    if (wrong) fail(`the geometry of level ${k} ${wrong}`);
    if (geometries.includes(geometry)) fail(`level ${k} has the geometry of level ${geometries.indexOf(geometry)}`);
    if (k === 0 && error !== 0) fail(`level 0 is the finest, so its error is 0, not ${String(error)}`);
    if (k > 0 && !(error >= errors[k - 1] && error < Infinity)) fail(`the error of level ${k} is ${String(error)}; errors are finite and do not fall, so it is at least ${errors[k - 1]}`);
    geometries.push(geometry);
    errors.push(error);
  }
  return { geometries, errors, pixels, corners: Boolean(corners) };
}

/** The chains of all meshes, each by its finest geometry. */
export class Chains {
  #byMesh = new WeakMap();

  /** Takes a chain for a mesh below `root`, or with `null` drops those that it has. `part`: what culls it, if anything does. */
  take(mesh, part, root, list, options) {
    if (!mesh?.isBatchedMesh && !mesh?.isInstancedMesh) throw new TypeError(`cullet: levels() takes a BatchedMesh or an InstancedMesh, not ${nameOf(mesh)}`);
    if (!part) throw new Error(`cullet: levels() of ${nameOf(mesh)}, ${isBelow(mesh, root) ? 'which three.js culls by itself, since its shaders or attributes are not known here' : `which is not below ${nameOf(root)}; add it to that first`}`);
    if (list === null) this.#byMesh.delete(mesh);
    else {
      const chain = chainOf((text) => { throw new TypeError(`cullet: levels() of ${nameOf(mesh)}: ${text}`); }, part, list, options);
      if (!this.#byMesh.has(mesh)) this.#byMesh.set(mesh, new Map());
      this.#byMesh.get(mesh).set(chain.geometries[0], chain);
    }
    part.setLevels(this.#byMesh.get(mesh) ?? null);
  }

  /** Gives a new part of a mesh the chains that the mesh has. */
  give(mesh, part) { if (this.#byMesh.has(mesh)) part.setLevels(this.#byMesh.get(mesh)); }
}
