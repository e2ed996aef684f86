// Planes of frusta as twenty-four numbers: inward normal and constant, six times, as three.js has them.

/** Writes the planes of a `THREE.Frustum`. */
function planesOfFrustum(frustum, to) {
  const { planes } = frustum;
  for (let i = 0; i < 6; i++) {
    const { normal, constant } = planes[i];
    to[4 * i] = normal.x;
    to[4 * i + 1] = normal.y;
    to[4 * i + 2] = normal.z;
    to[4 * i + 3] = constant;
  }
}

/** Planes of a frustum, twenty-four numbers written to `to`, or those of each camera of an array, in an array of their own. */
export function planesOf(frustum, to) {
  if (frustum.planes) { planesOfFrustum(frustum, to); return to; }
  const count = frustum._count;
  const all = new Float64Array(24 * count);
  for (let i = 0; i < count; i++) planesOfFrustum(frustum.getFrustum(i), all.subarray(24 * i, 24 * i + 24));
  return all;
}

const WEBGPU_COORDINATES = 2001;

/**
 * Writes the planes of a camera, from its matrices of this moment: the same rows that three.js takes, so the same planes.
 * A camera without size (aspect NaN or 0, near equal to far) gives planes that are not finite, and those cull nothing.
 */
export function planesOfCamera(camera, to) {
  const { elements: p } = camera.projectionMatrix;
  const { elements: v } = camera.matrixWorldInverse;
  for (let c = 0; c < 4; c++) {
    for (let r = 0; r < 4; r++) {
      clip[4 * c + r] = p[r] * v[4 * c] + p[4 + r] * v[4 * c + 1] + p[8 + r] * v[4 * c + 2] + p[12 + r] * v[4 * c + 3];
    }
  }
  row(to, 0, 0, -1);
  row(to, 1, 0, 1);
  row(to, 2, 1, 1);
  row(to, 3, 1, -1);
  // Depth: -1 to 1 in WebGL, 0 to 1 in WebGPU, and there is one plane at 0 and one at w if it is reversed too.
  row(to, 4, 2, -1);
  if (camera.coordinateSystem === WEBGPU_COORDINATES || camera.reversedDepth) row(to, 5, 2, 0);
  else row(to, 5, 2, 1);
}

const clip = new Float64Array(16);
const sides = new Float64Array(24);

/** Whether a pass is of a camera: its layers are asked for, and its frustum is this one. */
export function isPassOf(camera, layers, planes) {
  if (camera.layers !== layers) return false;
  if (camera.isArrayCamera || planes.length !== 24) return Boolean(camera.isArrayCamera) && planes.length === 24 * camera.cameras.length;
  planesOfCamera(camera, sides);
  // The four at the sides: those in depth differ by the renderer.
  for (let i = 0; i < 16; i++) if (!(Math.abs(sides[i] - planes[i]) <= 1e-9 * (1 + Math.abs(planes[i])))) return false;
  return true;
}

// w + sign z for a row z of the clip matrix, or the row alone where `sign` is 0.
function row(to, plane, axis, sign) {
  const at = (c) => (sign === 0 ? clip[4 * c + axis] : clip[4 * c + 3] + sign * clip[4 * c + axis]);
  const [x, y, z, w] = [at(0), at(1), at(2), at(3)];
  const scale = 1 / Math.hypot(x, y, z);
  to[4 * plane] = x * scale;
  to[4 * plane + 1] = y * scale;
  to[4 * plane + 2] = z * scale;
  to[4 * plane + 3] = w * scale;
}

/** Planes in the space of an object with the world matrix `m` (sixteen numbers). A flattened object's are not finite. */
export function planesInto(m, world, to) {
  for (let i = 0; i < 24; i += 4) {
    const [x, y, z, w] = [world[i], world[i + 1], world[i + 2], world[i + 3]];
    const a = m[0] * x + m[1] * y + m[2] * z;
    const b = m[4] * x + m[5] * y + m[6] * z;
    const c = m[8] * x + m[9] * y + m[10] * z;
    const scale = 1 / Math.hypot(a, b, c);
    to[i] = a * scale;
    to[i + 1] = b * scale;
    to[i + 2] = c * scale;
    to[i + 3] = (m[12] * x + m[13] * y + m[14] * z + w) * scale;
  }
}

/** The product of two matrices, column-major. */
export function multiply(a, b, to) {
  for (let c = 0; c < 16; c += 4) {
    const [x, y, z, w] = [b[c], b[c + 1], b[c + 2], b[c + 3]];
    for (let r = 0; r < 4; r++) to[c + r] = a[r] * x + a[4 + r] * y + a[8 + r] * z + a[12 + r] * w;
  }
}
