// Why an object is missing from the picture, in words: by its own properties, or by what the last pass of a camera decided.

import { isMorphed, Kind } from './bounds.js';
import { Fate } from './decisions.js';
import { worldBox } from './footprint.js';
import { isBelow, nameOf } from './roots.js';

// In the order of the planes of a THREE.Frustum.
const SIDES = ['right of it', 'left of it', 'below it', 'above it', 'beyond its far plane', 'behind the camera or nearer than its near plane'];
const box = new Float64Array(6);

// Relative to the frustum: which plane a box lies behind, or that only all planes together leave it out.
function outside(planes, boxes, at, matrix, from) {
  const where = 'outside of the camera\'s frustum';
  if (planes.length !== 24) return 'outside of the frustums of all cameras of the array';
  worldBox(boxes, at, matrix, from, box, 0);
  // What is behind the camera may be beside the frustum, too.
  for (const i of [5, 4, 0, 1, 2, 3]) {
    let farthest = planes[4 * i + 3];
    for (let c = 0; c < 3; c++) farthest += Math.max(planes[4 * i + c] * box[c], planes[4 * i + c] * box[3 + c]);
    if (farthest < 0) return `${where}: it lies ${SIDES[i]}`;
  }
  return where;
}

function ofParts(i, nodes, decision) {
  const { count } = nodes.parts.get(i);
  const lists = decision.lists?.get(i);
  if (!lists) return '';
  const [inside, drawn] = [lists.inside.length, lists.drawn.length];
  return ` ${drawn} of its ${count} instances are drawn, ${count - inside} are outside, ${inside - drawn} are hidden or clipped.`;
}

const isUnseen = ({ material }) => (Array.isArray(material) ? material : [material]).every((m) => m && m.visible === false);

/** `{ reason, text }` for an object, by the `decision` of a camera's last pass. */
export function explain(object, root, nodes, decision) {
  const say = (reason, text) => ({ reason, text: `${nameOf(object)}: ${text}.` });
  if (object !== root && !isBelow(object, root)) return say('three', `not below ${nameOf(root)}, so it is not culled here`);
  for (let o = object; o; o = o.parent) if (!o.visible) return say('invisible', o === object ? 'its `visible` is false' : `the \`visible\` of ${nameOf(o)} above it is false`);
  const i = nodes.numberOf(object);
  const isDrawable = object.isMesh || object.isLine || object.isPoints || object.isSprite;
  if (!isDrawable) return say('empty', 'it draws nothing by itself');
  if (isUnseen(object)) return say('invisible', 'the `visible` of its material is false');
  if (decision === null) return say('unknown', 'no camera has rendered it yet');
  if (!(object.layers.mask & decision.mask)) return say('layers', 'it shares no layer with the camera');
  if (i < 0 || nodes.kinds[i] <= Kind.Container) return say('three', 'three.js culls it by itself, for its bounds or its shaders are not known here');
  if (i >= decision.length) return say('unknown', 'it was added after the last render()');
  if (nodes.kinds[i] !== Kind.Mesh) {
    const more = ofParts(i, nodes, decision);
    const fates = { [Fate.Drawn]: ['drawn', 'it is drawn'], [Fate.Hidden]: ['hidden', 'all its instances in the frustum are hidden or clipped'], [Fate.Outside]: ['outside', 'all its instances are outside of the camera\'s frustum'] };
    const [reason, text] = fates[decision.fates[i]];
    return { reason, text: `${say(reason, text).text}${more}` };
  }
  switch (decision.fates[i]) {
    case Fate.Drawn: return say('drawn', object.frustumCulled && !isMorphed(object) ? 'it is drawn' : 'it is drawn always, since its bounds are not known');
    case Fate.Hidden: return say('hidden', 'it is in the frustum, and other meshes hide all of it');
    case Fate.Clipped: return say('clipped', 'clipping planes take all of it away');
    default: return say('outside', outside(decision.planes, nodes.boxes.boxes, 6 * i, nodes.boxes.matrices, 16 * i));
  }
}

/** The same for one instance, where lists were kept. */
export function explainInstance(object, number, nodes, decision) {
  const lists = decision.lists?.get(nodes.numberOf(object));
  const name = `instance ${number} of ${nameOf(object)}`;
  if (!lists) return `${name}: not known.`;
  if (lists.drawn.includes(number)) return `${name}: it is drawn.`;
  return lists.inside.includes(number) ? `${name}: it is in the frustum, and other meshes hide all of it, or clipping planes take it away.` : `${name}: outside of the camera's frustum.`;
}
