// The package under test: `CULLET_PACKAGE` is the folder that build.mjs made, `CULLET_NODE_MODULES` one in whose
// node_modules the packages of test/tools/package.json are.
import { createRequire } from 'node:module';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';

const set = (name, what) => {
  if (!process.env[name]) throw new Error(`${name} must name ${what}: run \`cargo xtask bindings web\``);
  return process.env[name];
};
export const folder = set('CULLET_PACKAGE', 'the folder that build.mjs made');
export const entry = (name) => import(pathToFileURL(join(folder, 'js', `${name}.js`)));
export const tools = () => set('CULLET_NODE_MODULES', 'a folder with the packages that tests need');
export const tool = (name) => createRequire(join(tools(), 'x.js')).resolve(name);
export const chromium = () => process.env.CHROMIUM ?? '/usr/bin/chromium';

export const perspective = (fovY, aspect, near, far) => {
  const y = 1 / Math.tan(fovY / 2);
  return [y / aspect, 0, 0, 0, 0, y, 0, 0, 0, 0, far / (near - far), -1, 0, 0, (near * far) / (near - far), 0];
};
export const at = (x, y, z) => [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, x, y, z, 1];
/** A closed box of half size (x, y, z), fronts outside. */
export const box = (x, y, z) => {
  const positions = new Float32Array([-x, -y, -z, x, -y, -z, -x, y, -z, x, y, -z, -x, -y, z, x, -y, z, -x, y, z, x, y, z]);
  const indices = new Uint32Array([0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4, 2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5]);
  return { positions, indices };
};
