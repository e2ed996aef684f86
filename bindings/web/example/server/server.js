// What each player of a game is sent: nothing that he cannot see before the next message reaches him.

import { BODY, free, PROP, WALL } from './level.js';

// Side of a tile, in metres. Walls must be thicker, since a query takes half a tile off each side of them.
const TILE = 1;
// Side of a block of tiles, by which players that are far apart are told to be hidden.
const BLOCK = 4;
const HIDDEN = 1;
const BOX = new Uint32Array([0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4, 2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5]);
const corners = ([x0, y0, z0, x1, y1, z1]) => new Float32Array([x0, y0, z0, x1, y0, z0, x0, y1, z0, x1, y1, z0, x0, y0, z1, x1, y0, z1, x0, y1, z1, x1, y1, z1]);
const AT_ORIGIN = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];
/** Around the bodies of players whose middles are in a rectangle. */
const bodies = ([x0, z0, x1, z1]) => [x0 - BODY.half, 0, z0 - BODY.half, x1 + BODY.half, BODY.high, z1 + BODY.half];

export class Server {
  /**
   * `Scene` is that of `cullet/queries`. Nobody is faster than `speed`, in metres a second. A message is what a client
   * knows for `seconds`: from one tick to the next, and the ping.
   */
  constructor(Scene, level, { speed = 5, seconds = 1 / 30 + 0.1 } = {}) {
    this.level = level;
    this.motion = speed * seconds;
    this.across = Math.ceil(level.side / TILE);
    // Everything, and walls alone: a line from box to box then passes nothing that cannot hide.
    [this.scene, this.walls] = [new Scene(), new Scene()];
    // What each id stands for: a prop, or behind the props a block; -1 for a wall.
    [this.bits, this.boxes] = [[], []];
    const add = (box, hides, bit) => {
      // What is masked hides nothing, but is a body of known bounds.
      const into = (scene) => scene.add(scene.addMesh(corners(box), BOX, { alpha: hides ? 'opaque' : 'masked' }), AT_ORIGIN, { occluder: hides });
      const id = into(this.scene);
      if (hides) into(this.walls);
      [this.bits[id], this.boxes[id]] = [bit, box];
    };
    for (const [x0, z0, x1, z1] of level.walls) add([x0, WALL.low, z0, x1, WALL.high, z1], true, -1);
    level.props.forEach(([x, z], i) => add([x - PROP.half, 0, z - PROP.half, x + PROP.half, PROP.high, z + PROP.half], false, i));
    this.blocks = Math.ceil(level.side / BLOCK);
    for (let i = 0; i < this.blocks ** 2; i++) {
      const [x, z] = [(i % this.blocks) * BLOCK, Math.floor(i / this.blocks) * BLOCK];
      add(bodies([x, z, x + BLOCK, z + BLOCK]), false, level.props.length + i);
    }
    this.scene.commit();
    this.walls.commit();
    this.words = Math.ceil((level.props.length + this.blocks ** 2) / 32);
    this.sets = [];
    this.seen = [];
    this.pairs = new Float64Array(12 * 64);
  }

  /** What may be seen from a tile, a bit each: found once, since walls and props stand. */
  set(tile) {
    if (!this.sets[tile]) {
      const set = this.sets[tile] = new Uint32Array(this.words);
      const [x, z] = [(tile % this.across) * TILE, Math.floor(tile / this.across) * TILE];
      for (const [x0, z0, x1, z1] of free(this.level.walls, [x, z, x + TILE, z + TILE])) {
        const eyes = [x0, BODY.eyes[0], z0, x1, BODY.eyes[1], z1];
        // All walls together, in pictures: quick, and a little too much. Then each thing that is left, by itself.
        const ids = this.scene.visibleFrom(eyes, { cellWorld: TILE, width: 64, nearWorld: 0.02 }).slice().filter((id) => this.bits[id] >= 0);
        ids.forEach((id, i) => this.#ask(i, eyes, this.boxes[id]));
        this.#hidden(ids.length).forEach((state, i) => {
          const bit = this.bits[ids[i]];
          if (state !== HIDDEN) set[bit >> 5] |= 1 << (bit & 31);
        });
      }
    }
    return this.sets[tile];
  }

  /** Finds the sets of all tiles, as a server does when it starts. */
  prepare() {
    for (let tile = 0; tile < this.across ** 2; tile++) this.set(tile);
    return this;
  }

  /** For each player, the numbers of the other players and of the props that he is sent. */
  tick(players) {
    const m = this.motion;
    const { props: { length: props }, walls } = this.level;
    const around = players.map(({ x, z }) => [x - m, z - m, x + m, z + m]);
    const seen = around.map((rectangle, a) => this.#seen(rectangle, a));
    const blocks = around.map((rectangle) => this.#squares(rectangle, BLOCK, this.blocks));
    const sees = (a, b) => blocks[b].some((block) => has(seen[a], props + block));
    const places = around.map((rectangle) => free(walls, rectangle).map(bodies));
    const sent = players.map((_, a) => ({ players: [], props: listed(seen[a], props) }));
    // Pairs that their blocks leave open, both ways at once: eyes are within bodies.
    const asked = [];
    let count = 0;
    for (let a = 0; a < players.length; a++) {
      for (let b = 0; b < a; b++) {
        const [out, back] = [sees(a, b), sees(b, a)];
        if (!out && !back) continue;
        const from = count;
        for (const p of places[a]) for (const q of places[b]) this.#ask(count++, p, q);
        asked.push({ a, b, out, back, from, to: count });
      }
    }
    const hidden = this.#hidden(count);
    for (const { a, b, out, back, from, to } of asked) {
      if (hidden.subarray(from, to).every((state) => state === HIDDEN)) continue;
      if (out) sent[a].players.push(b);
      if (back) sent[b].players.push(a);
    }
    return sent;
  }

  /** The squares of a grid that a rectangle touches. */
  #squares([x0, z0, x1, z1], side, across) {
    const on = (v) => Math.min(Math.max(Math.floor(v / side), 0), across - 1);
    const squares = [];
    for (let j = on(z0); j <= on(z1); j++) for (let i = on(x0); i <= on(x1); i++) squares.push(j * across + i);
    return squares;
  }

  #seen(rectangle, a) {
    const seen = this.seen[a] ??= new Uint32Array(this.words);
    seen.fill(0);
    for (const tile of this.#squares(rectangle, TILE, this.across)) {
      const set = this.set(tile);
      for (let w = 0; w < seen.length; w++) seen[w] |= set[w];
    }
    return seen;
  }

  #ask(i, from, to) {
    if (12 * i === this.pairs.length) {
      const more = new Float64Array(2 * this.pairs.length);
      more.set(this.pairs);
      this.pairs = more;
    }
    this.pairs.set(from, 12 * i);
    this.pairs.set(to, 12 * i + 6);
  }

  #hidden(count) { return this.walls.boxesToBoxes(this.pairs.subarray(0, 12 * count)); }
}

const has = (set, bit) => (set[bit >> 5] >>> (bit & 31)) & 1;

/** The bits of a set below a number. */
function listed(set, below) {
  const bits = [];
  for (let w = 0; w * 32 < below; w++) {
    for (let word = set[w]; word !== 0; word &= word - 1) {
      const bit = w * 32 + 31 - Math.clz32(word & -word);
      if (bit < below) bits.push(bit);
    }
  }
  return bits;
}
