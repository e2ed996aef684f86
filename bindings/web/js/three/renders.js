// The renders of a scene that are under way, told by its `onBeforeRender` and `onAfterRender`: both renderers call them, before they
// list objects and after all is drawn. WebGPURenderer renders the scene for each shadow map too, inside the render that needs it.

import { owner } from './bounds.js';

const heard = new WeakMap();

// What the page sets as the callback is called as ever: `first` or last.
function hook(scene, name, isFirst, ours) {
  let own = Object.hasOwn(scene, name) ? scene[name] : undefined;
  const base = owner(scene, name)[name];
  const call = function call(...values) {
    if (!isFirst) ours(...values);
    (own ?? base).apply(this, values);
    if (isFirst) ours(...values);
  };
  Object.defineProperty(scene, name, { configurable: true, enumerable: true, get: () => call, set: (to) => { if (to !== call) own = to; } });
  return () => { delete scene[name]; if (own) scene[name] = own; };
}

function end(renders) {
  for (const done of renders.pop()?.done ?? []) done();
}

function listen(scene) {
  let ear = heard.get(scene);
  if (ear) { ear.count += 1; return; }
  const renders = [];
  ear = { count: 1, renderer: null, renders };
  const restore = [
    hook(scene, 'onBeforeRender', true, (renderer, _, camera) => {
      ear.renderer = renderer;
      // A render that throws never says that it ended; no render outlives its task.
      if (renders.length === 0) queueMicrotask(() => { while (renders.length > 0) end(renders); });
      renders.push({ renderer, camera, outer: renders.at(-1) ?? null, isShadow: scene.overrideMaterial?.isShadowPassMaterial === true, seen: new Map(), done: [], began: performance.now() });
    }),
    hook(scene, 'onAfterRender', false, () => end(renders)),
  ];
  ear.restore = () => { for (const undo of restore) undo(); };
  heard.set(scene, ear);
}

function ignore(scene) {
  const ear = heard.get(scene);
  if (!ear || --ear.count > 0) return;
  ear.restore();
  heard.delete(scene);
}

/** The renders of the scene that a root is in. */
export class Renders {
  #root;
  #scene = null;

  constructor(root) {
    this.#root = root;
    this.listen();
  }

  /** The scene that the root is in, which is listened to from now on; `null` if there is none. */
  listen() {
    let top = this.#root;
    while (top.parent) top = top.parent;
    const scene = top.isScene ? top : null;
    if (scene === this.#scene) return scene;
    if (this.#scene) ignore(this.#scene);
    if (scene) listen(scene);
    this.#scene = scene;
    return scene;
  }

  /** The renderer of the last `render()` of the scene. */
  get renderer() { return heard.get(this.#scene)?.renderer ?? null; }

  /**
   * The innermost render under way: renderer, camera, whether it is of a shadow map, the render around it, what each culling has `seen` in
   * it, what is to be `done` at its end, and when it `began`.
   */
  get current() { return heard.get(this.#scene)?.renders.at(-1) ?? null; }

  dispose() {
    if (this.#scene) ignore(this.#scene);
    this.#scene = null;
  }
}
