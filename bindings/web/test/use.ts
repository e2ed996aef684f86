import { BoxSet, CulletError, init, Scene, STAGES, type Draws, type Explanation } from 'cullet';
import { filesNamed, info, Scene as FileScene, type ModelInfo } from 'cullet/files';
import * as frustum from 'cullet/frustum';
import { BoxSet as Boxes, init as load, OccluderSet } from 'cullet/boxes';
import { LIGHT_REASONS, NONE, Scene as QueryScene, type BoxSight, type Light, type View as QueryView } from 'cullet/queries';

await init();
await init(new URL('https://example.org/cullet.wasm'));
await frustum.init(fetch('cullet-frustum.wasm'));
const set = new BoxSet(10);
set.boxes.set([0, 0, 0, 1, 1, 1]);
set.commit(0, 1);
const list: Uint32Array = set.cull(new Float64Array(24), 1);
// @ts-expect-error: a set's length is not to be set.
set.length = list.length;
const scene = new Scene();
const mesh: number = scene.addMesh(new Float32Array(9), [0, 1, 2], { twoSided: false, alpha: 'masked' });
// @ts-expect-error: there is no such mode.
scene.addMesh(new Float32Array(9), [0, 1, 2], { alpha: 'clear' });
// @ts-expect-error: positions are f32.
scene.addMesh(new Float64Array(9), [0, 1, 2]);
const id = scene.add(mesh, new Float32Array(16), { layers: 3, occluder: false });
const view = scene.view({ preset: 'fast', depth: 'webgl', reasons: true });
for (const visible of view.setCamera([1, 2, 3], 640, 400).cull()) console.log(visible);
const draws: Draws = view.draws();
const why: Explanation = view.explain(id);
console.log(STAGES[view.reasons()[id] ?? 0], draws.commands.length, why.reason?.stage, view.funnel()[0]?.left.triangles);
const opened: FileScene = FileScene.open(new ArrayBuffer(1), 'model.glb');
const model: ModelInfo = info(new ArrayBuffer(1), 'a.gltf', Object.fromEntries(filesNamed(new Uint8Array(1), 'a.gltf').map((name) => [name, new Uint8Array(1)])));
console.log(model.scene.triangles, model.scene.extent?.[0][1], model.meshes[0]?.defect?.length, model.groups?.depth);
// @ts-expect-error: a model may be empty, and then has no extent.
console.log(model.scene.extent[0]);
try { opened.remove(3); } catch (error) { if (error instanceof CulletError && error.code === 'id') console.log(error.message); }
await load();
const occluders = new OccluderSet(640, 360);
const wall: number = occluders.addTriangles(new Float32Array(9), [0, 1, 2], { twoSided: false });
occluders.setMatrix(wall, [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);
console.log(occluders.draw(new Float32Array(16), 'webgl'), occluders.visible(new Boxes(3), 1).length);
// @ts-expect-error: a box has six numbers, not three corners.
occluders.addBox([0, 0, 0], [1, 1, 1]);
const queries = new QueryScene();
const blocker = queries.lineOfSight([0, 0, 0], new Float64Array(3), { ignore: id });
const sight: BoxSight = queries.boxToBox([0, 0, 0, 1, 1, 1], new Float32Array(6), { motion: [1, 2] });
const eye: QueryView = queries.view({ preset: 'exact' }).setCamera([1, 2, 3], 640, 400);
const lamps: Light[] = [{ kind: 'point', position: [0, 0, 0], range: 3 }, { kind: 'directional', direction: [0, -1, 0] }];
const { kept, reasons } = eye.lights(lamps, { casters: true });
console.log(blocker?.point[0], sight.by === NONE, kept.length, LIGHT_REASONS[reasons[0] ?? 0], eye.casters(0), eye.cullAmong([1]));
console.log(queries.visibleFrom([0, 0, 0, 1, 1, 1], { view: eye, cellWorld: 1 }), queries.neededAlong([0, 0, 0]).distances);
// @ts-expect-error: a point light has a position.
eye.lights([{ kind: 'point', range: 3 }]);
// @ts-expect-error: a view is made by its scene.
new (await import('cullet')).View();
