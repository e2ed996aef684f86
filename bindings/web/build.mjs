// Builds the package into a folder: `node build.mjs OUT`. The six WebAssembly modules are compiled with cargo
// into the target folder, what is written by hand is copied, and the sizes are printed. Where CULLET_WASM_OPT names binaryen's
// `wasm-opt`, that makes the modules a twentieth smaller.
import { spawn } from 'node:child_process';
import { createHash } from 'node:crypto';
import { cpSync, existsSync, mkdirSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { availableParallelism } from 'node:os';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { brotliCompressSync, gzipSync } from 'node:zlib';

const here = fileURLToPath(new URL('.', import.meta.url));
const root = fileURLToPath(new URL('../../', import.meta.url));
const [out, ...only] = process.argv.slice(2);
if (!out) {
  console.error('node build.mjs OUT [frustum] [boxes] [three] [scene] [queries] [files]: builds the npm package into OUT');
  process.exit(2);
}
const target = join(process.env.CARGO_TARGET_DIR ?? join(root, 'target'), 'wasm-npm');
// The compiler has one thread for most of a module, which is optimised as a whole; so two are built at once.
const LANES = Math.min(2, availableParallelism());

// What is not the engine is small; the engine is quick where occlusion is drawn, which at "s" takes four times as long. Boxes
// against planes take a third longer at "s", for a quarter less to load.
const profile = { OPT_LEVEL: 's', LTO: 'fat', CODEGEN_UNITS: '1', PANIC: 'abort', STRIP: 'true' };
const levels = { frustum: '"s"', boxes: '3', three: '3', scene: '3', queries: '3', files: '3' };
const modules = { frustum: [], boxes: ['occluders'], three: ['scene'], scene: ['clusters'], queries: ['queries'], files: ['files'] };
const files = { frustum: 'cullet-frustum.wasm', boxes: 'cullet-boxes.wasm', three: 'cullet-three.wasm', scene: 'cullet.wasm', queries: 'cullet-queries.wasm', files: 'cullet-files.wasm' };

function run(program, words, env = process.env) {
  const running = spawn(program, words, { cwd: root, env, stdio: ['ignore', 'inherit', 'inherit'] });
  return new Promise((resolve, reject) => {
    const fail = (why) => reject(new Error(`${program} ${words.join(' ')}: ${why}`));
    running.on('error', fail);
    running.on('close', (status) => (status === 0 ? resolve() : fail(`ended with ${status}`)));
  });
}

async function compile(name, lane) {
  const features = modules[name];
  const args = (process.env.CULLET_CARGO_ARGS ?? '').split(' ').filter(Boolean);
  const words = ['rustc', ...args, '--lib', '--crate-type', 'cdylib', '--package', 'cullet-web', '--profile', 'web', '--target', 'wasm32-unknown-unknown',
    '--no-default-features', '--features', features.join(','), '--config', `profile.web.package.cullet.opt-level=${levels[name]}`];
  const folder = join(target, String(lane));
  const env = { ...process.env, CARGO_TARGET_DIR: folder,
    CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_RUSTFLAGS: '-Ctarget-feature=+simd128' };
  for (const [key, value] of Object.entries(profile)) env[`CARGO_PROFILE_WEB_${key}`] = value;
  await run(process.env.CULLET_CARGO ?? 'cargo', words, env);
  return readFileSync(join(folder, 'wasm32-unknown-unknown/web/cullet_web.wasm'));
}

// What the compiler's target has. Nothing is assumed of traps: they end what Rust panics of. Engines read no alignment, and
// without it the same instructions are the same bytes.
const has = ['simd', 'bulk-memory', 'sign-ext', 'nontrapping-float-to-int', 'mutable-globals', 'reference-types', 'multivalue'];
async function shrink(bytes, name) {
  const program = process.env.CULLET_WASM_OPT;
  if (!program) return bytes;
  // It takes up to two minutes: what the same module became before is kept, by the bytes of the module.
  const options = ['-Oz', '--dealign', ...has.map((feature) => `--enable-${feature}`)];
  const key = createHash('sha256').update([program, ...options].join(' ')).update(bytes).digest('hex');
  const [whole, smaller, keyOf] = ['.whole', '', '.key'].map((end) => join(target, files[name] + end));
  if (!existsSync(keyOf) || readFileSync(keyOf, 'utf8') !== key) {
    writeFileSync(whole, bytes);
    await run(program, [whole, '-o', smaller, ...options]);
    writeFileSync(keyOf, key);
  }
  return readFileSync(smaller);
}

rmSync(out, { recursive: true, force: true });
mkdirSync(join(out, 'js'), { recursive: true });
for (const file of ['package.json', 'README.md', 'CHANGELOG.md']) cpSync(join(here, file), join(out, file));
for (const file of ['LICENSE-MIT', 'LICENSE-APACHE']) cpSync(join(root, file), join(out, file));
cpSync(join(here, 'js'), join(out, 'js'), { recursive: true });
// Each in the same lane every time, which has it from the time before; the largest first.
const names = (only.length ? only : Object.keys(modules)).toReversed();
await Promise.all(Array.from({ length: LANES }, async (_, lane) => {
  for (const name of names.filter((name) => Object.keys(modules).indexOf(name) % LANES === lane)) {
    const bytes = await shrink(await compile(name, lane), name);
    writeFileSync(join(out, 'js', files[name]), bytes);
    console.log(`${files[name].padEnd(20)} ${String(bytes.length).padStart(8)} bytes, ${gzipSync(bytes, { level: 9 }).length} by gzip, ${brotliCompressSync(bytes).length} by brotli`);
  }
}));
