// What the tests call in the page, as window.t.

import { Culling, init } from 'cullet/three';
import { groves } from './groves.js';
import { chosen, compare, early } from './pairs.js';
import { random, scenes } from './scenes.js';
import { towns } from './towns.js';

const SIZE = [320, 192];
let three, renderer;
let now = null;
let last = null;

async function start(api) {
  // Both have the same classes in the same file, but tell them apart as a user's page does.
  three = await import(api === 'webgl' ? 'three' : 'three/webgpu');
  await init();
  const canvas = document.body.appendChild(document.createElement('canvas'));
  renderer = api === 'webgl' ? new three.WebGLRenderer({ canvas, antialias: false }) : new three.WebGPURenderer({ canvas, antialias: false });
  renderer.setPixelRatio(1);
  renderer.setSize(...SIZE);
  renderer.shadowMap.enabled = true;
  await renderer.init?.();
  return renderer.backend?.constructor.name ?? 'WebGLRenderer';
}

/** Makes a scene anew: `{ scene, camera, step(i), ... }` of scenes.js. */
async function build(name, ...values) {
  now?.culling?.dispose();
  now?.end?.();
  const made = await { ...scenes, ...towns, ...groves }[name](three, SIZE, ...values);
  renderer.shadowMap.type = three[made.shadowType ?? 'PCFShadowMap'];
  now = Object.assign(made, { culling: null });
  return Object.keys(now);
}

// `pixels`, `corners`: levels of a scene that has some.
function cull({ occlusion, pixels, corners, ...options } = {}) {
  now.culling = new Culling(now.root ?? now.scene, { ...now.options, ...options, occlusion: occlusion ? now.camera : undefined });
  if (pixels !== undefined) now.levels(now.culling, pixels, { corners });
}

function never() {
  now.scene.traverse((o) => { o.frustumCulled = false; if (o.isBatchedMesh) o.perObjectFrustumCulled = false; });
}

async function finish() {
  if (renderer.backend?.device) await renderer.backend.device.queue.onSubmittedWorkDone();
  else { const gl = renderer.getContext(); gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4)); }
}

const calls = () => (renderer.isWebGPURenderer ? renderer.info.render.drawCalls : renderer.info.render.calls);

// WebGPURenderer draws shadow maps once for each of its own animation frames.
const frame = () => new Promise((ok) => requestAnimationFrame(() => ok()));

/** The picture as a digest, its colours, and what was drawn for it; in a frame of its own. */
async function picture(isOwn = true) {
  if (isOwn) await frame();
  const copy = document.createElement('canvas');
  [copy.width, copy.height] = SIZE;
  const context = copy.getContext('2d');
  renderer.info.reset();
  renderer.render(now.scene, now.camera);
  const drawn = { calls: calls(), triangles: renderer.info.render.triangles };
  // In the task of the drawing: later the canvas may be empty.
  context.drawImage(renderer.domElement, 0, 0);
  const { data } = context.getImageData(0, 0, ...SIZE);
  last = data;
  const digest = [...new Uint8Array(await crypto.subtle.digest('SHA-256', data))].map((b) => b.toString(16).padStart(2, '0')).join('').slice(0, 16);
  return { digest, colours: new Set(new Uint32Array(data.buffer)).size, ...drawn, stats: now.culling && { ...now.culling.stats } };
}

/** Pictures of all steps of a scene. `how`: `none` (nothing is culled), `three`, or options for ours. */
async function pictures(name, how) {
  await build(name);
  if (how === 'none') never();
  else if (how !== 'three') cull(how);
  const list = [await picture()];
  for (let i = 0; i < (now.steps ?? 2); i++) {
    now.step(i, now.culling);
    if (how === 'none') never();
    list.push(await picture());
  }
  return list;
}

/** How many pixels of one picture differ from another, and how many of them have a colour that the other has nowhere within `reach` pixels. */
function off(one, other, reach) {
  const [a, b] = [one, other].map((data) => new Uint32Array(data.buffer));
  const [width, height] = SIZE;
  let [differ, far] = [0, 0];
  for (let i = 0; i < a.length; i++) {
    if (a[i] === b[i]) continue;
    differ += 1;
    const [x, y] = [i % width, Math.floor(i / width)];
    let found = false;
    for (let v = Math.max(0, y - reach); v <= Math.min(height - 1, y + reach); v++) for (let u = Math.max(0, x - reach); u <= Math.min(width - 1, x + reach); u++) found ||= b[width * v + u] === a[i];
    if (!found) far += 1;
  }
  return { differ, far };
}

/** Pictures of all steps of a scene without culling, and in several ways with levels: `[how, reach]` each. How far they are off, to either side. */
async function deviations(name, ways) {
  const data = [];
  for (const [how, reach] of [['none', 0], ...ways]) {
    await build(name);
    if (how === 'none') never(); else cull(how);
    const list = [];
    for (let i = -1; i < now.steps; i++) {
      if (i >= 0) now.step(i, now.culling);
      if (how === 'none') never();
      const { digest, triangles, stats } = await picture();
      const full = data[0]?.[i + 1].last;
      list.push({ digest, triangles, stats, last, ...(full && { ...off(last, full, reach), lost: off(full, last, reach).far }) });
    }
    data.push(list);
  }
  return data.map((list) => list.map((one) => ({ ...one, last: undefined })));
}

const median = (list) => [...list].sort((a, b) => a - b)[list.length >> 1];

/** Milliseconds of `render()` and of the whole frame until all is drawn. `between`: run before each, its time counted. */
async function frames(count = 9, between = () => {}) {
  const [cpu, all] = [[], []];
  for (let i = 0; i < count + 2; i++) {
    // WebGPURenderer draws shadow maps once in a frame.
    await frame();
    const from = performance.now();
    between(i);
    renderer.info.reset();
    renderer.render(now.scene, now.camera);
    const submitted = performance.now() - from;
    const drawn = calls();
    await finish();
    if (i >= 2) { cpu.push(submitted); all.push(performance.now() - from); }
    now.drawn = drawn;
  }
  return { cpu: median(cpu), frame: median(all), calls: now.drawn };
}

/**
 * Compares pictures with and without occlusion for all single properties and `most` pairs, or for those of `only`: what differs, and what
 * hid anything.
 */
async function pairs(most, only) {
  const next = random(7);
  const [wrong, hiding] = [[], []];
  for (const names of only?.map((name) => [name]) ?? chosen(most)) {
    const late = names.map((name) => next() < 0.5 && !early.has(name));
    for (const when of names.length === 1 && !early.has(names[0]) ? [[false], [true]] : [late]) {
      const { differ, hidden } = await compare(three, renderer, Culling, names, when);
      const said = names.map((name, k) => (when[k] ? `${name} later` : name)).join(' and ') || 'nothing';
      if (differ > 0) wrong.push(`${said}: ${differ} pixels`);
      if (hidden > 0) hiding.push(said);
    }
  }
  return { wrong, hiding };
}

window.t = {
  pairs, deviations,
  start, build, cull, never, picture, pictures, frames, frame, finish, Culling,
  get three() { return three; }, get renderer() { return renderer; }, get now() { return now; },
};
document.body.dataset.state = 'ready';
