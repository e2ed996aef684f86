// A level of rooms with walls and doors, seen from above: 2D rectangles that the server makes bodies of. y is up.

export const random = (seed) => () => ((seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0) / 2 ** 32);

const THICK = 1.2;
const DOOR = 2;
/** Walls reach below the floor, so that no line along the floor slips under them, and over all heads. */
export const WALL = { low: -1, high: 5 };
/** No player's middle comes nearer to a wall than this. */
export const KEPT_OFF = 0.45;
/** Half the width of a player, the height, and the heights of the eyes. */
export const BODY = { half: 0.4, high: 1.9, eyes: [1.6, 1.8] };
export const PROP = { half: 0.3, high: 1 };

/** `rooms` × `rooms` rooms of `size` metres; rectangles are [x0, z0, x1, z1]. */
export function level({ rooms = 10, size = 10, props = 2000, seed = 1 } = {}) {
  const next = random(seed);
  const side = rooms * size;
  const walls = [];
  for (let i = 0; i <= rooms; i++) {
    for (const turned of [false, true]) {
      let start = 0;
      const end = (at, again) => {
        if (at - start > THICK) {
          const [low, high] = [i * size - THICK / 2, i * size + THICK / 2];
          walls.push(turned ? [low, start - THICK / 2, high, at + THICK / 2] : [start - THICK / 2, low, at + THICK / 2, high]);
        }
        start = again;
      };
      for (let k = 0; k < rooms; k++) {
        const kind = i === 0 || i === rooms ? 0 : next();
        // Half a wall's thickness is added to both ends, which leaves a door of its width.
        const gap = DOOR + THICK;
        const door = k * size + 2 + next() * (size - 4 - gap);
        if (kind >= 0.9) end(k * size, (k + 1) * size);
        else if (kind > 0.5) end(door, door + gap);
      }
      end(side, side);
    }
  }
  const things = [];
  while (things.length < props) {
    const [x, z] = [next() * side, next() * side];
    if (isFree(walls, x, z)) things.push([x, z]);
  }
  return { side, walls, props: things };
}

/** Whether a player may stand here. */
export const isFree = (walls, x, z) => walls.every(([a, b, c, d]) => x <= a - KEPT_OFF || x >= c + KEPT_OFF || z <= b - KEPT_OFF || z >= d + KEPT_OFF);

/** The parts of a rectangle in which a player's middle may be. */
export function free(walls, rectangle) {
  let parts = [rectangle];
  for (const wall of walls) {
    const [a, b, c, d] = [wall[0] - KEPT_OFF, wall[1] - KEPT_OFF, wall[2] + KEPT_OFF, wall[3] + KEPT_OFF];
    if (a >= rectangle[2] || c <= rectangle[0] || b >= rectangle[3] || d <= rectangle[1]) continue;
    parts = parts.flatMap(([x0, z0, x1, z1]) => {
      if (a >= x1 || c <= x0 || b >= z1 || d <= z0) return [[x0, z0, x1, z1]];
      const [l, r] = [Math.max(a, x0), Math.min(c, x1)];
      return [[x0, z0, a, z1], [c, z0, x1, z1], [l, z0, r, b], [l, d, r, z1]].filter(([p, q, r2, s]) => p <= r2 && q <= s);
    });
  }
  return parts;
}

/** Players that run about: `step(seconds)` moves them, never faster than `speed`. */
export function players({ walls, side }, { count = 64, speed = 5, seed = 2 } = {}) {
  const next = random(seed);
  const all = [];
  while (all.length < count) {
    const [x, z] = [next() * side, next() * side];
    if (isFree(walls, x, z)) all.push({ x, z, heading: next() * 2 * Math.PI });
  }
  const step = (seconds) => {
    for (const p of all) {
      const [x, z] = [p.x + Math.cos(p.heading) * speed * seconds, p.z + Math.sin(p.heading) * speed * seconds];
      if (isFree(walls, x, z)) [p.x, p.z] = [x, z];
      else p.heading = next() * 2 * Math.PI;
      if (next() < seconds / 2) p.heading += (next() - 0.5) * 2;
    }
  };
  return { all, step };
}
