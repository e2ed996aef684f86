// The modules of scenes and of queries leave out what only files bring, and digits: their answers and words are those of the module
// that has all, which golden.test.mjs holds against native ones.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { at, box, entry, perspective } from './package.mjs';

const all = await Promise.all(['index', 'queries', 'files'].map(entry));
await Promise.all(all.map(({ init }) => init()));
const clip = perspective(1, 1.6, 0.1, 300);
const random = (seed) => () => ((seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0) / 2 ** 32);

// Walls before a crowd of boxes of all sizes, in and out of view.
function crowd({ Scene }) {
  const next = random(11);
  const scene = new Scene();
  const cube = box(1, 1, 1);
  const closed = scene.addMesh(cube.positions, cube.indices, { twoSided: false });
  const ridge = scene.addMesh(new Float32Array([-1, 0, 0, 1, 0, 0, 1, 1, 0, -1, 1, 0.2, 0, 2, 0]), new Uint32Array([0, 1, 2, 0, 2, 3, 3, 2, 4]));
  for (let i = 0; i < 600; i++) {
    const size = 0.05 + next() ** 6 * 6;
    const matrix = at(next() * 80 - 40, next() * 30 - 15, -2 - next() * 120);
    matrix[0] = matrix[5] = matrix[10] = size;
    scene.add(i % 3 === 0 ? ridge : closed, matrix, { layers: 1 + (i % 2) });
  }
  scene.commit();
  return scene;
}

test('results, funnels, draws and explanations are the same in all', () => {
  const found = all.map((entry) => {
    const scene = crowd(entry);
    const answers = [];
    for (const preset of ['exact', 'balanced', 'fast']) {
      for (const output of ['instances', 'clusters', 'triangles']) {
        const view = scene.view({ preset, output, reasons: true, layers: 1, drawMicroseconds: 40 });
        for (let step = 0; step < 3; step++) {
          const camera = [...clip];
          camera[12] = step * 0.7;
          const visible = [...view.setCamera(camera, 1280, 800).cull()];
          const { commands, keys, instances, indices } = view.draws();
          answers.push({ visible, reasons: [...view.reasons()], funnel: view.funnel(), draws: [[...commands], [...keys], [...instances], [...indices]] });
        }
        for (let id = 0; id < 600; id += 7) answers.push(view.explain(id));
        view.dispose();
      }
    }
    scene.dispose();
    return answers;
  });
  assert.deepEqual(found[0], found[2]);
  assert.deepEqual(found[1], found[2]);
  const findings = found[0].flatMap((answer) => answer.steps ?? []).map((step) => step.finding);
  for (const words of [/inside of the \w+ plane/, /outside the \w+ plane by \d+\.\d{6} units/, /nearness \d(\.\d+)?e-?\d+/, /covered at \d/]) {
    assert.ok(findings.some((finding) => words.test(finding)), `${words} is among the findings`);
  }
});

test('messages are the same in all', () => {
  const wrong = [
    (scene) => scene.addMesh(new Float32Array([0, 0, 0, 1.5, NaN, -Infinity, 0, 1, 0]), new Uint32Array([0, 1, 2])),
    (scene) => scene.addMesh(new Float32Array(9), new Uint32Array([0, 1, 9])),
    (scene) => scene.view().setCamera(clip.map((v, i) => (i === 0 ? 0 : v)), 640, 400),
    (scene) => scene.view().setCamera(clip.map((v, i) => (i === 5 ? Infinity : v)), 640, 400),
    (scene) => scene.view({ depth: 'reversed' }).setCamera(clip, 640, 400),
  ];
  const messages = all.map(({ Scene }) => wrong.map((call) => {
    const scene = new Scene();
    try { call(scene); } catch (error) { return error.message; } finally { scene.dispose(); }
    return 'no error';
  }));
  assert.deepEqual(messages[0], messages[2]);
  assert.deepEqual(messages[1], messages[2]);
  assert.match(messages[0][0], /vertex 1 is not finite: \[1\.5, NaN, -inf\]/);
});
