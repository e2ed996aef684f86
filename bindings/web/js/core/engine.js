// One WebAssembly module of a page or worker: how it is loaded, and what its memory holds.

import { inDigits } from './digits.js';
import { CODES, CulletError } from './error.js';

// The smallest module with a vector instruction: a function that makes a vector and drops it.
const SIMD = new Uint8Array([0, 97, 115, 109, 1, 0, 0, 0, 1, 4, 1, 96, 0, 0, 3, 2, 1, 0, 10, 9, 1, 7, 0, 65, 0, 253, 15, 26, 11]);
const text = new TextDecoder();

export class Engine {
  #address;
  #ready;
  #exports;
  #dead;
  #buffer;
  #bytes;

  /** `address` is a function, so that none is made where a page gives the module itself. */
  constructor(address) { this.#address = address; }

  /** Loads the module, once. */
  init(source) {
    this.#ready ??= load(source ?? this.#address()).then(
      (instance) => { this.#exports = instance.exports; },
      (error) => {
        // So that the next call tries again.
        this.#ready = undefined;
        throw error;
      },
    );
    return this.#ready;
  }

  /** The exports. */
  get wasm() {
    if (this.#dead) throw new CulletError('dead', 'the engine ended by an earlier error, so that its answers could be wrong: load the page or worker anew', { cause: this.#dead });
    if (!this.#exports) throw new CulletError('not-ready', 'the engine is not loaded: `await init()` first');
    return this.#exports;
  }

  /** The memory as it is now: growing makes another buffer and empties all views of the one before. */
  get buffer() { return this.#exports.memory.buffer; }

  get bytes() {
    const { buffer } = this;
    if (this.#buffer !== buffer) {
      this.#buffer = buffer;
      this.#bytes = new Uint8Array(buffer);
    }
    return this.#bytes;
  }

  /** Calls an export by name. What ends the module ends it for good. */
  call(name, ...args) {
    const { wasm } = this;
    try {
      return wasm[name](...args);
    } catch (error) {
      this.#dead = error;
      throw new CulletError('dead', `the engine ended in ${name}: please report it with what led there`, { cause: error });
    }
  }

  /** Calls an export that answers with a code, and throws what is wrong. */
  check(name, ...args) {
    const code = this.call(name, ...args);
    if (code === 0) return;
    this.call('message');
    throw new CulletError(CODES[code] ?? 'argument', this.answerText());
  }

  /** The last answer as a view of the memory. */
  answer(Array, each = 1) {
    const { wasm } = this;
    return new Array(wasm.memory.buffer, wasm.answer_at(), wasm.answer_len() * each);
  }

  answerText() { return inDigits(text.decode(this.answer(Uint8Array).slice())); }

  /** Where arguments of so many bytes are written. */
  scratch(bytes) {
    const at = bytes < 2 ** 32 ? this.call('scratch', bytes) : 0;
    if (at === 0 && bytes > 0) throw new CulletError('memory', `no memory for ${bytes} bytes of arguments`);
    return at;
  }
}

async function load(source) {
  if (typeof WebAssembly !== 'object') throw new CulletError('no-wasm', 'this browser has no WebAssembly, or the page forbids it (Content-Security-Policy: script-src needs \'wasm-unsafe-eval\')');
  if (!WebAssembly.validate(SIMD)) throw new CulletError('no-simd', 'this browser has no WebAssembly SIMD, which Chrome and Edge have from version 91 on, Firefox from 89 and Safari from 16.4 (2023): draw without culling here');
  const bytes = await fetched(source);
  try {
    const made = await WebAssembly.instantiate(bytes, {});
    const instance = made.instance ?? made;
    if (!instance.exports.answer_at) throw new CulletError('load', 'the module is not one of this package');
    return instance;
  } catch (error) {
    if (error instanceof CulletError) throw error;
    throw new CulletError('load', `the module does not load: ${error.message}`, { cause: error });
  }
}

/** The module, or its bytes. */
async function fetched(source) {
  source = await source;
  if (source instanceof WebAssembly.Module || source instanceof ArrayBuffer || ArrayBuffer.isView(source)) return source;
  if (typeof source === 'string') source = new URL(source, globalThis.location?.href ?? import.meta.url);
  if (source instanceof URL && source.protocol === 'file:') {
    // Node's fetch reads no files. The name is hidden from bundlers, which would look for the module or complain.
    const name = 'node:fs/promises';
    const { readFile } = await import(/* @vite-ignore */ /* webpackIgnore: true */ name);
    return readFile(source).catch((error) => { throw new CulletError('load', `${source}: ${error.message}`, { cause: error }); });
  }
  if (!(source instanceof URL) && !(typeof Response === 'function' && source instanceof Response)) {
    throw new CulletError('argument', `init takes a URL, a Response, bytes or a WebAssembly.Module, and was given ${Object.prototype.toString.call(source)}`);
  }
  let response;
  try {
    response = source instanceof URL ? await fetch(source) : source;
  } catch (error) {
    throw new CulletError('load', `${source}: ${error.message}`, { cause: error });
  }
  if (!response.ok) throw new CulletError('load', `${response.url} answered ${response.status}: is the .wasm file where the bundle is?`);
  const type = response.headers.get('content-type') ?? '';
  // A server that answers any address with a page gives that in place of the module.
  if (type.startsWith('text/html')) throw new CulletError('load', `${response.url} is a page and not a module: is the .wasm file where the bundle is?`);
  return response.arrayBuffer();
}
