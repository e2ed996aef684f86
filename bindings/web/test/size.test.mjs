// What a page loads: a change that makes it larger by a twentieth is to be meant.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { fileURLToPath } from 'node:url';
import { brotliCompressSync } from 'node:zlib';
import { folder } from './package.mjs';

// Kilobytes by brotli, of a module and of the scripts that its entry loads: as measured, and a twentieth more.
const limits = {
  'cullet-frustum.wasm': 20.2,
  'cullet-boxes.wasm': 74.4,
  'cullet-three.wasm': 123,
  'cullet.wasm': 156,
  'cullet-queries.wasm': 217,
  'cullet-files.wasm': 542,
};
const kilobytes = (name) => brotliCompressSync(readFileSync(join(folder, 'js', name))).length / 1000;

for (const [name, limit] of Object.entries(limits)) {
  test(`${name} takes ${limit} kB at the most`, () => {
    const size = kilobytes(name);
    assert.ok(size <= limit, `${name} takes ${size.toFixed(1)} kB by brotli, above ${limit}: find out what came in, or raise the limit and the table in the book`);
    // A limit that is far off holds nothing.
    assert.ok(size >= limit * 0.85, `${name} takes ${size.toFixed(1)} kB by brotli, far below ${limit}: lower the limit`);
  });
}

test('the book gives the sizes', () => {
  const book = readFileSync(fileURLToPath(new URL('../../../docs/src/web.md', import.meta.url)), 'utf8');
  const rows = [['cullet/frustum', 'cullet-frustum.wasm'], ['cullet/boxes', 'cullet-boxes.wasm'], ['cullet/three', 'cullet-three.wasm'], ['cullet', 'cullet.wasm'], ['cullet/queries', 'cullet-queries.wasm'], ['cullet/files', 'cullet-files.wasm']];
  for (const [entry, name] of rows) {
    const told = Number(book.match(new RegExp(`^\\| \`${entry}\` \\|.*\\| (\\d+) kB \\|$`, 'm'))?.[1]);
    const size = kilobytes(name);
    assert.ok(Math.abs(told - size) <= 1 + size * 0.03, `the book gives ${told} kB for ${entry}, which takes ${size.toFixed(1)}`);
  }
});
