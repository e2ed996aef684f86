// Taken by tsc --strict: what a user writes, and what is to be refused.
import { BatchedMesh, BoxGeometry, InstancedMesh, MeshBasicMaterial, PerspectiveCamera, Scene, type BufferGeometry } from 'three';
import { bakedLevels, Culling, init, type CullingOptions, type Explanation, type Level, type Panel } from 'cullet/three';

const culls: boolean = await init();
console.log(culls);
const scene = new Scene();
const camera = new PerspectiveCamera();
const options: CullingOptions = { still: true, occlusion: [camera], preset: 'fast', shadows: 'seen', movesVertices: (mesh) => mesh.geometry.attributes.wave !== undefined };
const culling = new Culling(scene, options);
culling.enabled = false;
culling.update(scene.children[0]);
culling.update();
const share: number = culling.stats.visible / culling.stats.objects;
// @ts-expect-error: counts are not to be set
culling.stats.visible = share;
// @ts-expect-error: a renderer is no scene
new Culling(camera.projectionMatrix);
// @ts-expect-error: no such preset
new Culling(scene, { preset: 'best' });
// @ts-expect-error: no such shadows
new Culling(scene, { shadows: 'none' });
const kept: string = culling.stats.allCast ?? `${culling.stats.keptMaps} maps kept, ${culling.stats.clipped} clipped`;
console.log(kept);
const why: Explanation = culling.explain(scene.children[0]);
const panel: Panel = await culling.panel({ camera, parent: document.body });
culling.frozen = why.reason === 'hidden';
panel.refresh();
panel.dispose();
// @ts-expect-error: an explanation has no such reason
console.log(why.reason === 'gone', culling.stats.drawMicroseconds, culling.stats.drawMicrosecondsFrom === 'given', culling.stats.milliseconds);
// As GLTFLoader returns it; its own types need another package.
declare const gltf: { scene: Scene; parser: { json: unknown } };
const chains: Map<BufferGeometry, Level<BufferGeometry>[]> = await bakedLevels(gltf);
const trees = new InstancedMesh(new BoxGeometry(), new MeshBasicMaterial(), 9);
culling.levels(trees, chains.get(trees.geometry) ?? null, { pixels: 2, corners: true });
const batch = new BatchedMesh(9, 100, 200);
culling.levels(batch, [{ geometry: batch.addGeometry(trees.geometry), error: 0 }]);
// @ts-expect-error: geometries of a batch are numbers
culling.levels(batch, [{ geometry: trees.geometry, error: 0 }]);
// @ts-expect-error: a mesh alone has no instances
culling.levels(scene.children[0], null);
console.log(culling.stats.coarserInstances);
culling.dispose();
