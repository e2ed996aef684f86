import { BoxGeometry, Mesh, MeshNormalMaterial, PerspectiveCamera, Scene, WebGLRenderer } from 'three';
import { Culling, init } from 'cullet/three';

await init();
const [renderer, scene, camera] = [new WebGLRenderer(), new Scene(), new PerspectiveCamera(60, 2)];
for (let i = 0; i < 1000; i++) scene.add(new Mesh(new BoxGeometry(), new MeshNormalMaterial())).children[i].position.set(i - 500, 0, -9);
const culling = new Culling(scene);
renderer.render(scene, camera);
console.log(`${culling.stats.visible} of ${culling.stats.objects} drawn`);
