#!/usr/bin/env node
// The command `cullet` of the npm package: `npx cullet info model.glb`.

import { readFileSync } from 'node:fs';
import { basename, dirname, join } from 'node:path';
import { CulletError, filesNamed, info, init } from '../files.js';
import { lines } from './info.js';

const HELP = `Says what is in a model, and what is wrong with it: counts of triangles, the size, meshes that are not solids, warnings.

Usage: cullet info FILE [--all] [--json]

FILE is glTF or GLB, OBJ, PLY, STL, OFF, or a .bsp map of Quake. Buffers of glTF and materials of OBJ are read beside it.

Options
  --all        list every mesh and warning, not only the first 20
  --json       print the record as JSON
  -h, --help   print this help
  --version    print the version

Examples
  npx cullet info model.glb
  npx cullet info level.obj --all
  npx cullet info model.glb --json | node -p 'JSON.parse(fs.readFileSync(0)).scene.triangles'

Exit codes
  0 success; 2 wrong command line; 3 the file cannot be read or is invalid; 4 the file is over a limit; 70 a bug: please report it

All other commands, such as report, are in the program cullet of the Python package pycullet, or of a checkout:
https://github.com/cullet/cullet
`;

// As the program in Rust ends: scripts rely on the numbers.
const [USAGE, INPUT, LIMIT, INTERNAL] = [2, 3, 4, 70];
const OTHERS = ['report', 'verify', 'scenes', 'picture', 'explain', 'bake', 'simplify', 'occluders', 'cells', 'pvs', 'tiles', 'cut', 'view', 'serve', 'profile',
  'bench', 'calibrate', 'check-occlusion', 'replay', 'occscn', 'reproduce', 'lecture', 'quiz', 'film', 'fly', 'fetch'];

class Failure extends Error {
  constructor(exit, message) {
    super(message);
    this.exit = exit;
  }
}
const usage = (message) => new Failure(USAGE, `${message}\n\nUsage: cullet info FILE [--all] [--json]; cullet --help has examples`);

/** The file, the options, or what is to be printed in place of both. */
function parse(words) {
  const options = { all: false, json: false };
  const names = [];
  let isOver = false;
  for (const word of words) {
    if (isOver || !word.startsWith('-')) names.push(word);
    else if (word === '--') isOver = true;
    else if (word === '-h' || word === '--help') return { print: HELP };
    else if (word === '--version' || word === '-V') return { print: `cullet ${version()}\n` };
    else if (word === '--all' || word === '--json') options[word.slice(2)] = true;
    else throw usage(`unknown option ${word}: there are --all and --json`);
  }
  const [command, ...files] = names;
  if (command === undefined) throw usage('no command: the npm package has info');
  if (OTHERS.includes(command)) throw usage(`the npm package has no command ${command}, only info: ${command} is in the program of the Python package, \`pipx run --spec pycullet cullet ${command}\``);
  if (command !== 'info') throw usage(`unknown command ${command}: the npm package has info`);
  if (files.length !== 1) throw usage(files.length === 0 ? 'info needs a FILE' : `info takes one FILE, and was given ${files.length}`);
  return { file: files[0], ...options };
}

const version = () => JSON.parse(readFileSync(new URL('../../package.json', import.meta.url), 'utf8')).version;

function read(path) {
  try {
    return readFileSync(path);
  } catch (error) {
    if (error.code === 'ENOENT') throw new Failure(INPUT, `there is no file ${path}`);
    if (error.code === 'EISDIR') throw new Failure(INPUT, `${path} is a folder: give one file`);
    if (error.code === 'ERR_FS_FILE_TOO_LARGE') throw new Failure(LIMIT, `${path}: Node reads files of 2 GiB at the most; the program of the Python package reads larger ones`);
    throw new Failure(INPUT, `${path}: cannot be read: ${error.message}`);
  }
}

/** Files that a model names. One that is missing is left out: the reader says what that means. */
function beside(path, named) {
  const files = {};
  for (const name of named) {
    try {
      files[name] = readFileSync(join(dirname(path), name));
    } catch { /* Said by the reader, with the item that names it. */ }
  }
  return files;
}

async function run(words) {
  const { print, file, all, json } = parse(words);
  if (print !== undefined) return print;
  const bytes = read(file);
  await init();
  const name = basename(file);
  try {
    const record = info(bytes, name, beside(file, filesNamed(bytes, name)));
    return json ? `${JSON.stringify(record, null, 2)}\n` : `${lines(record, all).join('\n')}\n`;
  } catch (error) {
    if (!(error instanceof CulletError) || error.code === 'dead') throw error;
    const exit = error.code === 'limit' || error.code === 'memory' ? LIMIT : INPUT;
    throw new Failure(exit, error.message.replace(/^cullet: /, ''));
  }
}

// Whoever reads a pipe may have seen enough before its end.
for (const stream of [process.stdout, process.stderr]) stream.on('error', (error) => { if (error.code !== 'EPIPE') throw error; });
try {
  process.stdout.write(await run(process.argv.slice(2)));
} catch (error) {
  const isKnown = error instanceof Failure;
  process.stderr.write(isKnown ? `error: ${error.message}\n` : `error: a bug in cullet, please report it: ${error.stack}\n`);
  // Not by `exit`, which would end before a pipe has taken all.
  process.exitCode = isKnown ? error.exit : INTERNAL;
}
