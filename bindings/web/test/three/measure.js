// What measure.mjs runs in the page.

import { random } from './scenes.js';

const median = (list) => [...list].sort((a, b) => a - b)[list.length >> 1];

const place = (object, next) => {
  object.position.set(next() * 200 - 100, next() * 200 - 100, next() * 200 - 100);
  object.rotation.set(next() * 6, next() * 6, next() * 6);
  object.updateMatrix();
};

function cameraOf(T) {
  const camera = new T.PerspectiveCamera(60, 1.6, 0.1, 100);
  camera.lookAt(1, 0.2, 0.4);
  return camera;
}

function inViewOf(meshes, camera) {
  const T = t.three;
  camera.updateMatrixWorld();
  const frustum = new T.Frustum().setFromProjectionMatrix(new T.Matrix4().multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse), camera.coordinateSystem);
  return meshes.filter((mesh) => mesh.intersectsFrustum(frustum));
}

/**
 * `count` meshes, nothing drawn, so that a render() is its walk and its culling; one scene, in turn by itself (`three`), watched, standing
 * still, and `floor`: with nothing but the meshes in view among its children, no test and no matrices, which is what three.js does
 * with what any culling leaves. Milliseconds, a median of `frames` for each of `rounds`, and the meshes in view.
 */
export function meshes(count, rounds, frames = 20) {
  const T = t.three;
  const next = random(7);
  const scene = new T.Scene();
  const camera = cameraOf(T);
  const geometry = new T.BoxGeometry();
  const material = new T.MeshBasicMaterial({ visible: false });
  const all = [];
  for (let i = 0; i < count; i++) { const mesh = new T.Mesh(geometry, material); place(mesh, next); scene.add(mesh); all.push(mesh); }
  const run = (between = () => {}) => {
    const list = [];
    camera.rotation.y = 0;
    for (let i = 0; i < frames + 3; i++) {
      camera.rotation.y += 0.001;
      between(i);
      const start = performance.now();
      t.renderer.render(scene, camera);
      if (i >= 3) list.push(performance.now() - start);
    }
    return median(list);
  };
  const tenth = (i) => { for (let k = i % 10; k < count; k += 10) all[k].position.y += 0.01; };
  const ours = (still, between) => {
    const culling = new t.Culling(scene, { still });
    const time = run(between);
    const { visible } = culling.stats;
    culling.dispose();
    return [time, visible];
  };
  const times = { three: [], watching: [], still: [], floor: [], 'three, a tenth moving': [], 'watching, a tenth moving': [] };
  const visible = {};
  for (let r = 0; r < rounds; r++) {
    times.three.push(run());
    for (const how of ['watching', 'still']) { const [time, seen] = ours(how === 'still'); times[how].push(time); visible[how] = seen; }
    const { children } = scene;
    const inView = inViewOf(all, camera);
    visible.three = inView.length;
    for (const mesh of inView) mesh.frustumCulled = false;
    scene.matrixWorldAutoUpdate = false;
    scene.children = inView;
    times.floor.push(run());
    scene.children = children;
    scene.matrixWorldAutoUpdate = true;
    for (const mesh of inView) mesh.frustumCulled = true;
    times['three, a tenth moving'].push(run(tenth));
    times['watching, a tenth moving'].push(ours(false, tenth)[0]);
  }
  return { times, visible };
}

/** The list of a BatchedMesh: drawn, it would be the driver's time. In turn by three.js and with culling. */
export function batch(count, rounds, frames = 20) {
  const T = t.three;
  const next = random(7);
  const scene = new T.Scene();
  const camera = cameraOf(T);
  const dummy = new T.Object3D();
  const mesh = new T.BatchedMesh(count, 24, 36, new T.MeshBasicMaterial());
  const id = mesh.addGeometry(new T.BoxGeometry());
  for (let i = 0; i < count; i++) { place(dummy, next); mesh.setMatrixAt(mesh.addInstance(id), dummy.matrix); }
  mesh.sortObjects = false;
  scene.add(mesh);
  scene.updateMatrixWorld();
  const times = { three: [], still: [] };
  const visible = {};
  for (let r = 0; r < rounds; r++) {
    for (const how of Object.keys(times)) {
      const culling = how === 'still' ? new t.Culling(scene, { still: true }) : null;
      const list = [];
      camera.rotation.y = 0;
      for (let i = 0; i < frames + 3; i++) {
        camera.rotation.y += 0.001;
        const start = performance.now();
        scene.updateMatrixWorld();
        camera.updateMatrixWorld();
        mesh._updateDrawParameters(camera, mesh.geometry, mesh.material);
        if (i >= 3) list.push(performance.now() - start);
      }
      times[how].push(median(list));
      visible[how] = mesh._multiDrawCount;
      culling?.dispose();
    }
  }
  return { times, visible };
}
