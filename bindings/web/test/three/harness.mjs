// Serves the package and three.js on the loopback interface, and starts Chromium.
// The variables of ../package.mjs name the package and the browser.

import { createServer } from 'node:http';
import { readFile } from 'node:fs/promises';
import { createRequire } from 'node:module';
import { extname, join, normalize } from 'node:path';
import { fileURLToPath } from 'node:url';
import { chromium, folder, tool, tools } from '../package.mjs';

export const root = fileURLToPath(new URL('../..', import.meta.url));
/** The built package: its modules of WebAssembly lie beside its scripts. */
export const packageFolder = folder;
export const modules = join(tools(), 'node_modules');

const types = { '.html': 'text/html', '.js': 'text/javascript', '.mjs': 'text/javascript', '.wasm': 'application/wasm', '.json': 'application/json', '.css': 'text/css' };

// Folders by the beginning of an address; the rest is the package's own.
const mounts = [['/node_modules/', modules], ['/js/', join(packageFolder, 'js')], ['/', root]];

/** `edits`: by the end of an address, what is done to the text that it answers. */
export async function serve(edits = {}) {
  const server = createServer(async (request, response) => {
    const path = normalize(decodeURIComponent(new URL(request.url, 'http://x').pathname));
    const [start, folder] = mounts.find(([begin]) => path.startsWith(begin));
    try {
      let body = await readFile(join(folder, path.slice(start.length), path.endsWith('/') ? 'index.html' : ''));
      const edit = edits[Object.keys(edits).find((end) => path.endsWith(end))];
      if (edit) body = edit(body.toString());
      response.setHeader('content-type', types[path.endsWith('/') ? '.html' : extname(path)] ?? 'application/octet-stream');
      response.end(body);
    } catch { response.statusCode = 404; response.end(); }
  });
  await new Promise((ok) => server.listen(0, '127.0.0.1', ok));
  return { url: `http://127.0.0.1:${server.address().port}`, close: () => server.close() };
}

// Software rendering; without Vulkan's lines WebGPU has no adapter, and WebGPURenderer falls back to WebGL2.
const flags = [
  '--no-sandbox', '--disable-quic', '--no-first-run', '--disable-background-networking', '--disable-component-update', '--disable-sync',
  '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader',
  '--enable-unsafe-webgpu', '--use-webgpu-adapter=swiftshader', '--enable-features=Vulkan', '--use-vulkan=swiftshader',
];

export async function launch() {
  const { chromium: driver } = createRequire(import.meta.url)(tool('playwright-core'));
  return driver.launch({ executablePath: chromium(), headless: true, args: flags });
}

/** A page of `page.html`, its renderer started and its backend asserted. `page.errors` gathers what goes wrong in it. */
export async function open(browser, url, api) {
  const page = await browser.newPage({ viewport: { width: 640, height: 420 } });
  page.errors = [];
  page.on('pageerror', (e) => page.errors.push(String(e)));
  page.on('console', (m) => { if (m.type() === 'error' && !/favicon/.test(m.text() + m.location().url)) page.errors.push(m.text()); });
  await page.goto(`${url}/test/three/page.html`);
  await page.waitForSelector('body[data-state]', { state: 'attached', timeout: 60_000 });
  const backend = await page.evaluate((a) => t.start(a), api);
  const expected = { webgl: 'WebGLRenderer', webgpu: 'WebGPUBackend' }[api];
  if (backend !== expected) throw new Error(`the renderer runs on ${backend}, not on ${expected}`);
  return page;
}
