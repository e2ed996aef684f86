// The panel, freezing, explanations, and the cost of a draw, in Chromium.

import assert from 'node:assert/strict';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { pathToFileURL } from 'node:url';
import { launch, open, packageFolder, serve } from './harness.mjs';

let server, browser;
before(async () => { server = await serve(); browser = await launch(); });
after(async () => { await browser?.close(); server?.close(); });

// A wall, a ball behind it, one beside it, one far aside, and instances of all kinds of fate.
function small() {
  const T = t.three;
  const scene = new T.Scene();
  const camera = new T.PerspectiveCamera(60, 320 / 192, 0.1, 100);
  const put = (name, x, y, z, w, h, d) => {
    const mesh = new T.Mesh(new T.BoxGeometry(), new T.MeshNormalMaterial());
    mesh.name = name;
    mesh.position.set(x, y, z);
    mesh.scale.set(w, h, d);
    scene.add(mesh);
    return mesh;
  };
  const made = { wall: put('wall', 0, 0, -5, 6, 4, 0.5), behind: put('behind', 0, 0, -9, 1, 1, 1), beside: put('beside', 6.5, 0, -9, 1, 1, 1), aside: put('aside', 40, 0, -5, 1, 1, 1), back: put('back', 0, 0, 9, 1, 1, 1), gone: put('gone', 1, 0, -3, 1, 1, 1), other: put('other', -1, 0, -3, 1, 1, 1), glass: put('glass', 0, 1, -3, 0.2, 0.2, 0.2) };
  made.gone.visible = false;
  made.other.layers.set(3);
  made.glass.material.visible = false;
  const row = new T.InstancedMesh(new T.BoxGeometry(), new T.MeshNormalMaterial(), 3);
  [[0, 0, -8], [-6, 0, -9], [0, 0, 30]].forEach((at, k) => row.setMatrixAt(k, new T.Matrix4().setPosition(...at)));
  row.name = 'row';
  scene.add(row);
  return Object.assign(made, { row, scene, camera, render: () => t.renderer.render(scene, camera) });
}

const pageOf = async (api, url = server.url) => {
  const page = await open(browser, url, api);
  await page.evaluate(`window.small = ${small}`);
  return page;
};

for (const api of ['webgl', 'webgpu']) {
  test(`explanations, ${api}`, async () => {
    const page = await pageOf(api);
    const answers = await page.evaluate(async () => {
      const s = small();
      const culling = new t.Culling(s.scene, { occlusion: s.camera, preset: 'exact' });
      const before = culling.explain(s.wall);
      s.render();
      const said = Object.fromEntries(['wall', 'behind', 'beside', 'aside', 'back', 'gone', 'other', 'glass', 'row', 'scene', 'camera'].map((name) => [name, culling.explain(s[name])]));
      const late = s.wall.clone();
      s.scene.add(late);
      const group = new t.three.Group();
      group.name = 'shut';
      group.visible = false;
      group.add(s.beside);
      s.scene.add(group);
      Object.assign(said, { before, late: culling.explain(late), below: culling.explain(s.beside) });
      let thrown = null;
      try { culling.explain(7); } catch (error) { thrown = error.message; }
      culling.dispose();
      return { ...said, thrown, after: culling.explain(s.wall) };
    });
    const reasons = Object.fromEntries(Object.entries(answers).map(([name, answer]) => [name, answer?.reason]));
    assert.deepEqual(reasons, { wall: 'drawn', behind: 'hidden', beside: 'drawn', aside: 'outside', back: 'outside', gone: 'invisible', other: 'layers', glass: 'invisible', row: 'drawn', scene: 'empty', camera: 'three', before: 'unknown', late: 'unknown', below: 'invisible', thrown: undefined, after: 'three' });
    assert.match(answers.aside.text, /^Mesh "aside" \(id \d+\): outside of the camera's frustum: it lies right of it\.$/);
    assert.match(answers.back.text, /behind the camera/);
    assert.match(answers.below.text, /`visible` of Group "shut"/);
    assert.match(answers.glass.text, /material/);
    assert.match(answers.thrown, /explain\(\) takes an object of the scene, not 7/);
    assert.deepEqual(page.errors, []);
    await page.close();
  });

  test(`the panel shows the counts of stats, says what the map shows, and goes, ${api}`, async () => {
    const page = await pageOf(api);
    await page.evaluate(async () => {
      const s = window.s = small();
      window.culling = new t.Culling(s.scene, { occlusion: s.camera, preset: 'exact' });
      window.panel = await culling.panel({ camera: s.camera });
      window.show = async () => { panel.refresh(); s.render(); const stats = { ...culling.stats }; await null; await t.frame(); return { stats, text: Object.fromEntries([...panel.element.shadowRoot.querySelectorAll('[data-name]')].map((e) => [e.dataset.name, e.textContent])) }; };
    });
    const { stats, text } = await page.evaluate(() => show());
    assert.equal(text.drawn, `${stats.visible} of ${stats.objects}`);
    assert.deepEqual([stats.hidden, stats.hiddenInstances], [1, 1]);
    assert.deepEqual([text.hidden, text.hiddenInstances, text.clipped], ['1', '1', '0']);
    assert.equal(text.instances, `${stats.visibleInstances} of 3`);
    assert.equal(stats.visibleInstances, 1);
    assert.equal(text.occlusion, '1 draws, 0.01 ms');
    assert.equal(text.cost, '8 µs, default');
    assert.match(text.time, /^\d+\.\d\d ms$/);
    assert.ok(await page.evaluate(() => culling.panel().then((again) => again === panel)), 'one panel');
    // In words, why nothing is hidden.
    const refused = await page.evaluate(async () => { s.wall.onBeforeRender = () => {}; const shown = await show(); delete s.wall.onBeforeRender; await show(); return shown.text; });
    assert.match(refused.occlusion, /^nothing: Mesh "wall" has an onBeforeRender/);
    // By the mouse, where each object is on the map: the camera is in its middle, and looks up.
    const canvas = page.getByRole('application');
    const size = 240;
    const click = async (x, z) => {
      const reach = await page.evaluate(() => panel.reach);
      const at = (v) => size / 2 + (v * size) / 2 / reach;
      await canvas.click({ position: { x: at(x), y: at(z) } });
      return page.evaluate(() => panel.element.shadowRoot.querySelector('output').textContent);
    };
    assert.match(await click(0, -5), /"wall".*drawn/);
    assert.match(await click(0, -9), /"behind".*hide all of it/);
    assert.match(await click(0, 9), /"back".*outside/);
    assert.match(await click(-6, -9), /instance 1 of Mesh "row".*drawn/);
    assert.equal(await click(-14, 14), 'Nothing is there.');
    // By keys: the mark goes to the camera's left and up.
    await click(6.5, -9);
    await canvas.focus();
    const [back, up] = await page.evaluate(() => [0, 9 - 5].map((v, k) => Math.round((k ? v : 6.5) * 120 / panel.reach / 4)));
    for (let k = 0; k < back; k++) await page.keyboard.press('ArrowLeft');
    for (let k = 0; k < up; k++) await page.keyboard.press('ArrowDown');
    await page.keyboard.press('Enter');
    assert.match(await page.evaluate(() => panel.element.shadowRoot.querySelector('output').textContent), /"wall"/);
    assert.deepEqual(await page.evaluate(() => [panel.element.getAttribute('aria-live'), [...panel.element.shadowRoot.querySelectorAll('button')].every((b) => b.type === 'button' && (b.textContent.length > 1 || b.ariaLabel))]), ['off', true]);
    assert.equal((await page.evaluate(() => panel.explain(s.aside))).reason, 'outside');
    await page.getByRole('button', { name: 'Close' }).press('Enter');
    assert.deepEqual(await page.evaluate(async () => { panel.dispose(); s.render(); const next = await culling.panel(); const other = next !== panel; culling.dispose(); await null; await null; const late = await culling.panel().catch((error) => error.message); return [panel.element.isConnected, other, next.element.isConnected, late]; }), [false, true, false, 'cullet: panel() of a culling that was disposed; make another one']);
    assert.deepEqual(page.errors, []);
    await page.close();
  });

  test(`freezing keeps what was decided, ${api}`, async () => {
    const page = await pageOf(api);
    const got = await page.evaluate(async () => {
      const s = small();
      const culling = new t.Culling(s.scene, { occlusion: s.camera, preset: 'exact', shadows: 'seen' });
      const panel = await culling.panel();
      const count = () => { t.renderer.info.reset(); s.render(); return [culling.stats.visible, culling.stats.hidden, culling.stats.visibleInstances, t.renderer.info.render.triangles]; };
      const before = count();
      panel.element.shadowRoot.querySelector('button').click();
      const frozen = count();
      s.camera.position.set(0, 0, -20);
      s.camera.rotation.y = Math.PI;
      const turned = count();
      s.camera.rotation.y = 0;
      const away = count();
      const pressed = panel.element.shadowRoot.querySelector('button').getAttribute('aria-pressed');
      const late = s.wall.clone();
      late.position.set(0, 0, -40);
      s.scene.add(late);
      const more = count();
      panel.dispose();
      const live = count();
      const isOff = culling.frozen;
      culling.dispose();
      return { before, frozen, turned, away, more, live, isOff, pressed };
    });
    assert.deepEqual(got.frozen, got.before);
    assert.deepEqual(got.turned, got.before);
    assert.deepEqual(got.away, got.before, 'outside of the frustum of now, too');
    assert.deepEqual([got.pressed, got.isOff], ['true', false]);
    assert.equal(got.more[0], got.before[0] + 1, 'what came since is drawn');
    assert.ok(got.live[3] < got.more[3], `${got.live} after ${got.more}`);
    assert.deepEqual(page.errors, []);
    await page.close();
  });

  test(`what is frozen is the same picture from where it was decided, and the same draws from elsewhere, ${api}`, async () => {
    const page = await open(browser, server.url, api);
    for (const name of ['batchedTown', 'lamps']) {
      const { live, frozen, away, there } = await page.evaluate(async (n) => {
        await t.build(n);
        t.cull({ occlusion: true, preset: 'exact', shadows: 'seen' });
        const live = await t.picture();
        t.now.culling.frozen = true;
        const frozen = [await t.picture(), await t.picture()];
        if (n === 'lamps') t.now.camera.rotation.y += 2; else t.now.camera.position.z -= 16;
        const away = await t.picture();
        t.now.culling.frozen = false;
        return { live, frozen, away, there: await t.picture() };
      }, name);
      for (const picture of frozen) assert.equal(picture.digest, live.digest, `${name}: another picture`);
      const counts = ({ stats: s }) => (name === 'lamps' ? [] : [s.visible, s.hidden, s.visibleInstances, s.hiddenInstances]);
      assert.deepEqual(counts(away), counts(live));
      if (name === 'batchedTown') assert.equal(away.triangles, live.triangles);
      else assert.match(away.stats.allCast, /frozen/);
      assert.notEqual(there.digest, away.digest, `${name}: frozen for ever`);
    }
    assert.deepEqual(page.errors, []);
    await page.close();
  });

  test(`in a town and in an office of a thousand meshes occlusion pays, and pictures stay, ${api}`, async () => {
    const page = await open(browser, server.url, api);
    for (const name of ['town', 'office']) {
      const { three, ours, stats } = await page.evaluate(async (n) => {
        const three = await t.pictures(n, 'three');
        await t.build(n);
        t.cull({ occlusion: true });
        const ours = [];
        // Until the cost of a draw is known: each of these renders, with occlusion or to measure, is the same picture.
        for (let i = 0; i < 42; i++) { const { digest, stats } = await t.picture(); ours.push({ digest, stats }); }
        const { stats } = await t.picture();
        const steps = [];
        for (let i = 0; i < t.now.steps; i++) { t.now.step(i); steps.push(await t.picture()); }
        return { three, ours: [ours, steps], stats };
      }, name);
      const [start, steps] = ours;
      for (const { digest } of start) assert.equal(digest, three[0].digest, `${name}: another picture at the start`);
      steps.forEach(({ digest }, i) => assert.equal(digest, three[i + 1].digest, `${name}: another picture in step ${i}`));
      assert.ok(stats.objects > 950 && stats.objects < 1050, `${name}: ${stats.objects} meshes`);
      assert.ok(start.some(({ stats }) => stats.noOcclusion?.includes('to measure')) && start.filter(({ stats }) => stats.noOcclusion).length === 16, `${name}: ${start.map(({ stats }) => stats.noOcclusion)}`);
      assert.equal(stats.drawMicrosecondsFrom, 'measured');
      assert.ok(stats.drawMicroseconds >= 4 && stats.drawMicroseconds <= 50, `${stats.drawMicroseconds} µs`);
      const drawn = [stats, ...steps.map((p) => p.stats)];
      if (process.env.VERBOSE) console.log(api, name, stats.drawMicroseconds, drawn.map(({ visible, hidden }) => `${visible} drawn, ${hidden} hidden`).join('; '));
      assert.ok(drawn[0].hidden > 2 * drawn[0].visible, `${name}: ${drawn[0].hidden} hidden, ${drawn[0].visible} drawn`);
    }
    assert.deepEqual(page.errors, []);
    await page.close();
  });
}

test('the cost of a draw is the median of pairs of renders, within limits', async () => {
  const { DrawCost } = await import(pathToFileURL(join(packageFolder, 'js/three/cost.js')));
  // Renders of some work of their own, and `each` microseconds a draw; `odd`: every third without occlusion takes long.
  const measure = (each, { hidden = 600, odd = 0, renders = 40, another = false } = {}) => {
    const cost = new DrawCost();
    let trials = 0;
    for (let i = 0; i < renders; i++) {
      if (another) assert.equal(cost.begin('another'), !cost.isTrial);
      cost.begin('one');
      const out = cost.isTrial ? 0 : hidden;
      cost.pass({ visible: 700 - out, hidden: out, milliseconds: cost.isTrial ? 0.1 : 0.7 });
      trials += Number(cost.isTrial);
      cost.end(1.3 + (cost.isTrial ? 0.1 + (trials % 3 === 0 ? odd : 0) : 0.7) + (700 - out) * each / 1000);
    }
    return [cost.microseconds, cost.from, trials];
  };
  assert.deepEqual(measure(3), [9, 'measured', 16]);
  assert.deepEqual(measure(3, { odd: 20 }), [9, 'measured', 16]);
  assert.deepEqual(measure(3, { another: true }), [9, 'measured', 16]);
  assert.deepEqual(measure(0.1), [4, 'measured', 16]);
  assert.deepEqual(measure(90), [50, 'measured', 16]);
  assert.deepEqual(measure(3, { renders: 39 }), [8, 'default', 15]);
  assert.deepEqual(measure(3, { hidden: 49 }), [8, 'default', 0]);
  assert.deepEqual([new DrawCost(0.5).isOpen, new DrawCost(0.5).microseconds], [false, 0.5]);
});

test('a cost that is given is used as it is, in each run', async () => {
  const page = await open(browser, server.url, 'webgl');
  const runs = await page.evaluate(async () => {
    const runs = [];
    for (const drawMicroseconds of [4, 4, 0.01]) {
      await t.build('town');
      t.cull({ occlusion: true, drawMicroseconds });
      const list = [];
      for (let i = 0; i < 45; i++) list.push((await t.picture()).stats);
      runs.push({ from: list.at(-1).drawMicrosecondsFrom, cost: list.at(-1).drawMicroseconds, hidden: [...new Set(list.map(({ hidden }) => hidden))] });
    }
    return runs;
  });
  assert.deepEqual(runs[0], runs[1]);
  assert.deepEqual([runs[0].from, runs[0].cost, runs[0].hidden.length], ['given', 4, 1]);
  assert.ok(runs[0].hidden[0] > 300 && runs[2].hidden[0] === 0, JSON.stringify(runs));
  await page.close();
});

// Rules switched off, and what then fails: an answer of the small scene.
const mutants = [
  ['decisions.js', 'this.fates[i] === Fate.Drawn ||', '', 'what is frozen draws everything else'],
  ['explain.js', 'if (farthest < 0)', 'if (farthest > 0)', 'the side is wrong'],
  ['culling.js', 'decision.fates[i] = fate;', 'decision.fates[i] = Fate.Drawn;', 'hidden counts as drawn'],
];

test('a rule that is switched off is noticed', async () => {
  const ask = async (url) => {
    const page = await pageOf('webgl', url);
    const answer = await page.evaluate(async () => {
      const s = small();
      const culling = new t.Culling(s.scene, { occlusion: s.camera, preset: 'exact' });
      s.render();
      const texts = [s.aside, s.behind].map((o) => culling.explain(o).text.replace(/\(id \d+\)/, ''));
      culling.frozen = true;
      s.render();
      s.camera.rotation.y = Math.PI;
      s.render();
      const { visible } = culling.stats;
      culling.dispose();
      return { texts, visible };
    });
    await page.close();
    return answer;
  };
  const right = await ask(server.url);
  const missed = [];
  for (const [file, rule, instead, what] of mutants) {
    const mutated = await serve({ [`/js/three/${file}`]: (text) => {
      assert.equal(text.split(rule).length, 2, `${file} has no "${rule}", or several`);
      return text.replace(rule, instead);
    } });
    try {
      try { assert.deepEqual(await ask(mutated.url), right); missed.push(what); } catch (error) { if (error.code !== 'ERR_ASSERTION') throw error; }
    } finally { mutated.close(); }
  }
  assert.deepEqual(missed, []);
});
