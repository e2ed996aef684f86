// A module worker, of Node or of a page: culls what it is told, and answers with a copy.
import { BoxSet, init } from 'cullet/frustum';

const node = globalThis.process?.versions?.node ? await import(/* @vite-ignore */ ['node', 'worker_threads'].join(':')) : undefined;
const send = (message) => (node ? node.parentPort.postMessage(message) : postMessage(message));
await init();
const set = new BoxSet(100);
for (let i = 0; i < 100; i++) set.boxes.set([i, 0, 0, i + 0.5, 1, 1], 6 * i);
set.commit();
send([...set.cull([1, 0, 0, 10, -1, 0, 0, 10, 0, 1, 0, 10, 0, -1, 0, 10, 0, 0, 1, 10, 0, 0, -1, 10])]);
