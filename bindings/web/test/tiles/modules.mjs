// Packages for tests in Node.
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';
import { tools } from '../package.mjs';

export const from = (path) => import(pathToFileURL(join(tools(), 'node_modules', path)));
