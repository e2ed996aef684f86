// Horizon culling as in the engine (crates/cullet/src/cull/horizon.rs and the files beside it), operation by operation: a test holds
// both to the same bits.

// Bound of rounding: 16 u, with u = 2⁻⁵³.
const ROUNDING = 8 * Number.EPSILON;

// Bound of the rounding of the cosine of a sum of angles.
const SLACK = 8 * ROUNDING;

// Scale of the ellipsoid that is lowered by `depth`, rounded down; 1 where it is not lowered.
const level = (radii, depth) => (depth <= 0 ? 1 : (1 - depth / Math.min(...radii)) * (1 - ROUNDING));

// Sine of an angle up to 90° by its cosine, rounded up.
const sine = (cosine) => Math.sqrt(Math.max((1 - cosine) * (1 + cosine), 0) + ROUNDING);

/** Radii of an ellipsoid of the same shape that lies at least `depth` below that of `radii` everywhere. */
export function lowered(radii, depth) {
  const scale = level(radii, depth);
  return radii.map((r) => r * scale);
}

/**
 * The horizon occlusion point for the ellipsoid that is lowered by `depth`, in space divided by the radii of that, where `point` is one for
 * that of `radii`, in space divided by these; `null` if there is none, or `point` is not made of three finite numbers outside of the ellipsoid.
 */
export function loweredOcclusionPoint(radii, depth, point) {
  const ground = level(radii, depth);
  if (!(ground > 0) || !radii.every((r) => r > 0 && r < Infinity)) return null;
  // A file may have anything here.
  if (!Array.isArray(point) || point.length !== 3 || !point.every(Number.isFinite)) return null;
  const [x, y, z] = point;
  const distance = Math.sqrt(x * x + y * y + z * z);
  if (!(distance >= 1 && distance < Infinity)) return null;
  if (ground === 1) return [x, y, z];
  const cosine = 1 / distance;
  const sum = cosine * ground - sine(cosine) * sine(ground) - SLACK;
  return sum > 0 ? point.map((c) => c / (distance * sum)) : null;
}

/** The horizon of an ellipsoid around the origin, by its radii, for an eye. An eye in or under the surface hides nothing. */
export class Horizon {
  #radii;
  #scale;
  #eye;
  #squared;
  #size;
  #reach;

  constructor([a, b, c], [x, y, z]) {
    this.#radii = [a, b, c];
    const [ex, ey, ez] = this.#eye = [x / a, y / b, z / c];
    const squared = ex * ex + ey * ey + ez * ez;
    const slack = squared * ROUNDING;
    const above = squared - 1;
    const isSolid = this.#radii.every((r) => r > 0 && r < Infinity);
    this.#reach = isSolid && above > slack ? Math.sqrt(above + slack) * (1 + ROUNDING) : NaN;
    this.#scale = (1 + ROUNDING) / Math.min(a, b, c);
    this.#squared = squared + slack;
    this.#size = Math.abs(ex) + Math.abs(ey) + Math.abs(ez);
  }

  /** Whether no point of the hull of points can be seen past the ellipsoid; they have x, y and z. */
  hidesPoints(points) {
    const [a, b, c] = this.#radii;
    for (const p of points) if (!this.#hidesBall(p.x / a, p.y / b, p.z / c, 0)) return false;
    return points.length > 0;
  }

  /** Whether no point of a sphere can be seen past the ellipsoid. */
  hidesSphere({ x, y, z }, radius) {
    const [a, b, c] = this.#radii;
    return radius >= 0 && this.#hidesBall(x / a, y / b, z / c, radius * this.#scale);
  }

  /** Whether everything that a horizon occlusion point of this ellipsoid stands for is hidden. One inside the ellipsoid stands for nothing. */
  hidesOcclusionPoint([x, y, z]) { return x * x + y * y + z * z >= 1 && this.#hidesBall(x, y, z, 0); }

  #hidesBall(x, y, z, radius) {
    const [ex, ey, ez] = this.#eye;
    const [dx, dy, dz] = [x - ex, y - ey, z - ez];
    const size = Math.abs(x) + Math.abs(y) + Math.abs(z);
    const toward = -(ex * dx + ey * dy + ez * dz);
    const slack = ROUNDING * this.#size * (this.#size + size) * (1 + this.#reach);
    const [cx, cy, cz] = [ey * dz - ez * dy, ez * dx - ex * dz, ex * dy - ey * dx];
    const inside = toward - this.#reach * Math.sqrt(cx * cx + cy * cy + cz * cz) - slack;
    if (!(inside > radius * this.#squared * (1 + ROUNDING))) return false;
    const far = Math.sqrt(x * x + y * y + z * z);
    return x * ex + y * ey + z * ez < far - ROUNDING * size * this.#size || (far + radius) * (1 + ROUNDING) <= 1;
  }
}
