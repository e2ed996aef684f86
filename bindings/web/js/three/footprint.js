// Where in a shadow map the shadows of what is seen are looked up, as a grid with the greatest depth of each cell. A caster matters if
// its box lies over a cell, and not wholly behind that depth.

const SIZE = 64;
const depths = new Float64Array(SIZE * SIZE);
const clip = new Float64Array(16);
// Of a box: least and greatest x and y in the map, -1 to 1, and depth along the light's axis.
const at = new Float64Array(6);
// Depths are compared in single precision, and stored in twenty-four bits.
const ERROR = { orthographic: 1e-4, perspective: 2e-6 };

/** One at a time: the grid is shared. */
export class Footprint {
  #camera;
  #view;
  #isOrthographic;
  #margin;
  #bias;
  #normalBias;
  /** Whether anything that is seen looks up this map. */
  isAny = false;

  /** For a light's shadow, as its camera stands now. */
  constructor(shadow) {
    const { camera, mapSize, radius, bias, normalBias } = shadow;
    this.#camera = camera;
    this.#isOrthographic = camera.isOrthographicCamera === true;
    this.#view = camera.matrixWorldInverse.elements;
    const [p, v] = [camera.projectionMatrix.elements, this.#view];
    for (let c = 0; c < 16; c += 4) for (let r = 0; r < 4; r++) clip[c + r] = p[r] * v[c] + p[4 + r] * v[c + 1] + p[8 + r] * v[c + 2] + p[12 + r] * v[c + 3];
    // Samples lie within the radius, each of four texels; a cube's texels are up to three times as wide. Not finite: all of the map.
    this.#margin = (3 * Math.abs(radius) + 3) * 2 / Math.min(mapSize.x, mapSize.y) + 1e-3;
    if (!(this.#margin < Infinity)) this.#margin = Infinity;
    this.#bias = Math.abs(bias) + (this.#isOrthographic ? ERROR.orthographic : ERROR.perspective);
    this.#normalBias = 1.01 * Math.abs(normalBias);
    depths.fill(-Infinity);
  }

  /** Takes a box in the world that receives shadows. */
  receive(boxes, from) {
    const by = this.#normalBias;
    if (!this.#project(boxes, from, by)) { this.isAny = true; depths.fill(Infinity); return; }
    const { far } = this.#camera;
    const margin = this.#margin;
    const reach = this.#deeper(at[5]);
    // Beyond its far plane and behind itself a light has no shadows.
    if (at[4] > this.#deeper(far) || (!this.#isOrthographic && reach < 0)) return;
    if (at[0] - margin > 1 || at[1] + margin < -1 || at[2] - margin > 1 || at[3] + margin < -1) return;
    this.isAny = true;
    const [left, right, low, high] = [cell(at[0] - margin), cell(at[1] + margin), cell(at[2] - margin), cell(at[3] + margin)];
    for (let y = low; y <= high; y++) for (let k = SIZE * y + left; k <= SIZE * y + right; k++) if (!(depths[k] >= reach)) depths[k] = reach;
  }

  /** Whether the shadow of a box in the world may fall on anything that is seen. */
  casts(boxes, from) {
    if (!this.isAny) return false;
    if (!this.#project(boxes, from, 0)) return true;
    const [left, right, low, high] = [cell(at[0]), cell(at[1]), cell(at[2]), cell(at[3])];
    for (let y = low; y <= high; y++) for (let k = SIZE * y + left; k <= SIZE * y + right; k++) if (!(depths[k] < at[4])) return true;
    return false;
  }

  // What a depth may count as at most, in the units of the world.
  #deeper(z) {
    const { near, far } = this.#camera;
    if (this.#isOrthographic) return z + this.#bias * (far - near);
    const [a, b] = [far / (far - near), far * near / (far - near)];
    // As far off as the margin in a cube's corner.
    const wide = z * (1 + 2 * this.#margin);
    const left = b / wide - this.#bias;
    return wide > 0 && left > 0 ? b / left : (wide > 0 ? Infinity : wide);
  }

  // `false` where a number is not finite.
  #project(boxes, from, by) {
    const v = this.#view;
    const [x, y, z] = [(boxes[from] + boxes[from + 3]) / 2, (boxes[from + 1] + boxes[from + 4]) / 2, (boxes[from + 2] + boxes[from + 5]) / 2];
    const [a, b, c] = [(boxes[from + 3] - boxes[from]) / 2 + by, (boxes[from + 4] - boxes[from + 1]) / 2 + by, (boxes[from + 5] - boxes[from + 2]) / 2 + by];
    const depth = -(v[2] * x + v[6] * y + v[10] * z + v[14]);
    const radius = Math.abs(v[2]) * a + Math.abs(v[6]) * b + Math.abs(v[10]) * c;
    at[4] = depth - radius;
    at[5] = depth + radius;
    if (this.#isOrthographic) {
      for (let r = 0; r < 2; r++) {
        const middle = clip[r] * x + clip[4 + r] * y + clip[8 + r] * z + clip[12 + r];
        const half = Math.abs(clip[r]) * a + Math.abs(clip[4 + r]) * b + Math.abs(clip[8 + r]) * c;
        at[2 * r] = middle - half;
        at[2 * r + 1] = middle + half;
      }
    } else if (at[4] > 1e-6 * this.#camera.far) {
      at[0] = at[2] = Infinity;
      at[1] = at[3] = -Infinity;
      for (let k = 0; k < 8; k++) {
        const [px, py, pz] = [x + (k & 1 ? a : -a), y + (k & 2 ? b : -b), z + (k & 4 ? c : -c)];
        const w = clip[3] * px + clip[7] * py + clip[11] * pz + clip[15];
        for (let r = 0; r < 2; r++) {
          const on = (clip[r] * px + clip[4 + r] * py + clip[8 + r] * pz + clip[12 + r]) / w;
          at[2 * r] = Math.min(at[2 * r], on);
          at[2 * r + 1] = Math.max(at[2 * r + 1], on);
        }
      }
    } else { at[0] = at[2] = -1; at[1] = at[3] = 1; }
    return Number.isFinite(at[0] + at[1] + at[2] + at[3] + at[4] + at[5]);
  }
}

const cell = (x) => Math.max(0, Math.min(SIZE - 1, Math.floor((x + 1) / 2 * SIZE)));

/** Writes the box in the world of a box `boxes[from..]` under the matrix `matrices[first..]`. */
export function worldBox(boxes, from, m, first, to, into) {
  for (let r = 0; r < 3; r++) {
    let [low, high] = [m[first + 12 + r], m[first + 12 + r]];
    for (let c = 0; c < 3; c++) {
      const [a, b] = [m[first + 4 * c + r] * boxes[from + c], m[first + 4 * c + r] * boxes[from + 3 + c]];
      low += Math.min(a, b);
      high += Math.max(a, b);
    }
    to[into + r] = low;
    to[into + 3 + r] = high;
  }
}
