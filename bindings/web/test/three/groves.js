// Scenes of instances with levels of detail: balls of fewer and fewer triangles, each with its measured error, in a BatchedMesh or as an
// InstancedMesh. Colours are flat, so that pictures differ only where outlines do.

import { bakedLevels } from 'cullet/three';
import { random, stage } from './scenes.js';

const COUNT = 120;
const STEPS = [[32, 24], [20, 14], [12, 8], [8, 5], [5, 3]];

/** Balls of radius 1, the finest first, as levels. */
export function balls(T) {
  return STEPS.map(([across, up], k) => {
    const geometry = new T.SphereGeometry(1, across, up);
    return { geometry, error: k === 0 ? 0 : 1 - innermost(T, geometry) };
  });
}

// How near the middle the surface comes: the planes of its triangles do not come nearer. All other balls lie between that and 1.
function innermost(T, { attributes: { position }, index }) {
  const [a, b, c] = [0, 1, 2].map(() => new T.Vector3());
  const triangle = new T.Triangle(a, b, c);
  let least = 1;
  for (let k = 0; k < index.count; k += 3) {
    for (const [i, p] of [a, b, c].entries()) p.fromBufferAttribute(position, index.getX(k + i));
    if (triangle.getArea() > 1e-9) least = Math.min(least, Math.abs(triangle.getNormal(new T.Vector3()).dot(a)));
  }
  return least;
}

const colourOf = (T, k) => new T.Color().setHSL((k % 12) / 12, 0.8, 0.3 + 0.1 * (k % 3));

/** Many of one geometry: `{ mesh, set(k, matrix), chain }`. `levels`: `{ geometry, error }`, the finest first. */
export function many(T, isBatch, levels, count, material) {
  if (!isBatch) {
    const mesh = new T.InstancedMesh(levels[0].geometry, material, count);
    for (let k = 0; k < count; k++) mesh.setColorAt(k, colourOf(T, k));
    return { mesh, chain: levels, set: (k, matrix) => { mesh.setMatrixAt(k, matrix); mesh.instanceMatrix.needsUpdate = true; } };
  }
  const sum = (of) => levels.reduce((all, { geometry }) => all + of(geometry), 0);
  const mesh = new T.BatchedMesh(count, sum((g) => g.attributes.position.count) + 100, sum((g) => g.index.count) + 100, material);
  const chain = levels.map(({ geometry, error }) => ({ geometry: mesh.addGeometry(geometry), error }));
  for (let k = 0; k < count; k++) mesh.setColorAt(mesh.addInstance(chain[0].geometry), colourOf(T, k));
  return { mesh, chain, set: (k, matrix) => mesh.setMatrixAt(k, matrix) };
}

function grove(T, size, isBatch) {
  const { scene, camera, turn } = stage(T, size);
  const next = random(17);
  const material = new T.MeshBasicMaterial();
  const { mesh, chain, set } = many(T, isBatch, balls(T), COUNT, material);
  const [at, quaternion, scale] = [new T.Vector3(), new T.Quaternion(), new T.Vector3()];
  const put = (k) => {
    at.set((next() - 0.5) * 60, next() * 6, (next() - 0.5) * 60);
    quaternion.setFromEuler(new T.Euler(6 * next(), 6 * next(), 6 * next()));
    // Stretched along its axes by half as much again.
    scale.setScalar(0.3 + next()).multiply({ x: 1, y: 1 + 0.5 * next(), z: 1 });
    set(k, new T.Matrix4().compose(at, quaternion, scale));
  };
  for (let k = 0; k < COUNT; k++) put(k);
  mesh.position.set(2, 0, 1);
  mesh.scale.setScalar(1.2);
  scene.add(mesh);
  const plan = new T.OrthographicCamera(-40, 40, 24, -24, 1, 100);
  plan.position.set(0, 50, 0);
  plan.lookAt(0, 0, 0);
  const made = {
    scene, camera, mesh, chain, steps: 4,
    levels: (culling, pixels, options) => culling.levels(mesh, chain, { pixels, ...options }),
    step(i) {
      if (i === 0) turn(2.2);
      if (i === 1) { for (let k = 0; k < COUNT / 3; k++) put(k); mesh.rotation.y = 0.4; }
      if (i === 2) camera.position.set(6, 2, -9);
      if (i === 3) made.camera = plan;
    },
  };
  return made;
}

// A wall whose coarser level is smaller, by the error that is told, and what stands behind its edge.
function edge(T, size, isBatch) {
  const { scene, camera } = stage(T, size);
  const [wall, less] = [12, 8].map((side) => new T.BoxGeometry(side, side, 0.5));
  const levels = [{ geometry: wall, error: 0 }, { geometry: less, error: 3 }];
  const { mesh, chain, set } = many(T, isBatch, levels, 2, new T.MeshBasicMaterial());
  set(0, new T.Matrix4().setPosition(0, 3, -20));
  set(1, new T.Matrix4().setPosition(0, 3, 20));
  scene.add(mesh);
  const behind = Array.from({ length: 60 }, (_, k) => {
    const one = new T.Mesh(new T.BoxGeometry(0.4, 0.4, 0.4), new T.MeshBasicMaterial({ color: colourOf(T, k) }));
    const angle = (k / 60) * 2 * Math.PI;
    const reach = 5 / Math.max(Math.abs(Math.cos(angle)), Math.abs(Math.sin(angle)));
    one.position.set(reach * Math.cos(angle), 3 + reach * Math.sin(angle), -22);
    scene.add(one);
    return one;
  });
  camera.rotation.set(0, 0, 0);
  return {
    scene, camera, mesh, chain, behind, steps: 2,
    levels: (culling, pixels, options) => culling.levels(mesh, chain, { pixels, ...options }),
    // Nearer, so that the wall is drawn in full, and away again.
    step(i) { camera.position.z = i === 0 ? -8 : 0; },
  };
}

// A ball beside the picture whose shadow falls into it, and one in the picture.
function shade(T, size, isBatch) {
  const { scene, camera } = stage(T, size, { light: false });
  const ground = new T.Mesh(new T.PlaneGeometry(60, 60), new T.MeshLambertMaterial({ color: 0x99aa99 }));
  ground.rotation.x = -Math.PI / 2;
  ground.receiveShadow = true;
  const { mesh, chain, set } = many(T, isBatch, balls(T), 2, new T.MeshLambertMaterial());
  set(0, new T.Matrix4().makeScale(2, 2, 2).setPosition(0, 14, -12));
  set(1, new T.Matrix4().setPosition(3, 1, -12));
  mesh.castShadow = true;
  const sun = new T.DirectionalLight(0xffffff, 2);
  sun.position.set(0, 40, -8);
  sun.target.position.set(0, 0, -12);
  sun.castShadow = true;
  sun.shadow.mapSize.set(512, 512);
  Object.assign(sun.shadow.camera, { left: -8, right: 8, top: 8, bottom: -8, near: 1, far: 60 });
  scene.add(ground, mesh, sun, sun.target, new T.AmbientLight(0xffffff, 0.6));
  camera.rotation.set(-0.25, 0, 0);
  return {
    scene, camera, mesh, chain, steps: 1,
    levels: (culling, pixels, options) => culling.levels(mesh, chain, { pixels, ...options }),
    // Only the first is left, beside the picture.
    step() { set(1, new T.Matrix4().setPosition(3, 1, 200)); },
  };
}

// Rings of two halves, from a file that `cullet bake` wrote.
async function rings(T, size, isBatch) {
  const { GLTFLoader } = await import('three/addons/loaders/GLTFLoader.js');
  const gltf = await new GLTFLoader().loadAsync('/test/three/ring.glb');
  const chains = [...(await bakedLevels(gltf)).values()];
  const { scene, camera } = stage(T, size);
  const halves = chains.map((chain, half) => {
    const made = many(T, isBatch, chain, 40, new T.MeshBasicMaterial());
    for (let k = 0; k < 40; k++) {
      made.set(k, new T.Matrix4().makeRotationX(k).setPosition(3 * (k % 8) - 10 + 0.1 * half, 3 * Math.floor(k / 8) - 4, -10 - 5 * (k % 5)));
      made.mesh.setColorAt(k, colourOf(T, k + 5 * half));
    }
    scene.add(made.mesh);
    return made;
  });
  camera.rotation.set(0, 0, 0);
  return {
    scene, camera, steps: 1,
    levels: (culling, pixels, options) => { for (const { mesh, chain } of halves) culling.levels(mesh, chain, { pixels, ...options }); },
    step() { camera.position.z = 30; },
  };
}

export const groves = Object.fromEntries(Object.entries({ grove, edge, shade, rings }).flatMap(([name, make]) => [
  [`${name}Batched`, (T, size) => make(T, size, true)],
  [`${name}Instanced`, (T, size) => make(T, size, false)],
]));
