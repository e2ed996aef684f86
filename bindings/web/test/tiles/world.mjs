// Small worlds of tiles for 3d-tiles-renderer, made here and read from memory; and frames without a picture.

// Packages by their paths in node_modules; a page says how it gets them.
const from = globalThis.fromModules ?? (await import('./modules.mjs')).from;
export const three = await from('three/build/three.module.js');
const { BoxGeometry, BufferGeometry, Float32BufferAttribute, Group, Mesh, MeshBasicMaterial, PerspectiveCamera, Raycaster, Vector2, Vector3 } = three;

// What the renderer needs of a page.
const waiting = [];
globalThis.window ??= { location: { href: 'http://world/' } };
globalThis.requestAnimationFrame = (callback) => waiting.push(callback);
globalThis.cancelAnimationFrame = () => {};
const { LRUCache, DownloadPriorityQueue } = await from('3d-tiles-renderer/build/index.core.js');
const { TilesRenderer } = await from('3d-tiles-renderer/build/index.three.js');

/** A mesh of boxes, each by its least and greatest corner. */
const boxes = (list, material = new MeshBasicMaterial()) => {
  const group = new Group();
  const [positions, normals, indices] = [[], [], []];
  for (const [low, high] of list) {
    const box = new BoxGeometry(...high.map((h, a) => h - low[a])).translate(...high.map((h, a) => (h + low[a]) / 2));
    const first = positions.length / 3;
    positions.push(...box.attributes.position.array);
    normals.push(...box.attributes.normal.array);
    for (const i of box.index.array) indices.push(first + i);
  }
  const geometry = new BufferGeometry().setIndex(indices).setAttribute('position', new Float32BufferAttribute(positions, 3))
    .setAttribute('normal', new Float32BufferAttribute(normals, 3));
  group.add(new Mesh(geometry, material));
  return group;
};

/**
 * A renderer over a tileset in memory: `content[uri]` has the bytes of a file and makes its scene. `slots` downloads run at a time, and
 * each takes `latency` frames.
 */
export function start({ tileset, content }, { camera, plugin, slots = 6, latency = 3, width = 640, height = 400, errorTarget = 16 }) {
  const log = { bytes: 0, loaded: new Set(), requests: 0 };
  const running = [];
  let frame = 0;
  const tiles = new TilesRenderer('http://world/tileset.json');
  tiles.registerPlugin({
    name: 'MEMORY',
    fetchData: (url) => {
      const name = url.split('/').at(-1);
      if (name === 'tileset.json') return Promise.resolve(structuredClone(tileset));
      log.bytes += content[name].bytes;
      log.requests += 1;
      log.loaded.add(name);
      return new Promise((ok) => running.push({ at: frame + latency, ok: () => ok(new TextEncoder().encode(JSON.stringify(name)).buffer) }));
    },
    parseToMesh: (buffer) => Promise.resolve(content[JSON.parse(new TextDecoder().decode(buffer))].make()),
  });
  if (plugin) tiles.registerPlugin(plugin);
  tiles.lruCache = new LRUCache();
  tiles.lruCache.unloadPriorityCallback = (a, b) => a.traversal.lastFrameVisited - b.traversal.lastFrameVisited;
  const { priorityCallback } = tiles.downloadQueue;
  tiles.downloadQueue = new DownloadPriorityQueue();
  tiles.downloadQueue.priorityCallback = priorityCallback;
  tiles.downloadQueue.maxJobsPerOrigin = slots;
  tiles.errorTarget = errorTarget;
  tiles.setCamera(camera);
  tiles.setResolution(camera, width, height);
  const settle = () => new Promise((ok) => { (globalThis.setImmediate ?? setTimeout)(ok); });
  /** One frame: the update, then what the page and the network do until the next. */
  const step = async () => {
    frame += 1;
    camera.updateMatrixWorld();
    tiles.group.updateMatrixWorld();
    tiles.update();
    for (const callback of waiting.splice(0)) callback();
    for (const job of running.splice(0)) {
      if (job.at <= frame) job.ok();
      else running.push(job);
    }
    await settle();
    await settle();
  };
  /** Frames until nothing is on its way; how many. */
  const rest = async (most = 2000) => {
    let quiet = 0;
    for (let i = 0; i < most; i++) {
      await step();
      quiet = running.length === 0 && tiles.stats.queued + tiles.stats.downloading + tiles.stats.parsing === 0 ? quiet + 1 : 0;
      if (quiet > 8) return i - 8;
    }
    throw new Error(`not at rest after ${most} frames: ${JSON.stringify(tiles.stats)}`);
  };
  return { tiles, log, step, rest, camera };
}

export function camera(eye, target, { fov = 60, near = 0.1, far = 5000, up = [0, 0, 1] } = {}) {
  const made = new PerspectiveCamera(fov, 1.6, near, far);
  made.up.set(...up);
  made.position.set(...eye);
  made.lookAt(...target);
  made.updateMatrixWorld();
  return made;
}

/** What a picture of columns × rows shows: the distance and the tile of what each ray meets first. */
export function picture({ tiles, camera: eye }, columns = 32, rows = 20) {
  const ray = new Raycaster();
  const shown = [];
  const meshes = [];
  for (const tile of tiles.visibleTiles) tile.engineData.scene.traverse((o) => { if (o.isMesh) { o.updateWorldMatrix(true, false); meshes.push(o); } });
  for (let y = 0; y < rows; y++) {
    for (let x = 0; x < columns; x++) {
      ray.setFromCamera(new Vector2(((x + 0.5) / columns) * 2 - 1, ((y + 0.5) / rows) * 2 - 1), eye);
      const [hit] = ray.intersectObjects(meshes, false);
      shown.push(hit ? `${hit.object.userData.tile.content.uri} ${hit.distance.toPrecision(9)}` : '');
    }
  }
  return shown;
}

const random = (seed) => {
  let state = seed >>> 0;
  return () => { state = (Math.imul(state, 1664525) + 1013904223) >>> 0; return state / 2 ** 32; };
};

/**
 * A city of `side` × `side` blocks of 40 m with streets of 12 m between, as a quadtree with z up: tiles replace those above them, and have
 * coarser boxes for the same houses. `refine: 'ADD'` has houses in the leaves alone, and ground above.
 */
export function city({ side = 16, refine = 'REPLACE', seed = 7, material, transform } = {}) {
  const next = random(seed);
  const pitch = 52;
  const content = {};
  const houses = new Map();
  for (let x = 0; x < side; x++) {
    for (let y = 0; y < side; y++) {
      // Four houses to a block, without gaps.
      const list = [];
      for (let k = 0; k < 4; k++) {
        const [low, high] = [[x * pitch + 6 + 20 * (k & 1), y * pitch + 6 + 20 * (k >> 1)], 14 + 16 * next()];
        list.push([[low[0], low[1], 0], [low[0] + 20, low[1] + 20, high]]);
      }
      houses.set(`${x} ${y}`, list);
    }
  }
  const tile = (x, y, size) => {
    const uri = `c${x}-${y}-${size}.bin`;
    const all = [];
    for (let i = x; i < x + size; i++) for (let j = y; j < y + size; j++) all.push(...houses.get(`${i} ${j}`));
    const top = Math.max(...all.map(([, high]) => high[2]));
    const [cx, cy, half] = [(x + size / 2) * pitch, (y + size / 2) * pitch, (size * pitch) / 2];
    const ground = [[x * pitch, y * pitch, -1], [(x + size) * pitch, (y + size) * pitch, 0]];
    // Coarse ones are a block each, as high as the lowest house: what stands in for many stays within them.
    const coarse = () => {
      const list = [ground];
      for (let i = x; i < x + size; i++) {
        for (let j = y; j < y + size; j++) list.push([[i * pitch + 6, j * pitch + 6, 0], [i * pitch + 46, j * pitch + 46, Math.min(...houses.get(`${i} ${j}`).map(([, h]) => h[2]))]]);
      }
      return list;
    };
    const isLeaf = size === 1;
    let shown = [ground, ...all];
    if (!isLeaf) shown = refine === 'ADD' ? [] : coarse();
    if (shown.length > 0) content[uri] = { bytes: 20000, make: () => boxes(shown, material) };
    const children = isLeaf ? [] : [0, 1, 2, 3].map((k) => tile(x + (size / 2) * (k & 1), y + (size / 2) * (k >> 1), size / 2));
    return {
      boundingVolume: { box: [cx, cy, (top - 1) / 2, half, 0, 0, 0, half, 0, 0, 0, (top + 1) / 2] },
      geometricError: isLeaf ? 0 : 6 * size,
      refine,
      ...(shown.length > 0 ? { content: { uri } } : {}),
      children,
    };
  };
  const root = tile(0, 0, side);
  if (transform) root.transform = transform;
  const street = (k) => k * pitch;
  return { tileset: { asset: { version: '1.0' }, geometricError: 1000, root }, content, street };
}

/**
 * A wall before a tower, each a tile that replaces; the wall's coarse form is whole, and its fine one has a gate through which the
 * tower is seen.
 */
export function gate() {
  const wall = (list) => () => boxes(list);
  const content = {
    'wall.bin': { bytes: 1000, make: wall([[[-30, 20, 0], [30, 22, 20]]]) },
    'left.bin': { bytes: 1000, make: wall([[[-30, 20, 0], [-3, 22, 20]]]) },
    'right.bin': { bytes: 1000, make: wall([[[3, 20, 0], [30, 22, 20]], [[-3, 20, 10], [3, 22, 20]]]) },
    'tower.bin': { bytes: 1000, make: wall([[[-2, 60, 0], [2, 64, 9]]]) },
    'behind.bin': { bytes: 1000, make: wall([[[12, 60, 0], [16, 64, 9]]]) },
  };
  const tile = (uri, low, high, geometricError, children = []) => {
    const half = high.map((h, a) => (h - low[a]) / 2);
    const box = [...high.map((h, a) => (h + low[a]) / 2), half[0], 0, 0, 0, half[1], 0, 0, 0, half[2]];
    return { boundingVolume: { box }, geometricError, refine: 'REPLACE', ...(uri ? { content: { uri } } : {}), children };
  };
  const fine = [tile('left.bin', [-30, 20, 0], [-3, 22, 20], 0), tile('right.bin', [-3, 20, 0], [30, 22, 20], 0)];
  // What adds to an empty root is drawn as soon as it is there.
  const root = tile(null, [-40, 10, -1], [40, 70, 30], 500, [
    tile('wall.bin', [-30, 20, 0], [30, 22, 20], 40, fine),
    tile('tower.bin', [-2, 60, 0], [2, 64, 9], 0), tile('behind.bin', [12, 60, 0], [16, 64, 9], 0),
  ]);
  return { tileset: { asset: { version: '1.0' }, geometricError: 1000, root: { ...root, refine: 'ADD' } }, content };
}

/**
 * A globe of radius `radius` in `bands` of latitude by twice as many of longitude, with four times as many tiles below each. Its ground is
 * at the height `ground`. `mark(tile, point, isLeaf)` may put a tile's horizon occlusion point where it likes.
 */
export function globe({ radius = 6371000, bands = 6, levels = 3, ground = 0, mark } = {}) {
  const content = {};
  const points = new Map();
  const tile = (west, south, width, level) => {
    const uri = `g${level}-${west.toFixed(4)}-${south.toFixed(4)}.bin`;
    const steps = 8;
    const corner = (i, j) => {
      const [longitude, latitude] = [west + (width * i) / steps, south + (width * j) / steps];
      return [Math.cos(latitude) * Math.cos(longitude), Math.cos(latitude) * Math.sin(longitude), Math.sin(latitude)].map((c) => c * (radius + ground));
    };
    const grid = [];
    for (let i = 0; i <= steps; i++) for (let j = 0; j <= steps; j++) grid.push(corner(i, j));
    points.set(uri, grid);
    const middle = corner(steps / 2, steps / 2);
    const reach = Math.max(...grid.map((p) => Math.hypot(...p.map((c, a) => c - middle[a]))));
    content[uri] = {
      bytes: 50000,
      make: () => {
        const [positions, indices] = [[], []];
        for (const p of grid) positions.push(...p.map((c, a) => c - middle[a]));
        for (let i = 0; i < steps; i++) {
          for (let j = 0; j < steps; j++) {
            const [a, b, c, d] = [i * (steps + 1) + j, (i + 1) * (steps + 1) + j, (i + 1) * (steps + 1) + j + 1, i * (steps + 1) + j + 1];
            indices.push(a, b, c, a, c, d);
          }
        }
        const mesh = new Mesh(new BufferGeometry().setIndex(indices).setAttribute('position', new Float32BufferAttribute(positions, 3)), new MeshBasicMaterial());
        mesh.position.set(...middle);
        return new Group().add(mesh);
      },
    };
    const half = width / 2;
    const children = level === levels ? [] : [0, 1, 2, 3].map((k) => tile(west + half * (k & 1), south + half * (k >> 1), half, level + 1));
    const made = { boundingVolume: { sphere: [...middle, reach * 1.01] }, geometricError: level === levels ? 0 : reach / 8, refine: 'REPLACE', content: { uri }, children };
    mark?.(made, occlusionPoint(grid, middle, radius), level === levels);
    return made;
  };
  const width = Math.PI / bands;
  const children = [];
  for (let i = 0; i < 2 * bands; i++) for (let j = 0; j < bands; j++) children.push(tile(i * width, -Math.PI / 2 + j * width, width, 1));
  const root = { boundingVolume: { sphere: [0, 0, 0, radius * 1.01] }, geometricError: 1e7, refine: 'REPLACE', children };
  return {
    tileset: { asset: { version: '1.0' }, geometricError: 1e8, root, extensionsUsed: ['3DTILES_ellipsoid'], extensions: { '3DTILES_ellipsoid': { body: 'ball', radii: [radius, radius, radius] } } },
    content,
    points,
    radius,
  };
}

// By the angles of the caps that points of a ball see of it; what is below its surface is raised to that.
function occlusionPoint(points, middle, radius) {
  const up = new Vector3(...middle).normalize();
  const angles = points.map((p) => { const v = new Vector3(...p); return v.angleTo(up) + Math.acos(Math.min(1, radius / v.length())); });
  return up.divideScalar(Math.cos(Math.max(...angles) + 1e-7)).toArray();
}

/** Whether the way from an eye to a point passes a ball around the origin. */
export function passes(eye, ballRadius, point) {
  const [from, to] = [new Vector3(...eye), new Vector3(...point)];
  const way = to.clone().sub(from);
  const nearest = Math.min(1, Math.max(0, -from.dot(way) / way.lengthSq()));
  return from.addScaledVector(way, nearest).length() >= ballRadius;
}

/** Whether all of a sphere is behind the sphere of a globe around the origin: by the angles that both fill, from the eye. */
export function isBehind(eye, globeRadius, [x, y, z, radius]) {
  const to = new Vector3(x, y, z).sub(eye);
  const [away, far] = [to.length(), eye.length()];
  if (radius >= away) return false;
  const between = to.angleTo(eye.clone().negate());
  // Beyond the circle where rays touch the globe.
  const reach = Math.sqrt(far * far - globeRadius * globeRadius);
  return between + Math.asin(radius / away) <= Math.asin(globeRadius / far) && away * Math.cos(between) - radius > (reach * reach) / far;
}
