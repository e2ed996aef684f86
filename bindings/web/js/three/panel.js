// A small panel over the page: counts of the camera's pass, what occlusion saved, a map from above, and why something is missing. It is
// loaded when a page asks for it.

import { explain, explainInstance } from './explain.js';
import { legend, Map2D } from './map.js';

const EACH = 250;
const STYLE = {
  position: 'fixed', right: '12px', top: '12px', zIndex: '10000', width: '240px', padding: '10px 12px', boxSizing: 'content-box', borderRadius: '8px',
  background: 'rgba(16, 24, 31, 0.92)', color: '#e8eef2', font: '12px/1.45 system-ui, sans-serif', fontVariantNumeric: 'tabular-nums',
};
const BUTTON = { margin: '0 6px 6px 0', padding: '3px 8px', font: 'inherit', color: 'inherit', background: '#2c3a45', border: '1px solid #6b7d8a', borderRadius: '4px', cursor: 'pointer' };
const whole = (n) => n.toLocaleString('en');

function make(tag, style = {}, attributes = {}, text = '') {
  const element = document.createElement(tag);
  Object.assign(element.style, style);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.textContent = text;
  return element;
}

export class Panel {
  /** The panel's element. */
  element = make('section', STYLE, { 'aria-label': 'cullet', 'aria-live': 'off' });
  /** Whether the next pass of a camera is shown: read by `Decisions`. */
  isDue = true;
  #culling;
  #decisions;
  #nodes;
  #closed;
  #values = {};
  #map = new Map2D();
  #mark = null;
  #camera;
  #freeze;
  #hasFrozen = false;
  #said;
  #time = 0;
  #passes = 0;
  #timer;
  #shown = null;

  constructor(culling, { decisions, nodes, closed }, { parent = document.body, camera = null } = {}) {
    [this.#culling, this.#decisions, this.#nodes, this.#closed, this.#camera] = [culling, decisions, nodes, closed, camera];
    const buttons = make('div');
    const button = (text, does, attributes = {}) => {
      const made = make('button', BUTTON, { type: 'button', ...attributes }, text);
      made.addEventListener('click', does);
      buttons.append(made);
      return made;
    };
    this.#freeze = button('Freeze', () => { this.#hasFrozen = culling.frozen = !culling.frozen; this.#pressed(); }, { 'aria-pressed': String(culling.frozen), title: 'Keep what is drawn now while the camera goes on' });
    button('+', () => this.#zoom(0.7), { 'aria-label': 'Map: nearer' });
    button('−', () => this.#zoom(1 / 0.7), { 'aria-label': 'Map: farther' });
    button('Close', () => this.dispose());
    const list = make('dl', { display: 'grid', gridTemplateColumns: 'auto 1fr', gap: '0 10px', margin: '0 0 6px' });
    for (const [name, label] of ROWS) {
      const value = make('dd', { margin: '0', textAlign: 'right' }, { 'data-name': name }, '…');
      list.append(make('dt', {}, {}, label), value);
      this.#values[name] = value;
    }
    const colours = make('div', { display: 'flex', justifyContent: 'space-between' });
    for (const [name, colour] of legend) {
      const entry = make('span', {}, {}, ` ${name}`);
      entry.prepend(make('span', { display: 'inline-block', width: '9px', height: '9px', background: colour }));
      colours.append(entry);
    }
    this.#said = make('output', { display: 'block', minHeight: '3em', overflowWrap: 'anywhere' }, { 'aria-live': 'off', 'data-name': 'said' }, 'Click the map to ask why something is missing.');
    // Styles of the page stay outside.
    this.element.attachShadow({ mode: 'open' }).append(buttons, list, this.#canvas(), colours, this.#said);
    parent.append(this.element);
    decisions.watcher = this;
    this.#timer = setInterval(() => { this.isDue = true; }, EACH);
  }

  /** How far the map reaches from the camera, in the scene's units. */
  get reach() { return this.#map.reach; }

  /** Shows the next pass of a camera, without waiting for its turn. */
  refresh() { this.isDue = true; }

  /** Says why an object is missing, in the panel and as an answer. */
  explain(object) {
    const answer = this.#culling.explain(object);
    this.#said.textContent = answer.text;
    return answer;
  }

  /** Removes the panel, and ends what its button froze. */
  dispose() {
    if (this.#timer === null) return;
    clearInterval(this.#timer);
    this.#timer = null;
    if (this.#decisions.watcher === this) this.#decisions.watcher = null;
    if (this.#hasFrozen) this.#culling.frozen = false;
    this.element.remove();
    this.#closed();
  }

  /** A pass of a camera, from `Decisions`. */
  passed(decision, stats) {
    if (this.#camera && decision.camera !== this.#camera) return;
    this.#time += stats.milliseconds;
    this.#passes += 1;
    if (!this.isDue) return;
    this.isDue = false;
    this.#shown = decision;
    const copy = { ...stats, occludes: decision.occludes, mean: this.#time / this.#passes };
    [this.#time, this.#passes] = [0, 0];
    // After the render, which must not be slower for it.
    queueMicrotask(() => { if (this.#timer !== null) this.#show(decision, copy); });
  }

  #show(decision, stats) {
    for (const [name, , text] of ROWS) {
      const now = text(stats);
      if (this.#values[name].textContent !== now) this.#values[name].textContent = now;
    }
    this.#pressed();
    this.#map.draw(this.#nodes(), decision, this.#mark);
  }

  #pressed() { this.#freeze.setAttribute('aria-pressed', String(this.#culling.frozen)); this.#freeze.style.background = this.#culling.frozen ? '#8a5a12' : BUTTON.background; }

  #zoom(by) {
    this.#map.zoom(by);
    this.#redraw();
  }

  #redraw() { if (this.#shown && this.#shown === this.#decisions.last) this.#map.draw(this.#nodes(), this.#shown, this.#mark); }

  #canvas() {
    const { canvas } = this.#map;
    Object.assign(canvas.style, { display: 'block', cursor: 'crosshair' });
    const label = 'Map from above. Arrow keys move the mark, Enter says why what is there is missing.';
    for (const [name, value] of Object.entries({ tabindex: '0', role: 'application', 'aria-label': label })) canvas.setAttribute(name, value);
    canvas.addEventListener('click', ({ offsetX, offsetY }) => { this.#mark = [offsetX, offsetY]; this.#ask(); });
    canvas.addEventListener('keydown', (event) => {
      const step = { ArrowLeft: [-4, 0], ArrowRight: [4, 0], ArrowUp: [0, -4], ArrowDown: [0, 4] }[event.key];
      if (step) {
        const last = canvas.width - 1;
        this.#mark = (this.#mark ?? [canvas.width / 2, canvas.height / 2]).map((v, k) => Math.max(0, Math.min(last, v + step[k])));
        this.#redraw();
      } else if (event.key === 'Enter' || event.key === ' ') this.#ask();
      else return;
      // Neither the page nor the controls of its camera are to move.
      event.preventDefault();
      event.stopPropagation();
    });
    return canvas;
  }

  #ask() {
    const nodes = this.#nodes();
    const found = this.#mark && this.#map.at(...this.#mark);
    const object = found ? nodes.objects[found.number] : null;
    if (!object) this.#said.textContent = 'Nothing is there.';
    else if (found.instance >= 0) this.#said.textContent = explainInstance(object, found.instance, nodes, this.#shown);
    else this.#said.textContent = explain(object, this.#culling.root, nodes, this.#shown).text;
    this.#redraw();
  }
}

// Name, label, and the text of the counts of a pass.
const ROWS = [
  ['drawn', 'Meshes drawn', (s) => `${whole(s.visible)} of ${whole(s.objects)}`],
  ['hidden', 'hidden', (s) => whole(s.hidden)],
  ['clipped', 'clipped', (s) => whole(s.clipped)],
  ['instances', 'Instances drawn', (s) => `${whole(s.visibleInstances)} of ${whole(s.instances)}`],
  ['hiddenInstances', 'hidden', (s) => whole(s.hiddenInstances)],
  ['time', 'Culling', (s) => `${s.mean.toFixed(2)} ms`],
  ['cost', 'A draw counts', (s) => `${s.drawMicroseconds} µs, ${s.drawMicrosecondsFrom}`],
  ['occlusion', 'Occlusion saves', (s) => (s.noOcclusion === null ? saved(s) : `nothing: ${s.noOcclusion}`)],
  ['maps', 'Shadow maps kept', (s) => (s.allCast === null ? whole(s.keptMaps) : `0: ${s.allCast}`)],
];

function saved({ occludes, hidden, hiddenInstances, drawMicroseconds }) {
  if (!occludes) return 'not for this camera';
  if (hidden + hiddenInstances === 0) return 'nothing';
  return hidden > 0 ? `${whole(hidden)} draws, ${(hidden * drawMicroseconds / 1000).toFixed(2)} ms` : `${whole(hiddenInstances)} instances`;
}
