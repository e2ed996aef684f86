// 64 players and 2,000 props in a level of rooms, at 30 ticks a second: `node main.js [SECONDS]`.

import { init, Scene } from 'cullet/queries';
import { level, players } from './level.js';
import { Server } from './server.js';

// Bytes of one in a message.
const [PLAYER, PROP] = [16, 12];

/** Runs some work; its result, milliseconds, and milliseconds of a core, which other programs do not lengthen. */
const timed = (work) => {
  const [from, before] = [performance.now(), process.cpuUsage()];
  const result = work();
  return { result, ms: performance.now() - from, core: process.cpuUsage(before).user / 1000 };
};

await init();
const ground = level();
const server = new Server(Scene, ground);
const prepared = timed(() => server.prepare());
console.log(`${ground.walls.length} walls, ${server.sets.length} tiles prepared in ${(prepared.ms / 1000).toFixed(1)} s, ${(prepared.core / 1000).toFixed(1)} s of a core`);

const game = players(ground);
const ticks = Math.round(30 * Number(process.argv[2] ?? 10));
const times = [];
let [core, sentPlayers, sentProps] = [0, 0, 0];
for (let i = 0; i < ticks; i++) {
  game.step(1 / 30);
  const tick = timed(() => server.tick(game.all));
  times.push(tick.ms);
  core += tick.core;
  for (const { players: p, props } of tick.result) [sentPlayers, sentProps] = [sentPlayers + p.length, sentProps + props.length];
}
times.sort((a, b) => a - b);
const [n, most] = [game.all.length, ground.props.length];
const all = ticks * n * ((n - 1) * PLAYER + most * PROP);
const bytes = sentPlayers * PLAYER + sentProps * PROP;
console.log(`a tick: median ${times[ticks >> 1].toFixed(2)} ms, least ${times[0].toFixed(2)} ms, ${(core / ticks).toFixed(2)} ms of a core`);
console.log(`each player is sent ${(sentPlayers / ticks / n).toFixed(1)} of ${n - 1} players and ${(sentProps / ticks / n).toFixed(0)} of ${most} props: ${(bytes / ticks / 1000).toFixed(0)} kB a tick in place of ${(all / ticks / 1000).toFixed(0)} kB, ${(100 * (1 - bytes / all)).toFixed(1)} % saved`);
