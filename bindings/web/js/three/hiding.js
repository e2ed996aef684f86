// What hides others, and what may be hidden: every property of three.js that decides it, one by one.
//
// To hide, a mesh must write its colour and its depth over all of its triangles. To be hidden, it must be drawn only where nothing
// nearer was written. And no object of the pass may make depth farther again, for then what was hidden shows. What is not known here
// hides nothing.
//
// | property | decision |
// |---|---|
// | `material.type`, its class | hides if it is one of three.js's opaque kinds; a node material of a class of someone else's does not |
// | any `...Node` of a node material | does not hide, for it may discard; with `depthNode` it is not hidden either |
// | `onBeforeCompile`, `ShaderMaterial`, `displacementMap` | left to three.js as a whole (bounds.js) |
// | `defines` | hides with those of three.js alone |
// | `visible`, `layers` of mesh, holders and camera | what the pass does not draw hides nothing |
// | `blending` | hides with `NoBlending`, and with `NormalBlending` where it is not `transparent` |
// | `transparent`, `alphaTest`, `alphaMap`, `alphaHash`, `alphaToCoverage`, `transmission` | does not hide |
// | `opacity`, `premultipliedAlpha`, `vertexColors`, `map`, `forceSinglePass`, `dithering`, `fog`, ... | no matter: opaque kinds write 1 as alpha, unblended |
// | `colorWrite` | without it does not hide: drawn last, it would leave the colour of what is behind |
// | `depthWrite`, `depthTest` | without either does not hide; without `depthTest` is not hidden |
// | `depthFunc` | hides with `LessEqualDepth`; hidden with that, `LessDepth` or `EqualDepth` |
// | `side` | hides from its front or both sides; `BackSide` does not hide |
// | `wireframe` | does not hide; wires are not hidden, for lines are wider than edges |
// | `clippingPlanes` of a material or a renderer, `ClippingGroup` | what a plane may touch does not hide; what is clipped away is not drawn (clip.js) |
// | `polygonOffset`, `stencilWrite` | neither hides nor is hidden |
// | `material` as a list, `geometry.drawRange` | does not hide |
// | `geometry` with targets of a morph, `frustumCulled = false`, skins | neither hides nor is hidden (bounds.js) |
// | `renderOrder`, `sortObjects` | no matter: whoever is drawn last, the nearer opaque one stays |
// | `scene.overrideMaterial` | both materials must hide, or be hidden; `allowOverride` is no matter then |
// | depth that is written where it is farther (`AlwaysDepth`, `GreaterDepth`, ...; in WebGPU without `depthTest`) | nothing is hidden in that pass |
// | `onBeforeRender`, `onAfterRender` of an object or material that is drawn | nothing is hidden, unless the page vouches for them: they may clear depth |
// | a target or context without depth | nothing is hidden |
// | `logarithmicDepthBuffer`, `reversedDepthBuffer`, scissors, `autoClear`, tone mapping | no matter |

import { owner } from './bounds.js';

const [FRONT_SIDE, DOUBLE_SIDE] = [0, 2];
const [LESS, LESS_EQUAL, EQUAL] = [2, 3, 4];
const [NO_BLENDING, NORMAL_BLENDING] = [0, 1];

const OPAQUE = new Set(['Basic', 'Lambert', 'Phong', 'Standard', 'Physical', 'Toon', 'Normal', 'Matcap']
  .flatMap((kind) => [`Mesh${kind}Material`, `Mesh${kind}NodeMaterial`]));
const DEFINES = new Set(['STANDARD', 'PHYSICAL', 'TOON', 'MATCAP']);

/** What a material lets its mesh do, as bits. */
export const May = { Hide: 1, HideTwoSided: 2, BeHidden: 4, ResetDepth: 8, CallBack: 16 };

const nodesOf = (m) => (m.isNodeMaterial ? Object.keys(m).filter((key) => key.endsWith('Node') && m[key]) : []);

// Of a node material the class itself has a `type`; one of someone else's has inherited it.
export const isKnown = (m) => OPAQUE.has(m.type) && (m.isNodeMaterial ? Object.hasOwn(m.constructor, 'type') && nodesOf(m).length === 0 : true)
  && Object.keys(m.defines ?? {}).every((name) => DEFINES.has(name));

const isOpaque = (m) => (m.blending === NO_BLENDING || m.blending === NORMAL_BLENDING) && !m.transparent && !(m.alphaTest > 0)
  && !m.alphaMap && !m.alphaHash && !m.alphaToCoverage && !(m.transmission > 0);

const hides = (m) => m.visible && m.colorWrite && m.depthTest && m.depthWrite && m.depthFunc === LESS_EQUAL && isOpaque(m)
  && (m.side === FRONT_SIDE || m.side === DOUBLE_SIDE) && !m.wireframe && !m.polygonOffset && !m.stencilWrite && isKnown(m);

const isHidden = (m) => m.depthTest && (m.depthFunc === LESS || m.depthFunc === LESS_EQUAL || m.depthFunc === EQUAL)
  && !m.polygonOffset && !m.stencilWrite && !m.wireframe && !m.depthNode && !m.fragmentNode;

const isMonotonic = ({ depthFunc: f }) => f === 0 || f === LESS || f === LESS_EQUAL || f === EQUAL;

/** All of a material that matters. `untested`: whether depth is written where `depthTest` is off, as in WebGPU. */
export function judge(m, untested) {
  const resets = m.depthWrite !== false && (m.depthTest === false ? untested : !isMonotonic(m));
  return (hides(m) ? (m.side === DOUBLE_SIDE ? May.HideTwoSided : May.Hide) : 0) | (isHidden(m) ? May.BeHidden : 0)
    | (m.visible && resets ? May.ResetDepth : 0) | (m.visible && m.onBeforeRender !== owner(m, 'onBeforeRender')?.onBeforeRender ? May.CallBack : 0);
}

// A BatchedMesh lists its instances in a callback of its class.
const callbackOf = (object, name) => owner(object, object.isBatchedMesh ? 'addInstance' : name)?.[name];

/** Whether an object has callbacks of its own for when it is drawn. */
export const callsBack = (object) => object.onBeforeRender !== callbackOf(object, 'onBeforeRender')
  || object.onAfterRender !== callbackOf(object, 'onAfterRender');

const hasDepth = new WeakMap();

/** Why nothing may be hidden in a pass of a renderer, whatever is in it; `null` if it may. */
export function refusal(renderer) {
  if (!renderer) return 'the root is in no scene whose render() was heard of';
  const target = renderer.getRenderTarget();
  if (target) return target.depthBuffer === false ? 'the render target has no depth' : null;
  let depth = hasDepth.get(renderer);
  if (depth === undefined) {
    depth = renderer.isWebGLRenderer ? renderer.getContextAttributes()?.depth !== false : renderer.depth !== false;
    hasDepth.set(renderer, depth);
  }
  return depth ? null : 'the renderer has no depth';
}
