// Whether the picture is the same with occlusion whatever is set: a wall before balls, and one or two properties of three.js that
// are other than usual, from the start or after the first picture.

import { random } from './scenes.js';

const SIZE = [96, 64];

/** Each changes one thing: of the wall, of its material, of the balls, the camera, the scene or the renderer. */
export const properties = {
  // Materials.
  transparent: (c) => { c.m.transparent = true; c.m.opacity = 0.5; },
  opacityAlone: (c) => { c.m.opacity = 0.3; },
  transmission: (c) => { if ('transmission' in c.m) c.m.transmission = 1; else c.use('Physical', { transmission: 1, roughness: 0 }); },
  additive: (c) => { c.wall.renderOrder = 1; c.m.blending = c.T.AdditiveBlending; },
  multiply: (c) => { c.wall.renderOrder = 1; c.m.blending = c.T.MultiplyBlending; c.m.premultipliedAlpha = true; },
  subtractive: (c) => { c.wall.renderOrder = 1; c.m.blending = c.T.SubtractiveBlending; c.m.premultipliedAlpha = true; },
  customBlending: (c) => { c.wall.renderOrder = 1; c.m.blending = c.T.CustomBlending; c.m.blendSrc = c.T.OneFactor; c.m.blendDst = c.T.OneFactor; },
  noBlending: (c) => { c.wall.renderOrder = 1; c.m.blending = c.T.NoBlending; c.m.opacity = 0.1; },
  colorWriteOff: (c) => { c.wall.renderOrder = 1; c.m.colorWrite = false; },
  depthWriteOff: (c) => { c.m.depthWrite = false; },
  depthTestOff: (c) => { c.m.depthTest = false; },
  alwaysDepth: (c) => { c.m.depthFunc = c.T.AlwaysDepth; },
  lessDepth: (c) => { c.m.depthFunc = c.T.LessDepth; },
  greaterDepth: (c) => { c.m.depthFunc = c.T.GreaterDepth; },
  neverDepth: (c) => { c.m.depthFunc = c.T.NeverDepth; },
  alphaTest: (c) => { c.m.alphaTest = 0.5; c.m.opacity = 0.4; },
  alphaMap: (c) => { c.m.alphaMap = c.dots; c.m.alphaTest = 0.5; },
  alphaHash: (c) => { c.m.alphaHash = true; c.m.opacity = 0.5; },
  alphaToCoverage: (c) => { c.wall.renderOrder = 1; c.m.alphaToCoverage = true; c.m.opacity = 0.2; },
  vertexAlpha: (c) => { c.wall.renderOrder = 1; const n = c.wall.geometry.attributes.position.count; c.wall.geometry.setAttribute('color', new c.T.Float32BufferAttribute(new Array(n * 4).fill(0.2), 4)); c.m.vertexColors = true; },
  wireframe: (c) => { c.m.wireframe = true; },
  backSide: (c) => { c.m.side = c.T.BackSide; },
  doubleSide: (c) => { c.m.side = c.T.DoubleSide; },
  polygonOffset: (c) => { c.m.polygonOffset = true; c.m.polygonOffsetUnits = 4e6; },
  materialHidden: (c) => { c.m.visible = false; },
  localClipping: (c) => { c.renderer.localClippingEnabled = true; c.m.clippingPlanes = [new c.T.Plane(new c.T.Vector3(1, 0, 0), 0)]; },
  materialCallback: (c) => { c.m.onBeforeRender = () => {}; },
  materialList: (c) => { c.wall.geometry.clearGroups(); c.wall.geometry.addGroup(0, 12, 0); c.wall.material = [c.m]; },
  basic: (c) => { c.use('Basic'); },
  normal: (c) => { c.use('Normal'); },
  // The wall.
  wallInLayer1: (c) => { c.wall.layers.set(1); },
  wallInNoLayer: (c) => { c.wall.layers.disableAll(); },
  wallHidden: (c) => { c.wall.visible = false; },
  holderHidden: (c) => { c.holder.visible = false; },
  wallMoved: (c) => { c.wall.position.y = 9; },
  wallScaledToNothing: (c) => { c.wall.scale.setScalar(0); },
  wallMirrored: (c) => { c.wall.scale.z = -1; },
  wallNotCulled: (c) => { c.wall.frustumCulled = false; },
  drawRange: (c) => { c.wall.geometry.setDrawRange(0, 6); },
  fewerTriangles: (c) => { const { index } = c.wall.geometry; index.array.fill(0, 6); index.needsUpdate = true; },
  otherIndex: (c) => { c.wall.geometry.setIndex([0, 2, 1]); },
  otherPositions: (c) => { const { position } = c.wall.geometry.attributes; c.wall.geometry.setAttribute('position', new c.T.BufferAttribute(position.array.map((v) => 0.2 * v), 3)); c.culling?.update(c.wall); },
  wallRemoved: (c) => { c.wall.removeFromParent(); },
  wallLast: (c) => { c.wall.renderOrder = 3; },
  wallFirst: (c) => { c.wall.renderOrder = -3; },
  morphed: (c) => { const { geometry } = c.wall; geometry.morphAttributes.position = [geometry.attributes.position.clone()]; geometry.morphTargetsRelative = true; c.wall.morphTargetInfluences = [5]; c.wall.updateMorphTargets(); c.wall.morphTargetInfluences[0] = 5; c.culling?.update(c.wall); },
  objectCallback: (c) => { c.wall.onAfterRender = (renderer) => { if (renderer.isWebGLRenderer) renderer.clearDepth(); }; c.wall.renderOrder = -1; },
  // The balls.
  ballsInFront: (c) => { c.balls.position.z = 12; },
  ballsUntested: (c) => { c.b.depthTest = false; c.balls.children.forEach((o) => { o.renderOrder = 4; }); },
  ballsGreater: (c) => { c.b.depthFunc = c.T.GreaterDepth; c.balls.children.forEach((o) => { o.renderOrder = 4; }); },
  ballsOffset: (c) => { c.b.polygonOffset = true; c.b.polygonOffsetUnits = -4e8; c.b.polygonOffsetFactor = -4e6; c.balls.children.forEach((o) => { o.renderOrder = 4; }); },
  ballsTransparent: (c) => { c.b.transparent = true; c.b.opacity = 0.5; },
  ballsInLayer1: (c) => { c.balls.children.forEach((o) => o.layers.set(1)); },
  // The camera.
  cameraSeesLayer1: (c) => { c.camera.layers.enable(1); },
  cameraSeesLayer1Alone: (c) => { c.camera.layers.set(1); },
  cameraMoved: (c) => { c.camera.position.x = 12; },
  cameraZoomed: (c) => { c.camera.zoom = 0.3; c.camera.updateProjectionMatrix(); },
  cameraBehind: (c) => { c.camera.position.z = -30; c.camera.rotation.y = Math.PI; },
  viewOffset: (c) => { c.camera.setViewOffset(200, 100, 90, 40, 96, 64); },
  // The scene and the renderer.
  override: (c) => { c.scene.overrideMaterial = new c.T.MeshBasicMaterial({ color: 0x3366ff, wireframe: true }); },
  overrideOpaque: (c) => { c.scene.overrideMaterial = new c.T.MeshNormalMaterial(); },
  overrideAdditive: (c) => { c.scene.overrideMaterial = new c.T.MeshBasicMaterial({ color: 0x3366ff, blending: c.T.AdditiveBlending }); },
  clipping: (c) => { if (c.renderer.isWebGLRenderer) c.renderer.clippingPlanes = [new c.T.Plane(new c.T.Vector3(0, 0, -1), -9)]; },
  clippingNothing: (c) => { if (c.renderer.isWebGLRenderer) c.renderer.clippingPlanes = [new c.T.Plane(new c.T.Vector3(0, 0, -1), -5)]; },
  clippingHalf: (c) => { if (c.renderer.isWebGLRenderer) c.renderer.clippingPlanes = [new c.T.Plane(new c.T.Vector3(1, 0, -0.5), -4.5)]; },
  clippingBoth: (c) => { c.renderer.localClippingEnabled = true; c.m.clippingPlanes = [new c.T.Plane(new c.T.Vector3(1, 0, 0), 0), new c.T.Plane(new c.T.Vector3(0, 1, 0), 2)]; c.m.clipIntersection = true; },
  clippingAllOrNothing: (c) => { c.renderer.localClippingEnabled = true; c.m.clippingPlanes = [new c.T.Plane(new c.T.Vector3(1, 0, 0), -20), new c.T.Plane(new c.T.Vector3(0, 0, -1), 5)]; c.m.clipIntersection = true; },
  clippingDisabled: (c) => { c.m.clippingPlanes = [new c.T.Plane(new c.T.Vector3(1, 0, 0), 0)]; },
  clippingGroup: (c) => { c.group([new c.T.Plane(new c.T.Vector3(1, 0, 0), 0)]); },
  unsorted: (c) => { c.renderer.sortObjects = false; },
  targetWithoutDepth: (c) => { c.target = new c.T[c.renderer.isWebGLRenderer ? 'WebGLRenderTarget' : 'RenderTarget'](...SIZE, { depthBuffer: false }); },
  greaterPlane: (c) => { c.plane({ depthFunc: c.T.GreaterDepth }); },
  alwaysPlane: (c) => { c.plane({ depthFunc: c.T.AlwaysDepth }); },
  untestedPlane: (c) => { c.plane({ depthTest: false }); },
  untestedSprite: (c) => { const s = new c.T.Sprite(new c.T.SpriteMaterial({ color: 0x00ffff, depthTest: false })); s.scale.setScalar(9); s.position.z = -40; s.renderOrder = 1; c.scene.add(s); c.balls.children.forEach((o) => { o.renderOrder = 2; }); },
  sceneCallback: (c) => { c.scene.onBeforeRender = () => { c.wall.position.x = 30; c.wall.updateMatrixWorld(true); c.culling?.update(c.wall); }; },
};

/** Those that are there from the start: WebGPURenderer draws what comes under a ClippingGroup for one more picture as before. */
export const early = new Set(['clippingGroup']);

/** All singles, and `most` pairs of the rest, by a seed. */
export function chosen(most, seed = 1) {
  const names = Object.keys(properties);
  const pairs = names.flatMap((a, i) => names.slice(i + 1).map((b) => [a, b]));
  const next = random(seed);
  for (let i = pairs.length - 1; i > 0; i--) { const k = Math.floor(next() * (i + 1)); [pairs[i], pairs[k]] = [pairs[k], pairs[i]]; }
  return [[], ...names.map((name) => [name]), ...pairs.slice(0, most)];
}

function build(T, renderer) {
  const scene = new T.Scene();
  scene.background = new T.Color(0x202020);
  scene.add(new T.HemisphereLight(0xffffff, 0xffffff, 2));
  const camera = new T.PerspectiveCamera(60, SIZE[0] / SIZE[1], 0.1, 200);
  const texture = new T.DataTexture(new Uint8Array(16 * 4).map((_, i) => ((i >> 2) % 2 ? 255 : 0)), 4, 4);
  texture.needsUpdate = true;
  const m = new T.MeshLambertMaterial({ color: 0x806040 });
  const holder = new T.Group();
  const wall = new T.Mesh(new T.BoxGeometry(20, 12, 1), m);
  wall.position.z = -8;
  scene.add(holder.add(wall));
  const b = new T.MeshLambertMaterial({ color: 0xff0000 });
  const shape = new T.SphereGeometry(0.5, 24, 18);
  const balls = new T.Group();
  for (let i = 0; i < 60; i++) {
    const ball = new T.Mesh(shape, b);
    ball.position.set((i % 12 - 5.5) * 0.9, (Math.floor(i / 12) - 2) * 1.4, -14 - i % 3);
    balls.add(ball);
  }
  scene.add(balls);
  const context = {
    T, renderer, scene, camera, holder, wall, m, b, balls, dots: texture, target: null, culling: null,
    use(kind, given) { context.m = wall.material = new T[`Mesh${kind}Material`]({ ...given }); },
    group(planes) {
      if (renderer.isWebGLRenderer) return;
      const group = new T.ClippingGroup();
      group.clippingPlanes = planes;
      scene.add(group);
      group.add(holder, balls);
      if (!context.culling) context.root = group;
    },
    plane(given) {
      const mesh = new T.Mesh(new T.PlaneGeometry(40, 30), new T.MeshBasicMaterial({ color: 0x00ff00, ...given }));
      mesh.position.z = -20;
      mesh.renderOrder = 1;
      balls.children.forEach((o) => { o.renderOrder = 2; });
      scene.add(mesh);
    },
  };
  return context;
}

async function picture({ renderer, scene, camera, target }) {
  if (target) {
    renderer.setRenderTarget(target);
    renderer.clear();
    renderer.render(scene, camera);
    const pixels = await (renderer.isWebGLRenderer
      ? renderer.readRenderTargetPixelsAsync(target, 0, 0, ...SIZE, new Uint8Array(4 * SIZE[0] * SIZE[1]))
      : renderer.readRenderTargetPixelsAsync(target, 0, 0, ...SIZE));
    renderer.setRenderTarget(null);
    return Uint8Array.from(pixels);
  }
  renderer.render(scene, camera);
  const copy = document.createElement('canvas');
  [copy.width, copy.height] = SIZE;
  const context = copy.getContext('2d', { willReadFrequently: true });
  context.drawImage(renderer.domElement, 0, 0);
  return context.getImageData(0, 0, ...SIZE).data;
}

/** Pixels that differ with culling for one choice of properties, in two pictures; and how many meshes were hidden. */
export async function compare(T, renderer, Culling, names, late) {
  renderer.setPixelRatio(1);
  renderer.setSize(...SIZE);
  const pictures = [];
  let [hidden, why] = [0, null];
  for (const isCulled of [false, true]) {
    [renderer.localClippingEnabled, renderer.sortObjects] = [false, true];
    if (renderer.isWebGLRenderer) renderer.clippingPlanes = [];
    const context = build(T, renderer);
    const apply = (when) => names.forEach((name, k) => { if (late[k] === when) { properties[name](context); [context.m].flat().forEach((m) => { m.needsUpdate = true; }); context.b.needsUpdate = true; } });
    apply(false);
    if (isCulled) context.culling = new Culling(context.root ?? context.scene, { occlusion: context.camera, preset: 'exact' });
    const list = [await picture(context)];
    hidden += context.culling?.stats.hidden ?? 0;
    apply(true);
    list.push(await picture(context));
    hidden += context.culling?.stats.hidden ?? 0;
    why = context.culling?.stats.noOcclusion ?? why;
    pictures.push(list);
    context.culling?.dispose();
    context.target?.dispose();
  }
  let differ = 0;
  for (const at of [0, 1]) for (let i = 0; i < pictures[0][at].length; i += 4) differ += Number([0, 1, 2].some((k) => pictures[0][at][i + k] !== pictures[1][at][i + k]));
  return { differ, hidden, why };
}
