// Taken by tsc --strict: what a user writes, and what is to be refused.
import { PerspectiveCamera, Scene } from 'three';
import { Culling, init, type CullingOptions } from 'cullet/three';

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
culling.dispose();
