// Horizon culling as in the engine (crates/cullet/src/cull/horizon.rs), operation by operation: a test holds both to the same bits.

// Bound of rounding: 16 u, with u = 2⁻⁵³.
const ROUNDING = 8 * Number.EPSILON;

/** Radii of an ellipsoid that lies at least `depth` below that of `radii` everywhere. */
export function lowered(radii, depth) {
  const flattening = 1 - Math.min(...radii) / Math.max(...radii);
  const by = (depth < 0 ? 0 : depth) * (1 + flattening * flattening) * (1 + ROUNDING);
  return radii.map((r) => r - by);
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
