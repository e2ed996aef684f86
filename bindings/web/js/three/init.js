// The engine, or that a browser cannot run it: then nothing is culled, and three.js draws as without this package.

import { load } from './engine.js';

let isMissing = false;

/** Whether `init` found that this browser cannot run the engine. */
export const isInert = () => isMissing;

export async function init(source) {
  try {
    await load(source);
    isMissing = false;
  } catch (error) {
    if (error.code !== 'no-simd' && error.code !== 'no-wasm') throw error;
    if (!isMissing) console.warn(`${error.message}; three.js goes on drawing by itself`);
    isMissing = true;
  }
  return !isMissing;
}
