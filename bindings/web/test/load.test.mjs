// How the engine is loaded: by Node, in a worker, and where something is missing.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { cpSync, mkdirSync, mkdtempSync, readFileSync, rmSync, symlinkSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';
import { fileURLToPath, pathToFileURL } from 'node:url';
import { Worker } from 'node:worker_threads';
import { entry, folder } from './package.mjs';

const here = fileURLToPath(new URL('.', import.meta.url));
// A project that has the package among its own.
const project = mkdtempSync(join(tmpdir(), 'cullet-'));
mkdirSync(join(project, 'node_modules'));
symlinkSync(folder, join(project, 'node_modules/cullet'));
for (const file of ['first.mjs', 'worker.mjs']) cpSync(join(here, file), join(project, file));
process.on('exit', () => rmSync(project, { recursive: true, force: true }));
const run = (...words) => spawnSync(process.execPath, words, { cwd: project, encoding: 'utf8' });

test('the first use is ten lines, and culls', () => {
  const { stdout, stderr, status } = run('first.mjs');
  assert.equal(status, 0, stderr);
  assert.match(stdout, /^4 of 1000 are drawn: 0,1,2,3\n$/);
  const program = readFileSync(join(here, 'first.mjs'), 'utf8');
  const lines = program.split('\n').filter((line) => line && !line.startsWith('//') && !line.startsWith('console'));
  assert.ok(lines.length <= 10, `${lines.length} lines`);
  const text = (name) => readFileSync(join(here, name), 'utf8');
  const shown = program.split('console')[0].trim();
  assert.ok(text('../README.md').includes(shown), 'the README shows it');
  assert.ok(text('../../../docs/src/web.md').includes(shown), 'the book shows it');
});

test('a worker has an engine of its own, and one that dies takes nothing along', async () => {
  const { BoxSet, init } = await entry('frustum');
  await init();
  const set = new BoxSet(10);
  const worker = new Worker(join(project, 'worker.mjs'));
  const answer = await new Promise((ok, bad) => worker.once('message', ok).once('error', bad));
  assert.deepEqual(answer, [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10]);
  await worker.terminate();
  set.commit();
  assert.equal(set.cull(new Array(24).fill(NaN)).length, 10);
  set.dispose();
});

const fails = async (source, code, message) => {
  const { init, BoxSet } = await import(`${pathToFileURL(join(folder, 'js/frustum.js'))}?${Math.random()}`);
  await assert.rejects(() => init(source), (e) => e.name === 'CulletError' && e.code === code && message.test(e.message));
  assert.throws(() => new BoxSet(1), (e) => e.code === 'not-ready');
  // A later call tries again.
  await init();
  new BoxSet(1).dispose();
};

test('what cannot be loaded is an error that says what to look at', async () => {
  const { CulletError } = await entry('frustum');
  assert.equal(typeof CulletError, 'function');
  await fails(new Uint8Array(10), 'load', /does not load/);
  await fails(new Uint8Array([0, 97, 115, 109, 1, 0, 0, 0]), 'load', /not one of this package/);
  await fails(new URL('file:///nowhere/cullet.wasm'), 'load', /nowhere/);
  await fails(new Response('', { status: 404 }), 'load', /404/);
  await fails(new Response('<html>', { headers: { 'content-type': 'text/html' } }), 'load', /page and not a module/);
  await fails(5, 'argument', /Number/);
});

test('a browser without SIMD, or without WebAssembly, is told so', async () => {
  const { validate } = WebAssembly;
  assert.ok(validate(readFileSync(join(folder, 'js/cullet-frustum.wasm'))));
  let asked;
  WebAssembly.validate = (bytes) => { asked = bytes; return false; };
  const fresh = await import(`${pathToFileURL(join(folder, 'js/frustum.js'))}?simd`);
  try {
    await assert.rejects(() => fresh.init(), (e) => e.code === 'no-simd' && /Chrome and Edge .* 91 .*Firefox .* 89 .*Safari .* 16\.4/.test(e.message));
  } finally {
    WebAssembly.validate = validate;
  }
  // What was asked is a module with a vector instruction, and one without it is taken by any browser.
  assert.ok(validate(asked) && asked.includes(253));
  await fresh.init();
});

test('a compiled module may be given, such as one that was sent to a worker', async () => {
  const fresh = await import(`${pathToFileURL(join(folder, 'js/frustum.js'))}?module`);
  await fresh.init(new WebAssembly.Module(readFileSync(join(folder, 'js/cullet-frustum.wasm'))));
  assert.equal(new fresh.BoxSet(2).length, 2);
});

test('an engine that ended says so from then on', async () => {
  const engine = await import(`${pathToFileURL(join(folder, 'js/core/engine.js'))}`);
  const one = new engine.Engine(() => readFileSync(join(folder, 'js/cullet-frustum.wasm')));
  await one.init();
  // A table of the module's own cannot be reached from outside, so an export that is not there stands for a trap.
  assert.throws(() => one.call('nothing'), (e) => e.code === 'dead');
  assert.throws(() => one.wasm, (e) => e.code === 'dead' && /anew/.test(e.message));
});
