// In Chromium: the shared answers, without a bundler.
import assert from 'node:assert/strict';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';
import { fileURLToPath } from 'node:url';
import { folder } from './package.mjs';
import { inPage } from './page.mjs';

const golden = process.env.CULLET_GOLDEN;
const skip = golden || process.env.CULLET_REQUIRE_DATA === '1' ? false : 'CULLET_GOLDEN names no folder: cargo xtask bindings web';
const site = mkdtempSync(join(tmpdir(), 'cullet-'));
process.on('exit', () => rmSync(site, { recursive: true, force: true }));
writeFileSync(join(site, 'index.html'), '<!doctype html><title>cullet</title>');
const others = { cullet: join(folder, 'js'), test: fileURLToPath(new URL('.', import.meta.url)), golden: golden ?? site };

test('baked files give a page the answers that every host gives', { skip }, async () => {
  const { scenes } = JSON.parse(readFileSync(join(golden, 'golden.json'), 'utf8'));
  const count = await inPage(site, (page) => page.evaluate(async () => {
    const { init, Scene } = await import('/cullet/files.js');
    const { compare } = await import('/test/golden.mjs');
    await init();
    let views = 0;
    const { scenes } = await (await fetch('/golden/golden.json')).json();
    for (const scene of scenes) views += compare(Scene, await (await fetch(`/golden/${scene.file}`)).arrayBuffer(), scene);
    return views;
  }), others);
  assert.equal(count, scenes.reduce((sum, scene) => sum + scene.views.length, 0));
  assert.ok(count >= 15);
});

test('a page whose module is missing is told where it was looked for', async () => {
  const told = await inPage(site, (page) => page.evaluate(async () => {
    const { init } = await import('/cullet/index.js');
    const first = await init('/nowhere/cullet.wasm').catch((error) => `${error.code}: ${error.message}`);
    await init();
    return first;
  }), others);
  assert.match(told, /^load: cullet: http.*nowhere\/cullet\.wasm answered 404/);
});
