import { init, Scene } from 'cullet';

await init();
const scene = new Scene();
const mesh = scene.addMesh(new Float32Array([0, 0, 0, 1, 0, 0, 0, 1, 0]), new Uint32Array([0, 1, 2]));
for (let x = 0; x < 1000; x++) scene.add(mesh, [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, x * 4, 0, -20, 1]);
scene.commit();
const view = scene.view();
// Each frame: world to clip space, and the viewport's pixels.
const visible = view.setCamera([1.5, 0, 0, 0, 0, 2, 0, 0, 0, 0, -1, -1, 0, 0, -0.1, 0], 1280, 720).cull();
console.log(`${visible.length} of ${scene.instanceCount} are drawn: ${visible}`);
