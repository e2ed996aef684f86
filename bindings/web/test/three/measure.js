// What measure.mjs runs in the page.

import { random } from './scenes.js';

const frustumOf = (camera) => new t.three.Frustum().setFromProjectionMatrix(new t.three.Matrix4().multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse), camera.coordinateSystem);

const median = (list) => [...list].sort((a, b) => a - b)[list.length >> 1];

/**
 * `how`: none (no culling, no test), three, watching, still, one of two with a tenth moving, or floor: three.js with nothing but the
 * meshes in view in its scene, no test and no matrices, which is what it does with what any culling leaves.
 */
export function culling(how, kind, count, frames = 15) {
  const T = t.three;
  const { renderer } = t;
  const next = random(7);
  const scene = new T.Scene();
  const camera = new T.PerspectiveCamera(60, 1.6, 0.1, 100);
  camera.lookAt(1, 0.2, 0.4);
  const geometry = new T.BoxGeometry();
  const material = new T.MeshBasicMaterial();
  const dummy = new T.Object3D();
  const place = (object) => {
    object.position.set(next() * 200 - 100, next() * 200 - 100, next() * 200 - 100);
    object.rotation.set(next() * 6, next() * 6, next() * 6);
    object.updateMatrix();
  };
  const meshes = [];
  if (kind === 'mesh') {
    for (let i = 0; i < count; i++) { const mesh = new T.Mesh(geometry, material); place(mesh); scene.add(mesh); meshes.push(mesh); }
    material.visible = false;
  } else {
    const mesh = new T.BatchedMesh(count, 24, 36, material);
    const id = mesh.addGeometry(geometry);
    for (let i = 0; i < count; i++) { place(dummy); mesh.setMatrixAt(mesh.addInstance(id), dummy.matrix); }
    mesh.sortObjects = false;
    if (how === 'none') { mesh.perObjectFrustumCulled = false; }
    scene.add(mesh);
    meshes.push(mesh);
  }
  if (how === 'none') for (const mesh of meshes) mesh.frustumCulled = false;
  scene.updateMatrixWorld();
  let made = null;
  let build = 0;
  if (how === 'watching' || how === 'still' || how === 'moving') {
    const from = performance.now();
    made = new t.Culling(scene, { still: how === 'still' });
    build = performance.now() - from;
  }
  if (how === 'floor') {
    camera.rotation.y += 0.01;
    camera.updateMatrixWorld();
    const frustum = frustumOf(camera);
    const inView = meshes.filter((mesh) => mesh.intersectsFrustum(frustum));
    scene.clear();
    for (const mesh of inView) { mesh.frustumCulled = false; scene.add(mesh); }
    scene.matrixWorldAutoUpdate = false;
  }
  const list = [];
  const worlds = [];
  for (let i = 0; i < frames + 3; i++) {
    if (how.endsWith('moving')) for (let k = i % 10; k < meshes.length; k += 10) meshes[k].position.y += 0.01;
    camera.rotation.y += 0.001;
    const start = performance.now();
    // Of a batch, its list: drawn, it would be the driver's time.
    if (kind === 'batched') { scene.updateMatrixWorld(); camera.updateMatrixWorld(); meshes[0]._updateDrawParameters(camera, meshes[0].geometry, material); } else renderer.render(scene, camera);
    const time = performance.now() - start;
    const again = performance.now();
    if (how !== 'floor') scene.updateMatrixWorld();
    if (i >= 3) { list.push(time); worlds.push(performance.now() - again); }
  }
  let visible;
  if (kind === 'batched') visible = meshes[0]._multiDrawCount;
  else if (made) visible = made.stats.visible;
  else visible = meshes.filter((mesh) => mesh.intersectsFrustum(frustumOf(camera))).length;
  made?.dispose();
  return { time: median(list), matrices: median(worlds), visible, build };
}
