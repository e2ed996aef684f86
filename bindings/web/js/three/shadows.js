// Shadow maps by what is seen: a caster is drawn only where its shadow may fall on what the camera's pass draws, and a light that has no
// shadow there keeps its map.
//
// What the camera's pass draws is known before any map is drawn: by WebGLRenderer, since it lists objects first; by WebGPURenderer, since it
// draws maps inside the camera's render. Anything that may look up a map elsewhere than at its own surface ends it for that render: `reason`.

import { boxOf, isMorphed, kindOf, Kind, owner } from './bounds.js';
import { Footprint, worldBox } from './footprint.js';
import { callsBack, isKnown } from './hiding.js';

const VARIANCE = 3;

const named = (object) => `${object.type}${object.name ? ` "${object.name}"` : ''}`;

// Of each shadow: whether its map lacks casters, with which renderer and type it was drawn, and whether a render keeps it for now.
const states = new WeakMap();
const stateOf = (shadow) => states.get(shadow) ?? (states.set(shadow, { map: null, type: -1, isPartial: false, isKept: false }), states.get(shadow));

// By renderer: in which of its frames each camera was rendered, and what for last.
const frames = new WeakMap();

const isOwn = (object, name) => object[name] === owner(object, name)?.[name];

// Shadows of three.js's own kinds, which look up one map at the surface alone.
function isKnownShadow({ shadow: s, isDirectionalLight, isSpotLight, isPointLight }) {
  const isKind = (isDirectionalLight && s.isDirectionalLightShadow) || (isSpotLight && s.isSpotLightShadow) || (isPointLight && s.isPointLightShadow);
  return Boolean(isKind) && !Object.hasOwn(s, 'updateMatrices') && isOwn(s, 'getFrustum') && isOwn(s, 'getCamera') && s.getViewportCount() === 1
    && !s.shadowNode && !s.biasNode && !s.filterNode;
}

function holdsMap(value) {
  if (value === null || typeof value !== 'object') return false;
  if (value.isTexture) return value.isRenderTargetTexture === true || value.isDepthTexture === true;
  return (Array.isArray(value) || Object.getPrototypeOf(value) === Object.prototype) && Object.values(value).some(holdsMap);
}

// Why a material may look up shadow maps anywhere; `null` if it does not. Shaders of someone else's get no maps but as uniforms.
function whyAnywhere(material, receives) {
  if (material.onBeforeRender && !isOwn(material, 'onBeforeRender')) return 'has a material with an onBeforeRender of its own';
  if (material.isShaderMaterial) {
    const isBlind = material.lights !== true && isOwn(material, 'onBeforeCompile') && !Object.values(material.uniforms ?? {}).some((uniform) => holdsMap(uniform?.value));
    return isBlind ? null : 'has a shader that may read shadow maps';
  }
  if (!isOwn(material, 'onBeforeCompile')) return 'has an onBeforeCompile';
  if (material.isNodeMaterial && !isKnown(material) && Object.keys(material).some((key) => key.endsWith('Node') && material[key])) return 'has a material with nodes';
  if (!receives || isKnown(material) || material.isShadowMaterial || material.isLineBasicMaterial || material.isPointsMaterial || material.isSpriteMaterial) return null;
  return 'has a material of an unknown kind';
}

const MOST_HALVES = 16;
const Where = { Outside: 0, Partly: 1, Within: 2 };

// Where a box is to planes that look inwards, with a margin for what is rounded.
function whereIn(planes, box) {
  let where = Where.Within;
  for (let i = 0; i < 24; i += 4) {
    let [middle, radius, size] = [planes[i + 3], 0, Math.abs(planes[i + 3])];
    for (let c = 0; c < 3; c++) {
      middle += planes[i + c] * (box[c] + box[3 + c]) / 2;
      radius += Math.abs(planes[i + c]) * (box[3 + c] - box[c]) / 2;
      size += Math.abs(planes[i + c]) * Math.max(Math.abs(box[c]), Math.abs(box[3 + c]));
    }
    if (middle + radius < -1e-5 * size) return Where.Outside;
    if (middle - radius < 0) where = Where.Partly;
  }
  return where;
}

/** What a camera's pass draws that receives shadows. */
export class Receivers {
  boxes = new Float64Array(6 * 256);
  count = 0;
  /** Why all casters are drawn; `null` if some may be left out. */
  reason = null;
  /** Shadows whose maps are drawn whole in this render. */
  whole = new Set();
  /** By shadow, the numbers of those near it; all where there are none. */
  near = new Map();
  #materials = new Map();
  #layers;
  #planes;
  #eye;
  #box = new Float64Array(6);

  /** `planes`: those of the pass; where they are of one camera, only what lies within counts. */
  constructor(layers, planes, camera) {
    this.#layers = layers;
    this.#planes = planes.length === 24 && planes.every(Number.isFinite) ? planes.slice() : null;
    this.#eye = camera.matrixWorld.elements;
  }

  /** Judges an object that is drawn; whether its boxes are to be added. */
  takes(object) {
    if (this.reason || !object.layers.test(this.#layers)) return false;
    if (callsBack(object)) { this.reason = `${named(object)} has an onBeforeRender or onAfterRender of its own`; return false; }
    const receives = object.receiveShadow;
    const { material } = object;
    for (const m of Array.isArray(material) ? material : [material]) {
      if (!m || m.visible === false) continue;
      let why = this.#materials.get(m);
      if (why === undefined) this.#materials.set(m, why = whyAnywhere(m, receives || object.isMesh));
      if (why) { this.reason = `${named(object)} ${why}`; return false; }
    }
    return receives;
  }

  /** Adds a box under a matrix. */
  add(boxes, at, matrix, from) {
    const box = new Float64Array(6);
    worldBox(boxes, at, matrix, from, box, 0);
    if (!box.every(Number.isFinite)) this.reason ??= 'the bounds of what receives shadows are not known';
    this.#addWithin(box, 0);
  }

  // Of a box that is partly in view, what may be: halves of halves, the smaller the nearer.
  #addWithin(box, depth) {
    const where = this.#planes === null || depth === MOST_HALVES ? Where.Within : whereIn(this.#planes, box);
    if (where === Where.Outside) return;
    if (where === Where.Partly) {
      const eye = this.#eye;
      let [axis, away] = [0, 0];
      for (let c = 0; c < 3; c++) {
        if (box[3 + c] - box[c] > box[3 + axis] - box[axis]) axis = c;
        away += Math.max(0, box[c] - eye[12 + c], eye[12 + c] - box[3 + c]) ** 2;
      }
      const side = box[3 + axis] - box[axis];
      if (side > 0 && side ** 2 > 0.1 * away) {
        for (const end of [axis, 3 + axis]) {
          const half = box.slice();
          half[end] = (box[axis] + box[3 + axis]) / 2;
          this.#addWithin(half, depth + 1);
        }
        return;
      }
    }
    if (6 * this.count === this.boxes.length) { const more = new Float64Array(2 * this.boxes.length); more.set(this.boxes); this.boxes = more; }
    this.boxes.set(box, 6 * this.count);
    this.count += 1;
  }

  /** Judges what a scene draws by. */
  takeScene({ overrideMaterial, fogNode, backgroundNode, environmentNode }) {
    if (fogNode || backgroundNode || environmentNode) this.reason ??= 'the scene has nodes';
    const why = overrideMaterial ? whyAnywhere(overrideMaterial, true) : null;
    if (why) this.reason ??= `scene.overrideMaterial ${why}`;
  }

  /** Takes what three.js draws by itself below `top`, except below `except`; lights go to `lights`. Levels of an LOD may not be chosen yet. */
  scan(top, except, lights, isLevel = false) {
    if (top === except || !(top.visible || isLevel)) return;
    if (top.isLight && top.castShadow && top.shadow && top.layers.test(this.#layers)) lights.push(top);
    if (top.material && this.takes(top)) {
      const isPlain = top.isMesh && top.geometry?.attributes?.position && (kindOf(top) === Kind.Mesh) && !isMorphed(top);
      if (isPlain) {
        boxOf(top.geometry, this.#box, 0);
        this.add(this.#box, 0, top.matrixWorld.elements, 0);
      } else this.reason = `${named(top)} receives shadows, and its bounds are not known`;
    }
    for (const child of top.children) this.scan(child, except, lights, top.isLOD);
  }

  /** A number for what is here: another for others. */
  get key() {
    let hash = this.reason ? 1 : 2;
    const words = new Uint32Array(this.boxes.buffer, 0, 12 * this.count);
    for (let k = 0; k < words.length; k++) hash = Math.imul(hash ^ words[k], 16777619);
    return hash;
  }
}

/** Prepares lights for the maps that a render is about to draw: `render` of renders.js, lights, and what receives. How many keep theirs. */
export function prepare(render, lights, receivers) {
  const { renderer, camera, outer, done } = render;
  const { shadowMap } = renderer;
  if (outer) receivers.reason ??= 'a render inside of another';
  if (shadowMap.type === VARIANCE) receivers.reason ??= 'variance shadow maps hold what receives, too';
  if (shadowMap.transmitted) receivers.reason ??= 'coloured shadows hold what lies behind';
  if (!renderer.isWebGLRenderer) draw(renderer, camera, receivers);
  const isStopped = shadowMap.autoUpdate === false;
  let kept = 0;
  for (const light of lights) {
    const { shadow } = light;
    const state = stateOf(shadow);
    if (!(shadow.autoUpdate || state.isKept) || isStopped) {
      // What draws no map from now on gets a whole one first.
      receivers.whole.add(shadow);
      if (!state.isPartial) continue;
      shadow.needsUpdate = true;
      if (isStopped) shadowMap.needsUpdate = true;
      continue;
    }
    if (receivers.reason || !isKnownShadow(light)) { receivers.whole.add(shadow); continue; }
    const isAny = reaches(light, receivers);
    if (isAny || shadow.map === null || state.map !== shadow.map || state.type !== shadowMap.type || shadow.needsUpdate || !shadow.autoUpdate) continue;
    kept += 1;
    state.isPartial = state.isKept = true;
    shadow.autoUpdate = false;
    done.push(() => { shadow.autoUpdate = true; state.isKept = false; });
  }
  return kept;
}

// WebGPURenderer draws a camera's maps once in a frame of its own. A second render with that camera in the frame that sees others, or after
// another camera's, needs them drawn again: the frame is counted on.
function draw(renderer, camera, receivers) {
  let known = frames.get(renderer);
  if (!known) frames.set(renderer, known = { cameras: new WeakMap(), key: 0 });
  const { frame } = renderer.info;
  const key = Math.imul(receivers.key ^ camera.id, 31);
  if (known.cameras.get(camera) === frame && known.key !== key) {
    const nodeFrame = renderer._nodes?.nodeFrame;
    if (nodeFrame) nodeFrame.frameId += 1;
    else receivers.reason ??= 'this version of three.js draws its maps otherwise';
  }
  known.cameras.set(camera, frame);
  known.key = key;
}

// Whether a light's shadows may fall on anything seen. Leaves its matrices as drawing its map would: they say where its shadows are.
function reaches(light, receivers) {
  const { shadow } = light;
  const { camera } = shadow;
  if (!light.isPointLight) {
    shadow.updateMatrices(light);
    return footprint(shadow, receivers, null).isAny;
  }
  const far = light.distance || camera.far;
  if (far !== camera.far) { camera.far = far; camera.updateProjectionMatrix(); }
  const [x, y, z] = light.matrixWorld.elements.slice(12, 15);
  shadow.matrix.makeTranslation(-x, -y, -z);
  const reach = 1.001 * far + 1.01 * Math.abs(shadow.normalBias);
  const { boxes, count } = receivers;
  const near = [];
  for (let k = 0, at = 0; k < count; k++, at += 6) {
    const isFar = boxes[at] > x + reach || boxes[at + 3] < x - reach || boxes[at + 1] > y + reach || boxes[at + 4] < y - reach || boxes[at + 2] > z + reach || boxes[at + 5] < z - reach;
    if (!isFar) near.push(at);
  }
  receivers.near.set(shadow, near);
  return near.length > 0;
}

function footprint(shadow, { boxes, count }, near) {
  const made = new Footprint(shadow);
  if (near) for (const at of near) made.receive(boxes, at);
  else for (let at = 0; at < 6 * count; at += 6) made.receive(boxes, at);
  return made;
}

/** What decides which casters a pass draws: `casts(boxes, at)`, for boxes in the world; `null` where all are drawn. */
export function casting(shadow, receivers, renderer) {
  const state = stateOf(shadow);
  state.map = shadow.map;
  state.type = renderer.shadowMap.type;
  state.isPartial = receivers !== null && receivers.reason === null && !receivers.whole.has(shadow);
  if (!state.isPartial) return null;
  if (renderer.logarithmicDepthBuffer && shadow.bias !== 0) return (state.isPartial = false, null);
  return footprint(shadow, receivers, receivers.near.get(shadow) ?? null);
}

/** Has maps that lack casters drawn whole once more. */
export function complete(lights) {
  for (const { shadow } of lights) if (states.get(shadow)?.isPartial) { shadow.needsUpdate = true; states.get(shadow).isPartial = false; }
}
