// A walk through a city, culled or not: press 1 to 4 or the switches.

import * as THREE from 'three';
import { Culling, init } from 'cullet/three';
import { city, sky, walk } from './city.js';

const show = (id, text) => { document.getElementById(id).textContent = text; };
const whole = (n) => Math.round(n).toLocaleString('en');

try { await init(); } catch (error) { show('error', error.message); throw error; }

const renderer = new THREE.WebGLRenderer({ canvas: document.querySelector('canvas'), antialias: true });
const scene = new THREE.Scene();
const camera = new THREE.PerspectiveCamera(65, 1, 0.2, 2000);
const sun = sky(THREE, scene);
renderer.shadowMap.enabled = sun.castShadow = true;
sun.shadow.mapSize.set(1024, 1024);
Object.assign(sun.shadow.camera, { left: -150, right: 150, top: 150, bottom: -150, near: 1, far: 400 });
const group = city(THREE);
for (const mesh of group.children) [mesh.castShadow, mesh.receiveShadow] = [mesh.isInstancedMesh === true, true];
scene.add(group);

let culling = null;

const isOn = (id) => document.getElementById(id).checked;

function choose() {
  culling?.dispose();
  culling = isOn('culled') ? new Culling(scene, { still: true, occlusion: isOn('occlusion') ? camera : undefined, shadows: isOn('seen') ? 'seen' : 'all' }) : null;
  if (isOn('inside')) culling?.panel();
}

for (const input of document.querySelectorAll('input')) input.addEventListener('change', choose);
addEventListener('keydown', ({ key }) => document.querySelectorAll('input')[Number(key) - 1]?.click());

function resize() {
  renderer.setSize(innerWidth, innerHeight, false);
  camera.aspect = innerWidth / Math.max(1, innerHeight);
  camera.updateProjectionMatrix();
}
addEventListener('resize', resize);
resize();
choose();

let last = performance.now();
let mean = 0;
let shown = 0;
renderer.setAnimationLoop((time) => {
  walk(camera, time / 1000);
  renderer.render(scene, camera);
  const now = performance.now();
  mean = mean === 0 ? now - last : mean + (now - last - mean) * 0.1;
  last = now;
  if (now - shown < 250) return;
  shown = now;
  show('frame', `${mean.toFixed(1)} ms`);
  show('calls', whole(renderer.info.render.calls));
  show('triangles', whole(renderer.info.render.triangles));
  document.body.dataset.state = 'ready';
});
