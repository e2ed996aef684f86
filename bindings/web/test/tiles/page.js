// Renders worlds of tiles with and without the plugin, and counts the pixels in which both differ.
globalThis.fromModules = (path) => import(`/node_modules/${path}`);
const { camera, city, globe, start, three } = await import('./world.mjs');
const { CullingPlugin, init } = await import('cullet/tiles');
const { HemisphereLight, MeshNormalMaterial, Scene, WebGLRenderer, WebGLRenderTarget } = three;
const [width, height] = [320, 200];

await init();
const renderer = new WebGLRenderer();

function pixels({ tiles, camera: eye }) {
  const scene = new Scene();
  scene.add(tiles.group, new HemisphereLight());
  const target = new WebGLRenderTarget(width, height);
  renderer.setRenderTarget(target);
  renderer.setClearColor(0x88aaff);
  renderer.clear();
  renderer.render(scene, eye);
  const bytes = new Uint8Array(width * height * 4);
  renderer.readRenderTargetPixels(target, 0, 0, width, height, bytes);
  target.dispose();
  return new Uint32Array(bytes.buffer);
}

function compare(runs) {
  const [off, on] = runs.map(pixels);
  return { different: off.filter((pixel, i) => pixel !== on[i]).length, colours: new Set(off).size, tiles: runs.map(({ tiles }) => tiles.visibleTiles.size) };
}

async function both(world, ...where) {
  const runs = [null, new CullingPlugin()].map((plugin) => start(world, { camera: camera(...where), plugin }));
  for (const run of runs) await run.rest();
  return runs;
}

globalThis.pictures = {
  async street(refine) {
    const world = city({ refine, material: new MeshNormalMaterial() });
    const s = world.street(8);
    const runs = await both(world, [s, 5, 1.7], [s, 100, 1.7]);
    const found = [compare(runs)];
    for (let k = 0; k < 40; k++) {
      for (const run of runs) {
        run.camera.position.y += 0.5;
        run.camera.rotateOnWorldAxis(new three.Vector3(0, 0, 1), 0.01);
        await run.step();
      }
      if (k % 10 === 9) found.push(compare(runs));
    }
    return found;
  },
  async globe(points) {
    const mark = (tile, point) => { if (points) tile.extensions = { '3DTILES_horizon_occlusion_point': { horizonOcclusionPoint: point } }; };
    const world = globe({ levels: 3, mark });
    const runs = await both(world, [world.radius + 4e5, 0, 0], [world.radius * 0.2, world.radius * 0.9, 0], { near: 1e4, far: 1e8 });
    for (const { tiles } of runs) {
      tiles.group.traverse((mesh) => { if (mesh.isMesh) { mesh.material = new MeshNormalMaterial(); mesh.geometry.computeVertexNormals(); } });
    }
    return [compare(runs)];
  },
};
document.body.dataset.state = 'ready';
