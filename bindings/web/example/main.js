// A walk through a city, culled or not: press 1, 2, 3 or the switch.

import * as THREE from 'three';
import { Culling, init } from 'cullet/three';
import { city, sky, walk } from './city.js';

const show = (id, text) => { document.getElementById(id).textContent = text; };
const whole = (n) => Math.round(n).toLocaleString('en');

try { await init(); } catch (error) { show('error', error.message); throw error; }

const renderer = new THREE.WebGLRenderer({ canvas: document.querySelector('canvas'), antialias: true });
const scene = new THREE.Scene();
const camera = new THREE.PerspectiveCamera(65, 1, 0.2, 2000);
sky(THREE, scene);
const group = city(THREE);
const total = group.children.reduce((sum, mesh) => sum + (mesh.count ?? 0), 0);
scene.add(group);

let culling = null;

function choose(how) {
  culling?.dispose();
  culling = how === 'off' ? null : new Culling(scene, { still: true, occlusion: how === 'occlusion' ? camera : undefined });
}

for (const input of document.querySelectorAll('input')) input.addEventListener('change', () => choose(input.value));
addEventListener('keydown', ({ key }) => document.querySelectorAll('input')[Number(key) - 1]?.click());

function resize() {
  renderer.setSize(innerWidth, innerHeight, false);
  camera.aspect = innerWidth / Math.max(1, innerHeight);
  camera.updateProjectionMatrix();
}
addEventListener('resize', resize);
resize();
choose('occlusion');

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
  show('instances', whole(culling ? culling.stats.visibleInstances : total));
  document.body.dataset.state = 'ready';
});
