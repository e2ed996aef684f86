// The package as npm and others take it: types, contents, bundles.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { cpSync, mkdirSync, mkdtempSync, readdirSync, readFileSync, rmSync, symlinkSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { dirname, join } from 'node:path';
import { test } from 'node:test';
import { fileURLToPath, pathToFileURL } from 'node:url';
import { folder, tool, tools } from './package.mjs';

const here = fileURLToPath(new URL('.', import.meta.url));
const project = mkdtempSync(join(tmpdir(), 'cullet-'));
process.on('exit', () => rmSync(project, { recursive: true, force: true }));
mkdirSync(join(project, 'node_modules/@types'), { recursive: true });
cpSync(folder, join(project, 'node_modules/cullet'), { recursive: true });
for (const name of ['three', '@types/three']) symlinkSync(join(tools(), 'node_modules', name), join(project, 'node_modules', name));
for (const file of ['use.ts', 'using.ts', 'worker.mjs']) cpSync(join(here, file), join(project, file));
writeFileSync(join(project, 'package.json'), '{ "type": "module", "private": true }');
const run = (program, ...words) => {
  try {
    return execFileSync(join(tools(), 'node_modules/.bin', program), words, { cwd: project, encoding: 'utf8', stdio: 'pipe' });
  } catch (error) {
    throw new Error(`${program} ${words.join(' ')}:\n${error.stdout}${error.stderr}`);
  }
};

for (const how of [['--module', 'nodenext'], ['--module', 'esnext', '--moduleResolution', 'bundler']]) {
  test(`tsc --strict takes the declarations and a use of them, ${how.join(' ')}`, () => {
    const tsc = (lib, file) => run('tsc', '--noEmit', '--strict', '--noUncheckedIndexedAccess', '--target', 'es2022', '--lib', `es2022,dom,dom.iterable${lib}`, ...how, '--types', '', file);
    tsc('', 'use.ts');
    tsc(',esnext.disposable', 'use.ts');
    tsc(',esnext.disposable', 'using.ts');
  });
}

test('publint and attw find nothing', () => {
  run('publint', '--strict', folder);
  const entries = ['.', './frustum', './boxes', './queries', './files', './three', './tiles'].filter((name) => !['./three', './tiles'].includes(name) || readdirSync(join(folder, 'js')).includes(name.slice(2)));
  const packed = execFileSync('npm', ['pack', '--json', '--pack-destination', project, folder], { encoding: 'utf8', stdio: ['ignore', 'pipe', 'ignore'] });
  run('attw', join(project, JSON.parse(packed)[0].filename), '--profile', 'esm-only', '--entrypoints', ...entries);
});

test('npm pack holds what is used, and nothing else', () => {
  const [{ files, version }] = JSON.parse(execFileSync('npm', ['pack', '--dry-run', '--json', folder], { encoding: 'utf8', stdio: ['ignore', 'pipe', 'ignore'] }));
  const names = files.map((file) => file.path).filter((path) => !path.startsWith('js/three/') && !path.startsWith('js/tiles/')).sort();
  const core = ['boxes', 'check', 'digits', 'engine', 'error', 'occluders', 'queries', 'scene', 'view'].map((name) => `js/core/${name}.js`);
  const types = ['js/core/boxes.d.ts', 'js/core/queries.d.ts', 'js/core/scene.d.ts', ...['boxes', 'files', 'frustum', 'index', 'queries'].map((name) => `js/${name}.d.ts`)];
  const wasm = ['js/cullet.wasm', ...['boxes', 'files', 'frustum', 'queries', 'three'].map((name) => `js/cullet-${name}.wasm`)];
  const about = ['CHANGELOG.md', 'LICENSE-APACHE', 'LICENSE-MIT', 'README.md', 'package.json'];
  assert.deepEqual(names, [...about, ...core, ...types, ...wasm, ...['boxes', 'files', 'frustum', 'index', 'queries'].map((name) => `js/${name}.js`), 'js/bin/cullet.js', 'js/bin/info.js'].sort());
  const manifest = readFileSync(join(here, '../../../Cargo.toml'), 'utf8');
  assert.ok(manifest.includes(`version = "${version}"`), `${version} is that of the crates`);
  assert.ok(readFileSync(join(folder, 'CHANGELOG.md'), 'utf8').includes(`[${version}]`), 'the changelog has this version');
});

// What is bundled is run in Node, where its module lies beside it.
const lists = '0,1,2,3,4,5,6,7,8,9,10';
const program = `
import { BoxSet, init } from 'cullet/frustum';
export async function list(source) {
  await init(source);
  const set = new BoxSet(100);
  for (let i = 0; i < 100; i++) set.boxes.set([i, 0, 0, i + 0.5, 1, 1], 6 * i);
  set.commit();
  return [...set.cull([1, 0, 0, 10, -1, 0, 0, 10, 0, 1, 0, 10, 0, -1, 0, 10, 0, 0, 1, 10, 0, 0, -1, 10])];
}
`;

test('esbuild bundles it, with the module copied beside', async () => {
  writeFileSync(join(project, 'main.js'), program);
  run('esbuild', 'main.js', '--bundle', '--format=esm', '--outfile=out/main.js', '--log-level=warning');
  cpSync(join(folder, 'js/cullet-frustum.wasm'), join(project, 'out/cullet-frustum.wasm'));
  const { list } = await import(pathToFileURL(join(project, 'out/main.js')));
  assert.equal(String(await list()), lists);
});

test('Vite bundles it without settings, module and worker too', async () => {
  writeFileSync(join(project, 'page.js'), `${program}\nwindow.list = list; window.work = () => new Worker(new URL('./worker.mjs', import.meta.url), { type: 'module' });\n`);
  writeFileSync(join(project, 'index.html'), '<!doctype html><script type="module" src="./page.js"></script>');
  const { build } = await import(pathToFileURL(join(dirname(tool('vite/package.json')), 'dist/node/index.js')));
  await build({ root: project, logLevel: 'error', base: './', build: { outDir: 'vite', target: 'es2022' }, worker: { format: 'es' } });
  const made = readdirSync(join(project, 'vite/assets'));
  assert.ok(made.some((name) => /^cullet-frustum-.*\.wasm$/.test(name)), String(made));
  assert.ok(made.some((name) => /^worker-.*\.js$/.test(name)), String(made));
  const { inPage } = await import('./page.mjs');
  const seen = await inPage(join(project, 'vite'), async (page) => [
    await page.evaluate(() => window.list().then(String)),
    await page.evaluate(() => new Promise((ok, bad) => { const w = window.work(); w.onmessage = (e) => ok(String(e.data)); w.onerror = (e) => bad(new Error(e.message)); })),
  ]);
  assert.deepEqual(seen, [lists, lists]);
});
