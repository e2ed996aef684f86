// Properties of three.js that decide what hides, one by one and in pairs: never another picture.

import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { launch, open, serve } from './harness.mjs';

let server, browser;
before(async () => { server = await serve(); browser = await launch(); });
after(async () => { await browser?.close(); server?.close(); });

// CULLET_ALL=1: all pairs, some two thousand.
const most = process.env.CULLET_ALL === '1' ? Infinity : 60;

for (const api of ['webgl', 'webgpu']) {
  test(`no property and no pair of them shows in ${api}`, async () => {
    const page = await open(browser, server.url, api);
    const { wrong, hiding } = await page.evaluate((n) => t.pairs(n === null ? Infinity : n), most === Infinity ? null : most);
    assert.deepEqual(wrong, []);
    // It is not that nothing is ever hidden.
    for (const name of ['nothing', 'opacityAlone', 'doubleSide', 'basic', 'wallLast', 'noBlending', 'ballsTransparent', 'unsorted', 'overrideOpaque', ...(api === 'webgl' ? ['clippingNothing', 'clippingAllOrNothing'] : [])]) {
      assert.ok(hiding.includes(name), `${name}: nothing was hidden; of ${hiding.join(', ')}`);
    }
    await page.close();
  });
}

// Each rule switched off, and a property that then shows: the page finds it.
const mutants = [
  ['transparent', ' && !m.transparent'],
  ['transmission', ' && !(m.transmission > 0)'],
  ['additive', '(m.blending === NO_BLENDING || m.blending === NORMAL_BLENDING) && '],
  ['colorWriteOff', ' && m.colorWrite'],
  ['depthWriteOff', ' && m.depthWrite && m.depthFunc', ' && m.depthFunc'],
  ['alphaTest', ' && !(m.alphaTest > 0)'],
  ['greaterPlane', '(m.visible && resets ? May.ResetDepth : 0)', '0'],
  ['ballsUntested', '(isHidden(m) ? May.BeHidden : 0)', 'May.BeHidden'],
  ['objectCallback', 'object.onAfterRender !== callbackOf(object, \'onAfterRender\')', 'false'],
  ['localClipping', 'made.local = renderer.localClippingEnabled === true', 'made.local = false', 'clip.js'],
  ['clipping', 'made.union.push(...renderer.clippingPlanes);', '', 'clip.js'],
  ['clippingHalf', 'now += State.Whole;', 'now += State.Whole; else now += State.Whole;', 'occlusion.js'],
  ['clippingHalf', 'if (middle + radius < 0)', 'if (middle < 0)', 'clip.js'],
  ['targetWithoutDepth', 'target.depthBuffer === false ?', 'false ?'],
];

test('a rule that is switched off is noticed', async () => {
  for (const [property, rule, instead = '', file = 'hiding.js'] of mutants) {
    const mutated = await serve({ [`/js/three/${file}`]: (text) => {
      assert.equal(text.split(rule).length, 2, `${file} has no "${rule}", or several`);
      return text.replace(rule, instead);
    } });
    try {
      const page = await open(browser, mutated.url, 'webgl');
      const { wrong } = await page.evaluate((name) => t.pairs(0, [name]), property);
      assert.ok(wrong.length > 0, `without "${rule}" nothing shows with ${property}`);
      await page.close();
    } finally { mutated.close(); }
  }
});

test('with the default preset hidden draws are left out, or it is said why none are', async () => {
  const page = await open(browser, server.url, 'webgl');
  const found = await page.evaluate(() => {
    const { three: T, renderer, Culling } = t;
    const made = [];
    for (const count of [50, 500]) {
      const scene = new T.Scene();
      const camera = new T.PerspectiveCamera(60, 1.6, 0.1, 200);
      const wall = new T.Mesh(new T.BoxGeometry(20, 12, 1), new T.MeshBasicMaterial());
      wall.position.z = -8;
      scene.add(wall);
      const shape = new T.SphereGeometry(0.3, 8, 6);
      for (let i = 0; i < count; i++) {
        const ball = new T.Mesh(shape, new T.MeshBasicMaterial());
        ball.position.set((i % 20 - 10) * 0.5, (Math.floor(i / 20) % 10 - 5) * 0.5, -12 - Math.floor(i / 200));
        scene.add(ball);
      }
      const culling = new Culling(scene, { occlusion: camera });
      for (let k = 0; k < 3; k++) renderer.render(scene, camera);
      made.push({ ...culling.stats });
      // Alone, a group is in no scene that is heard of.
      culling.dispose();
    }
    const group = new T.Group();
    group.add(new T.Mesh(new T.BoxGeometry(), new T.MeshBasicMaterial()));
    const camera = new T.PerspectiveCamera();
    camera.position.z = 5;
    const culling = new Culling(group, { occlusion: camera });
    renderer.render(group, camera);
    return [...made, { ...culling.stats }];
  });
  assert.ok(found[1].visible < 50 && found[1].hidden > 450, JSON.stringify(found[1]));
  assert.equal(found[1].noOcclusion, null);
  assert.match(found[2].noOcclusion, /in no scene/);
  await page.close();
});
