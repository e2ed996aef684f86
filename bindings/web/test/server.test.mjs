// The server of the example helps no cheat: what is hidden is not sent. And nothing that comes into sight is missing.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { BODY, isFree, level, players, PROP, random } from '../example/server/level.js';
import { Server } from '../example/server/server.js';
import { entry } from './package.mjs';

const { init, Scene } = await entry('queries');
await init();

// 4 ticks: one to the next message, three for the ping.
const [TICK, KNOWN, SPEED] = [1 / 30, 4, 5];
const ground = level({ rooms: 4, props: 300, seed: 5 });
const game = players(ground, { count: 64, speed: SPEED, seed: 3 });
const history = [];
for (let i = 0; i < 8 + KNOWN; i++) {
  history.push(game.all.map(({ x, z }) => ({ x, z })));
  game.step(TICK);
}
// Walls are higher than everybody: whether two points see each other is seen from above. Slabs, and no part of the engine.
const isClear = (ax, az, bx, bz) => ground.walls.every(([x0, z0, x1, z1]) => {
  let [near, far] = [0, 1];
  for (const [from, way, low, high] of [[ax, bx - ax, x0, x1], [az, bz - az, z0, z1]]) {
    if (way === 0) {
      if (from <= low || from >= high) return true;
    } else {
      const [s, t] = [(low - from) / way, (high - from) / way];
      [near, far] = [Math.max(near, Math.min(s, t)), Math.min(far, Math.max(s, t))];
    }
  }
  return near >= far;
});
const spots = (x, z, half) => [[x, z], [x - half, z - half], [x + half, z - half], [x - half, z + half], [x + half, z + half]];
const sees = (eye, thing, half) => spots(thing.x, thing.z, half).some(([x, z]) => isClear(eye.x, eye.z, x, z));
const props = ground.props.map(([x, z]) => ({ x, z }));

/** Where a player may be some seconds later: where he is led by chance, at full speed, and no wall stands between. */
const later = (p, seconds, next) => {
  const angle = next() * 2 * Math.PI;
  const q = { x: p.x + Math.cos(angle) * SPEED * seconds, z: p.z + Math.sin(angle) * SPEED * seconds };
  return isFree(ground.walls, q.x, q.z) && isClear(p.x, p.z, q.x, q.z) ? q : p;
};

/** Things that come into sight while a message is all that a client knows, and are not in it. */
function missing(server, ticks = 8) {
  const next = random(11);
  let [found, seen] = [0, 0];
  for (let t = 0; t < ticks; t++) {
    const sent = server.tick(history[t]).map((s) => ({ players: new Set(s.players), props: new Set(s.props) }));
    for (let a = t % 4; a < 64; a += 4) {
      const check = (is, eye, thing, half) => {
        if (!sees(eye, thing, half)) return;
        seen++;
        if (!is) found++;
      };
      for (let k = 0; k <= KNOWN; k++) {
        // The way that they went, and others that they could have gone.
        const ways = [[history[t + k][a], history[t + k]], [later(history[t][a], k * TICK, next), history[t].map((p) => later(p, k * TICK, next))]];
        for (const [eye, others] of ways) {
          others.forEach((p, b) => b !== a && check(sent[a].players.has(b), eye, p, BODY.half));
          props.forEach((p, i) => check(sent[a].props.has(i), eye, p, PROP.half));
        }
      }
      // As far as they come, players both go many ways.
      for (let way = 0; way < 20; way++) {
        const eye = later(history[t][a], KNOWN * TICK, next);
        history[t].forEach((p, b) => b !== a && check(sent[a].players.has(b), eye, later(p, KNOWN * TICK, next), BODY.half));
      }
    }
  }
  return { found, seen };
}

test('nothing is missing that comes into sight before the next message', () => {
  const server = new Server(Scene, ground, { speed: SPEED, seconds: KNOWN * TICK });
  const { found, seen } = missing(server);
  assert.ok(seen > 10_000, `${seen} were seen`);
  assert.equal(found, 0, `${found} of ${seen} that were seen had not been sent`);
});

test('without an allowance for the motion something is missing', () => {
  const { found } = missing(new Server(Scene, ground, { speed: SPEED, seconds: 0 }), 2);
  assert.ok(found > 0, 'the oracle sees what is missing');
});

// Tiles, what is taken off walls, and pixels of squares make the answer so much larger than the motion, in metres.
const SLACK = 2;
// Two walls that hide something together, neither of them alone, are not always found to: a share of what is sent.
const MOST = 0.02;
/** Things that were sent although nobody sees them from within the motion, and a little more; and how many were sent. Of players that is slow. */
function cheats(server, motion, { ticks = [0], ofPlayers = false } = {}) {
  let [found, sent] = [0, 0];
  const reach = motion + SLACK;
  const around = (p, step, r) => {
    const places = [p];
    for (let x = p.x - r; x <= p.x + r; x += step) for (let z = p.z - r; z <= p.z + r; z += step) if (isFree(ground.walls, x, z)) places.push({ x, z });
    return places;
  };
  for (const t of ticks) {
    const lists = server.tick(history[t]);
    for (let a = 0; a < 64; a += 4) {
      const eyes = around(history[t][a], 0.25, reach);
      const judge = (places, half) => {
        sent++;
        if (!places.some((thing) => eyes.some((eye) => sees(eye, thing, half)))) found++;
      };
      for (const b of ofPlayers ? lists[a].players : []) judge(around(history[t][b], 0.5, reach), BODY.half);
      for (const i of lists[a].props) judge([props[i]], PROP.half);
    }
  }
  return { found, sent };
}

test('nothing is sent that is hidden beyond the motion', () => {
  const motion = KNOWN * TICK * SPEED;
  const { found, sent } = cheats(new Server(Scene, ground, { speed: SPEED, seconds: KNOWN * TICK }), motion, { ticks: [0, 6], ofPlayers: true });
  assert.ok(sent > 300 && sent < 2 * 16 * 363 * 0.5, `${sent} were sent`);
  assert.ok(found <= MOST * sent, `${found} of ${sent} sent were hidden`);
  const open = { tick: (all) => all.map(() => ({ players: [], props: props.map((_, i) => i) })) };
  const all = cheats(open, motion);
  assert.ok(all.found > 0.5 * all.sent, `the oracle sees that ${all.found} of ${all.sent} are hidden`);
  // A server that takes players for eight times as fast.
  const wide = cheats(new Server(Scene, ground, { speed: 8 * SPEED, seconds: KNOWN * TICK }), motion);
  assert.ok(wide.found > MOST * wide.sent, `and ${wide.found} of ${wide.sent} that it sends too early`);
});
