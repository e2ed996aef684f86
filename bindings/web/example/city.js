// A city: blocks of houses with ledges and boxes on their roofs, streets with trees, lamps and cars. All of it is instances.

const random = (seed) => () => ((seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0) / 2 ** 32);

const BLOCK = 36;
const STREET = 14;

/** A group of `count` instances in six `InstancedMesh`es; `THREE` is `three` or `three/webgpu`. */
export function city(THREE, count = 100_000) {
  const next = random(20);
  const lists = { house: [], ledge: [], unit: [], trunk: [], crown: [], car: [] };
  const add = (kind, x, y, z, sx, sy, sz, hue, saturation, light, turn = 0) => lists[kind].push({ x, y, z, sx, sy, sz, turn, colour: [hue, saturation, light] });
  const total = () => Object.values(lists).reduce((sum, list) => sum + list.length, 0);
  const step = BLOCK + STREET;
  const spiral = rings();
  while (total() < count) block(...spiral.next().value);

  function block(bx, bz) {
    const [x0, z0] = [bx * step + STREET / 2, bz * step + STREET / 2];
    const tall = Math.exp(-Math.hypot(bx, bz) / 9);
    for (let i = 0; i < 3; i++) {
      for (let k = 0; k < 3; k++) {
        const w = BLOCK / 3;
        const [x, z] = [x0 + (i + 0.5) * w, z0 + (k + 0.5) * w];
        const storeys = 3 + Math.floor(4 * next() + 26 * tall * next() * next());
        const height = 3.2 * storeys;
        const [hue, light] = [0.05 + 0.08 * next(), 0.45 + 0.3 * next()];
        add('house', x, height / 2, z, w - 0.15, height, w - 0.15, hue, 0.25, light);
        for (let s = 1; s <= storeys; s += 2) add('ledge', x, 3.2 * s, z, w + 0.25, 0.35, w + 0.25, hue, 0.2, light * 0.75);
        for (let u = 0; u < 4; u++) add('unit', x + (next() - 0.5) * (w - 3), height + 0.6, z + (next() - 0.5) * (w - 3), 1 + next() * 1.5, 1.2, 1 + next() * 1.5, 0.6, 0.05, 0.55);
      }
    }
    for (let i = 0; i < 10; i++) {
      const along = (i + 0.5) * (BLOCK / 10);
      for (const [x, z, side] of [[x0 - 2, z0 + along, 0], [x0 + along, z0 - 2, 1]]) {
        if (i % 2 === 0) {
          const size = 0.8 + 0.5 * next();
          add('trunk', x, 1.2 * size, z, 0.3 * size, 2.4 * size, 0.3 * size, 0.08, 0.4, 0.25);
          add('crown', x, 3.6 * size, z, 2.2 * size, 3.2 * size, 2.2 * size, 0.28 + 0.06 * next(), 0.45, 0.3 + 0.1 * next(), next() * 6);
        } else if (next() < 0.8) add('car', x - (side ? 0 : 2.3), 0.7, z - (side ? 2.3 : 0), side ? 4 : 1.8, 1.3, side ? 1.8 : 4, next(), 0.5, 0.45);
      }
    }
  }

  const box = new THREE.BoxGeometry();
  const geometries = { house: box, ledge: box, unit: box, trunk: box, crown: new THREE.IcosahedronGeometry(0.6, 1), car: box };
  const group = new THREE.Group();
  group.name = 'city';
  const [dummy, colour] = [new THREE.Object3D(), new THREE.Color()];
  let left = count;
  for (const [kind, list] of Object.entries(lists)) {
    const length = Math.min(list.length, left);
    left -= length;
    const mesh = new THREE.InstancedMesh(geometries[kind], new THREE.MeshLambertMaterial(), length);
    mesh.name = kind;
    for (let i = 0; i < length; i++) {
      const { x, y, z, sx, sy, sz, turn, colour: c } = list[i];
      dummy.position.set(x, y, z);
      dummy.scale.set(sx, sy, sz);
      dummy.rotation.y = turn;
      dummy.updateMatrix();
      mesh.setMatrixAt(i, dummy.matrix);
      mesh.setColorAt(i, colour.setHSL(...c));
    }
    group.add(mesh);
  }
  const extent = step * 30;
  const ground = new THREE.Mesh(new THREE.PlaneGeometry(2 * extent, 2 * extent), new THREE.MeshLambertMaterial({ color: 0x55585c }));
  ground.rotation.x = -Math.PI / 2;
  group.add(ground);
  return group;
}

// Squares from the middle outwards.
function* rings() {
  yield [0, 0];
  for (let r = 1; ; r++) {
    for (let i = -r; i < r; i++) { yield [i, -r]; yield [r, i]; yield [-i, r]; yield [-r, -i]; }
  }
}

/** Light, sky and haze of the city. Returns the sun. */
export function sky(THREE, scene) {
  scene.background = new THREE.Color(0xbfd6e6);
  scene.fog = new THREE.Fog(0xbfd6e6, 120, 900);
  const sun = new THREE.DirectionalLight(0xfff1dd, 2.2);
  sun.position.set(60, 90, 25);
  scene.add(sun, new THREE.HemisphereLight(0xcfe4f5, 0x6b6458, 1.3));
  return sun;
}

/** Puts a camera at street level, `t` seconds into its walk. */
export function walk(camera, t) {
  const along = (t * 6) % (4 * (BLOCK + STREET));
  camera.position.set(0.5, 1.8, 2 * (BLOCK + STREET) - along);
  camera.rotation.set(0.03, 0.25 * Math.sin(t * 0.35), 0, 'YXZ');
}
