// What clipping planes do to a mesh: leave it whole, cut it, or take it away.
//
// A mesh that a plane may touch hides nothing, and one that is taken away is not drawn. Whether a fragment is dropped is decided in
// single precision, in the camera's space, so a mesh counts as whole or away only by a margin.

import { isKnown } from './hiding.js';

const ERROR = 1e-5;

/** What planes do to a mesh, the least first. */
export const Cut = { Whole: 0, Cut: 1, Away: 2 };

/** Planes that hold in a pass for all objects, those of materials aside; `null` where nothing is clipped. */
export class Clipping {
  /** A fragment is dropped outside any of these, */
  union = [];
  /** and outside all of these together. */
  intersection = [];
  /** Whether planes of materials clip: WebGPURenderer does not know them. */
  local = false;
  #reach = 0;
  #override = null;
  /** Another number for other planes. */
  key = '';

  static of(root, renderer, camera, override) {
    const made = new Clipping();
    made.#override = override;
    const p = camera.matrixWorld.elements;
    // A power of two, so that a camera's steps change it seldom.
    made.#reach = 2 ** Math.ceil(Math.log2(1 + Math.abs(p[12]) + Math.abs(p[13]) + Math.abs(p[14])));
    if (renderer.isWebGLRenderer) {
      made.union.push(...renderer.clippingPlanes);
      made.local = renderer.localClippingEnabled === true;
    } else {
      for (let o = root; o; o = o.parent) if (o.isClippingGroup && o.enabled && o.layers.test(camera.layers)) made.add(o);
    }
    const over = made.local && override ? `${override.uuid} ${override.clippingPlanes?.map(keyOf)}` : '';
    made.key = [made.local, made.#reach, over, ...[...made.union, null, ...made.intersection].map((plane) => (plane ? keyOf(plane) : '|'))].join();
    return made;
  }

  add({ clippingPlanes, clipIntersection }) { (clipIntersection ? this.intersection : this.union).push(...clippingPlanes); }

  get isAny() { return this.union.length > 0 || this.intersection.length > 0; }

  /** Whether there are planes that may clip anything. */
  get isActive() { return this.isAny || this.local; }

  /** Whether an object may be clipped at all. */
  clips({ material }) {
    if (this.isAny) return true;
    if (!this.local) return false;
    if (this.#override?.clippingPlanes?.length) return true;
    return Array.isArray(material) ? material.some((m) => m?.clippingPlanes?.length) : material.clippingPlanes?.length > 0;
  }

  /** What an object's planes are, as text: other text, other planes. */
  keyFor({ material }) {
    const planes = !this.local || Array.isArray(material) ? null : material.clippingPlanes;
    return planes?.length ? `${material.clipIntersection} ${planes.map(keyOf)}` : '';
  }

  /** What happens to a box `boxes[at..]` under the matrix `matrices[from..]`, drawn with the object's material. */
  cut(object, boxes, at, matrices, from) {
    const { material } = object;
    let cut = this.#any(this.union, boxes, at, matrices, from);
    if (cut !== Cut.Away && this.intersection.length > 0) cut = worse(cut, this.#all(this.intersection, boxes, at, matrices, from));
    const isOther = Array.isArray(material) || this.#override !== null;
    if (isOther && this.local && this.clips({ material })) return Cut.Cut;
    if (!isOther && this.local && material.clippingPlanes?.length) {
      const planes = material.clippingPlanes;
      cut = worse(cut, (material.clipIntersection ? this.#all(planes, boxes, at, matrices, from) : this.#any(planes, boxes, at, matrices, from)));
    }
    // Shaders of someone else's may clip otherwise, or not at all; coverage fades out over a pixel beyond the plane.
    if (cut === Cut.Away && (isOther || !isKnown(material) || material.alphaToCoverage)) return Cut.Cut;
    return cut;
  }

  #any(planes, ...box) {
    let cut = Cut.Whole;
    for (const plane of planes) {
      cut = worse(cut, side(plane, this.#reach, ...box));
      if (cut === Cut.Away) break;
    }
    return cut;
  }

  #all(planes, ...box) {
    let cut = Cut.Away;
    for (const plane of planes) cut = Math.min(cut, side(plane, this.#reach, ...box));
    return cut;
  }
}

const worse = Math.max;

const keyOf = ({ normal: n, constant }) => `${n.x} ${n.y} ${n.z} ${constant}`;

// On which side of a plane a box is; what is not finite is cut.
function side({ normal: { x, y, z }, constant: given }, reach, boxes, at, m, from) {
  // As three.js has a plane whose normal is not of length 1.
  const constant = given * (x * x + y * y + z * z);
  let middle = constant;
  let radius = 0;
  let size = Math.abs(constant) + Math.hypot(x, y, z) * reach;
  for (let c = 0; c < 3; c++) {
    const k = from + 4 * c;
    const a = m[k] * x + m[k + 1] * y + m[k + 2] * z;
    const [low, high] = [boxes[at + c], boxes[at + 3 + c]];
    middle += a * (low + high) / 2;
    radius += Math.abs(a) * (high - low) / 2;
    size += (Math.abs(m[k] * x) + Math.abs(m[k + 1] * y) + Math.abs(m[k + 2] * z)) * Math.max(Math.abs(low), Math.abs(high));
  }
  const [a, b, c] = [m[from + 12] * x, m[from + 13] * y, m[from + 14] * z];
  middle += a + b + c;
  radius += ERROR * (size + Math.abs(a) + Math.abs(b) + Math.abs(c));
  if (middle - radius > 0) return Cut.Whole;
  if (middle + radius < 0) return Cut.Away;
  return Cut.Cut;
}
