// Queries of scenes, and lights of views: what a game asks beside what is drawn.

import { numbers, options, typed, whole, word } from './check.js';
import { CulletError } from './error.js';
import { Scenes } from './scene.js';
import { View, viewsOf } from './view.js';

const U32 = 2 ** 32 - 1;
/** Stands for no instance where an id is expected. */
export const NONE = U32;

const KINDS = ['directional', 'point', 'spot'];
/** Why a light cannot change a picture, by the numbers of `LightAnswer.reasons`; 0 is none. */
export const LIGHT_REASONS = Object.freeze(['kept', 'unlit', 'frustum', 'detail', 'occlusion', 'no-receiver']);
const REGION = ['layers', 'cellWorld', 'mostCells', 'width', 'mostBodies', 'nearWorld'];
const ON_VISIBLE = 1;
const CASTERS = 2;

const one = (what, value) => numbers(what, [value], 1)[0];

/** Writes numbers to where arguments go, one list behind the other. */
function write(engine, ...lists) {
  const length = lists.reduce((sum, list) => sum + list.length, 0);
  const at = engine.scratch(length * 8);
  const to = new Float64Array(engine.buffer, at, length);
  let from = 0;
  for (const list of lists) {
    to.set(list, from);
    from += list.length;
  }
}

const regionOf = (o) => [
  whole('layers', o.layers ?? U32, 0, U32), one('cellWorld', o.cellWorld ?? 2), whole('mostCells', o.mostCells ?? 64, 1, U32),
  whole('width', o.width ?? 512, 8, 4096), whole('mostBodies', o.mostBodies ?? 2048, 0, U32), one('nearWorld', o.nearWorld ?? 0.25),
];

/** How many rows there are of so many numbers each. */
const rowsOf = (what, value, each) => {
  numbers(what, value);
  if (value.length % each !== 0) throw new CulletError('argument', `${what} have ${value.length} numbers, which is not a multiple of ${each}`);
  return value.length / each;
};

/** How far boxes may move: one number, or two. */
function motionOf(given = 0) {
  const both = typeof given === 'number' ? [given, given] : numbers('motion', given, 2);
  for (const motion of both) {
    if (!(motion >= 0)) throw new CulletError('argument', `motion is ${motion}; it must be at least 0, in world units`);
  }
  return both;
}

export class QueryScenes extends Scenes {
  #engine;

  constructor(engine, opened) {
    super(engine, opened);
    this.#engine = engine;
  }

  view(given) { return viewsOf(this.#engine, this, given, QueryView); }

  #lines(lines, count, given) {
    const scene = this.number;
    const o = options('the options of a line of sight', given, ['layers', 'bothSides', 'any', 'ignore']);
    const ignored = typed('ignore', typeof o.ignore === 'number' ? [o.ignore] : o.ignore ?? [], Uint32Array);
    if (ignored.length > 2) throw new CulletError('argument', `ignore has ${ignored.length} ids; it may have 2`);
    const layers = whole('layers', o.layers ?? U32, 0, U32);
    write(this.#engine, ...lines);
    this.#engine.check('query_lines', scene, count, layers, (o.bothSides ? 1 : 0) | (o.any ? 2 : 0), ignored[0] ?? NONE, ignored[1] ?? NONE);
    return this.#engine.answer(Uint32Array);
  }

  lineOfSight(from, to, given) {
    const [id] = this.#lines([numbers('from', from, 3), numbers('to', to, 3)], 1, given);
    if (id === NONE) return null;
    this.#engine.call('query_more', 0);
    const [triangle, share, x, y, z] = this.#engine.answer(Float64Array);
    return { id, triangle, share, point: [x, y, z] };
  }

  linesOfSight(lines, given) { return this.#lines([lines], rowsOf('lines', lines, 6), given); }

  #boxes(pairs, count, given) {
    const scene = this.number;
    const o = options('the options of boxes', given, ['layers', 'splits', 'motion']);
    const layers = whole('layers', o.layers ?? U32, 0, U32);
    const splits = whole('splits', o.splits ?? 0, 0, 16);
    const motion = motionOf(o.motion);
    write(this.#engine, ...pairs);
    this.#engine.check('query_boxes', scene, count, layers, splits, ...motion);
    return this.#engine;
  }

  boxToBox(from, to, given) {
    const engine = this.#boxes([numbers('from', from, 6), numbers('to', to, 6)], 1, given);
    const [id] = engine.answer(Uint32Array);
    engine.call('query_more', 1);
    const hidden = engine.answer(Uint8Array)[0];
    return { sight: ['visible', 'hidden', 'empty'][hidden], by: id === NONE ? null : id };
  }

  boxesToBoxes(pairs, given) {
    const engine = this.#boxes([pairs], rowsOf('pairs', pairs, 12), given);
    engine.call('query_more', 1);
    return engine.answer(Uint8Array);
  }

  visibleFrom(eyes, given) {
    const scene = this.number;
    numbers('eyes', eyes, 6);
    const o = options('the options of a region', given, [...REGION, 'view']);
    if (o.view !== undefined && !(o.view instanceof QueryView)) throw new CulletError('argument', 'view must be made by `scene.view()` of this entry');
    const view = o.view?.number ?? 0;
    write(this.#engine, regionOf(o), eyes);
    this.#engine.check('query_region', scene, view);
    return this.#engine.answer(Uint32Array);
  }

  neededAlong(points, given) {
    const scene = this.number;
    const count = rowsOf('points', points, 3);
    const o = options('the options of a motion', given, [...REGION, 'radiusWorld', 'reachWorld', 'stepWorld', 'mostSteps']);
    const way = [one('radiusWorld', o.radiusWorld ?? 0), one('reachWorld', o.reachWorld ?? Infinity), one('stepWorld', o.stepWorld ?? 4), whole('mostSteps', o.mostSteps ?? 1024, 1, U32)];
    write(this.#engine, regionOf(o), way, points);
    this.#engine.check('query_motion', scene, count);
    const ids = this.#engine.answer(Uint32Array);
    this.#engine.call('query_more', 0);
    return { ids, distances: this.#engine.answer(Float64Array) };
  }
}

/** Nine numbers of a light. */
function lightOf(light, i) {
  const o = options(`light ${i}`, light, ['kind', 'position', 'direction', 'halfAngleRadians', 'range']);
  const kind = word(`the kind of light ${i}`, o.kind, KINDS);
  const position = kind === 0 ? [0, 0, 0] : numbers(`the position of light ${i}`, o.position, 3);
  const direction = kind === 1 ? [0, 0, 0] : numbers(`the direction of light ${i}`, o.direction, 3);
  return [kind, ...position, ...direction, o.halfAngleRadians ?? Infinity, o.range ?? Infinity];
}

export class QueryView extends View {
  #engine;
  #scene;

  constructor(key, engine, scene, given) {
    super(key, engine, scene, given);
    [this.#engine, this.#scene] = [engine, scene];
  }

  cullAmong(ids) {
    const view = this.number;
    const list = typed('ids', ids, Uint32Array);
    const at = this.#engine.scratch(list.length * 4);
    new Uint32Array(this.#engine.buffer, at, list.length).set(list);
    this.#engine.check('view_cull_among', view, this.#scene.number, list.length);
    return this.#engine.answer(Uint32Array);
  }

  lights(lights, given) {
    const view = this.number;
    const o = options('the options of lights', given, ['anywhere', 'casters']);
    if (!Array.isArray(lights)) throw new CulletError('argument', 'lights must be an array');
    const engine = this.#engine;
    write(engine, ...lights.map(lightOf));
    engine.check('view_lights', view, this.#scene.number, lights.length, (o.anywhere ? 0 : ON_VISIBLE) | (o.casters ? CASTERS : 0));
    const kept = engine.answer(Uint32Array);
    const of = (which, Type) => {
      engine.call('view_lights_of', view, which);
      return engine.answer(Type);
    };
    const [reasons, receivers, rows] = [of(0, Uint8Array), of(1, Float64Array), of(2, Float64Array)];
    const funnel = [];
    for (let i = 0; i < rows.length; i += 3) funnel.push({ reason: LIGHT_REASONS[rows[i]], entered: rows[i + 1], left: rows[i + 2] });
    return { kept, reasons, receivers, funnel };
  }

  casters(at) {
    const view = this.number;
    this.#engine.check('view_casters', view, this.#scene.number, whole('the place of a kept light', at, 0, U32));
    return this.#engine.answer(Uint32Array);
  }
}
