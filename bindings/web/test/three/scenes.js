// Scenes of the tests. Each: `{ scene, camera, step(i, culling), steps }`; a step changes something, with or without culling.

import { city, sky, walk } from '../../example/city.js';

export const random = (seed) => () => ((seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0) / 2 ** 32);

export function ground(T, scene) {
  const plane = new T.Mesh(new T.PlaneGeometry(300, 300), new T.MeshLambertMaterial({ color: 0x556655 }));
  plane.rotation.x = -Math.PI / 2;
  plane.receiveShadow = true;
  scene.add(plane);
}

export function stage(T, size, { light = true } = {}) {
  const scene = new T.Scene();
  scene.background = new T.Color(0x88aacc);
  const camera = new T.PerspectiveCamera(60, size[0] / size[1], 0.1, 200);
  camera.position.set(0, 3, 0);
  if (light) {
    const sun = new T.DirectionalLight(0xffffff, 2);
    sun.position.set(30, 60, 20);
    scene.add(sun, new T.AmbientLight(0xffffff, 0.5));
  }
  const turn = (yaw, pitch = -0.05) => camera.rotation.set(pitch, yaw, 0, 'YXZ');
  turn(0.3);
  return { scene, camera, turn };
}

function place(object, next, spread = 80) {
  object.position.set((next() - 0.5) * 2 * spread, next() * 12, (next() - 0.5) * 2 * spread);
  object.rotation.set(next() * 6, next() * 6, next() * 6);
  object.scale.set(0.5 + 2 * next(), 0.5 + 2 * next(), 0.5 + 2 * next());
}

export const colour = (T, next) => new T.Color().setHSL(next(), 0.6, 0.5);

export function meshes(T, scene, count, { shadow = false, seed = 3 } = {}) {
  const next = random(seed);
  const geometries = [new T.BoxGeometry(), new T.SphereGeometry(0.6, 10, 8), new T.ConeGeometry(0.6, 1.4, 9), new T.TorusGeometry(0.5, 0.2, 6, 12)];
  const materials = Array.from({ length: 6 }, () => new T.MeshLambertMaterial({ color: colour(T, next) }));
  const list = [];
  for (let i = 0; i < count; i++) {
    const mesh = new T.Mesh(geometries[i % 4], materials[i % 6]);
    place(mesh, next);
    mesh.castShadow = mesh.receiveShadow = shadow;
    scene.add(mesh);
    list.push(mesh);
  }
  return list;
}

export function instanced(T, count, seed = 5) {
  const next = random(seed);
  const mesh = new T.InstancedMesh(new T.BoxGeometry(), new T.MeshLambertMaterial(), count);
  const dummy = new T.Object3D();
  for (let i = 0; i < count; i++) {
    place(dummy, next);
    dummy.updateMatrix();
    mesh.setMatrixAt(i, dummy.matrix);
    mesh.setColorAt(i, colour(T, next));
  }
  return mesh;
}

export function batched(T, count, material, seed = 9) {
  const next = random(seed);
  const shapes = [new T.BoxGeometry(), new T.SphereGeometry(0.6, 8, 6), new T.ConeGeometry(0.6, 1.4, 8)];
  const mesh = new T.BatchedMesh(count + 8, 400, 1600, material);
  const ids = shapes.map((g) => mesh.addGeometry(g));
  const dummy = new T.Object3D();
  for (let i = 0; i < count; i++) {
    place(dummy, next);
    dummy.updateMatrix();
    const id = mesh.addInstance(ids[i % 3]);
    mesh.setMatrixAt(id, dummy.matrix);
    mesh.setColorAt(id, colour(T, next));
  }
  return mesh;
}

function lights(T, scene) {
  const sun = new T.DirectionalLight(0xffffff, 1.5);
  sun.position.set(30, 60, 20);
  Object.assign(sun.shadow.camera, { left: -40, right: 40, top: 40, bottom: -40, near: 1, far: 150 });
  const spot = new T.SpotLight(0xffddaa, 4000, 80, 0.6, 0.3);
  spot.position.set(-20, 25, -20);
  spot.target.position.set(-5, 0, -10);
  const lamp = new T.PointLight(0xffaa66, 600, 50);
  lamp.position.set(5, 8, -8);
  for (const light of [sun, spot, lamp]) { light.castShadow = true; light.shadow.mapSize.set(256, 256); scene.add(light); }
  scene.add(spot.target, new T.AmbientLight(0xffffff, 0.4));
  return { sun, spot, lamp };
}

export const dummyMatrix = (T, x, y, z, s = 1) => new T.Matrix4().makeScale(s, s, s).setPosition(x, y, z);

export const scenes = {
  // The city at street level: most of it stands behind the first houses.
  city(T, size, count = 6000) {
    const scene = new T.Scene();
    sky(T, scene);
    const group = city(T, count);
    scene.add(group);
    const camera = new T.PerspectiveCamera(65, size[0] / size[1], 0.2, 2000);
    walk(camera, 0);
    const houses = group.getObjectByName('house');
    return {
      scene, camera, steps: 4, walk: (seconds) => walk(camera, seconds),
      step(i) {
        if (i === 0) walk(camera, 9);
        // What hid others hides them no longer: moved, hidden, see-through.
        if (i === 1) { for (let k = 0; k < houses.count; k += 2) houses.setMatrixAt(k, new T.Matrix4().makeTranslation(0, -900, 0)); houses.instanceMatrix.needsUpdate = true; }
        if (i === 2) { houses.material.transparent = true; houses.material.opacity = 0.5; houses.material.needsUpdate = true; }
        if (i === 3) { houses.visible = false; camera.rotation.y += 1; }
      },
    };
  },

  // Meshes that move, come and go.
  meshes(T, size) {
    const { scene, camera, turn } = stage(T, size);
    ground(T, scene);
    const list = meshes(T, scene, 800);
    return {
      scene, camera, steps: 5,
      step(i) {
        if (i === 0) turn(2);
        if (i === 1) for (let k = 0; k < 300; k++) { list[k].position.x *= -1; list[k].rotation.y += 1; }
        if (i === 2) for (let k = 300; k < 500; k++) list[k].removeFromParent();
        if (i === 3) { for (let k = 300; k < 400; k++) { list[k].position.z *= 0.5; scene.add(list[k]); } list[600].geometry.dispose(); list[600].material.dispose(); }
        if (i === 4) { for (const m of list.slice(0, 200)) m.visible = false; for (const m of list.slice(200, 300)) m.geometry = list[3].geometry; }
      },
    };
  },

  // Groups in groups: hidden, moved, ordered, mirrored; see-through things; layers; children of meshes.
  nested(T, size) {
    const { scene, camera, turn } = stage(T, size);
    ground(T, scene);
    const next = random(11);
    const glass = [0, 1].map((k) => new T.MeshLambertMaterial({ color: colour(T, next), transparent: true, opacity: 0.4, depthWrite: k === 0 }));
    const groups = [];
    for (let i = 0; i < 12; i++) {
      const group = i % 3 === 0 ? new T.Object3D() : new T.Group();
      (i > 5 ? groups[i - 6] : scene).add(group);
      group.position.set((next() - 0.5) * 20, 0, (next() - 0.5) * 20);
      group.rotation.y = next() * 6;
      group.scale.set(i % 4 === 1 ? -1 : 1, 1 + 0.3 * next(), 1);
      group.renderOrder = i % 5 === 4 ? 2 : 0;
      groups.push(group);
      for (const mesh of meshes(T, group, 40, { seed: i + 20 })) {
        if (next() < 0.3) mesh.material = glass[next() < 0.5 ? 0 : 1];
        if (next() < 0.1) mesh.layers.set(1);
        if (next() < 0.1) mesh.visible = false;
        if (next() < 0.2) {
          const child = new T.Mesh(mesh.geometry, mesh.material);
          child.position.set(0, 2, 0);
          mesh.add(child);
          const grandchild = child.clone();
          child.add(grandchild);
        }
      }
    }
    return {
      scene, camera, steps: 5,
      step(i) {
        if (i === 0) { turn(3.5); camera.layers.enable(1); }
        if (i === 1) { groups[2].visible = false; groups[7].visible = false; groups[3].renderOrder = 5; }
        if (i === 2) { groups[0].position.x += 9; groups[1].rotation.y += 1; groups[2].visible = true; }
        if (i === 3) { groups[4].attach(groups[1].children[3]); groups[5].add(groups[2]); groups[0].children[7].add(new T.Mesh(new T.BoxGeometry(3, 3, 3), glass[0])); }
        if (i === 4) { groups[3].clear(); groups[4].removeFromParent(); camera.layers.disable(1); }
      },
    };
  },

  // Everything that three.js itself draws, and whose bounds say little.
  odd(T, size) {
    const { scene, camera, turn } = stage(T, size);
    ground(T, scene);
    meshes(T, scene, 200);
    const next = random(2);
    scene.add(new T.GridHelper(40, 20));
    for (let i = 0; i < 20; i++) {
      const sprite = new T.Sprite(new T.SpriteMaterial({ color: colour(T, next) }));
      sprite.position.set((next() - 0.5) * 40, 3, (next() - 0.5) * 40);
      scene.add(sprite);
      const lod = new T.LOD();
      lod.addLevel(new T.Mesh(new T.SphereGeometry(1, 16, 12), new T.MeshNormalMaterial()), 0);
      lod.addLevel(new T.Mesh(new T.SphereGeometry(1, 5, 4), new T.MeshNormalMaterial()), 15);
      lod.position.set((next() - 0.5) * 60, 2, (next() - 0.5) * 60);
      scene.add(lod);
    }
    const points = new T.Points(new T.BufferGeometry().setFromPoints(Array.from({ length: 300 }, () => new T.Vector3((next() - 0.5) * 50, next() * 10, (next() - 0.5) * 50))), new T.PointsMaterial({ size: 0.3 }));
    scene.add(points);
    // A bone takes the vertices to where the bind pose is not.
    const geometry = new T.CylinderGeometry(0.5, 0.5, 4, 8, 4);
    const count = geometry.attributes.position.count;
    geometry.setAttribute('skinIndex', new T.Uint16BufferAttribute(new Uint16Array(4 * count).fill(0).map((_, i) => (i % 4 === 0 ? 1 : 0)), 4));
    geometry.setAttribute('skinWeight', new T.Float32BufferAttribute(new Float32Array(4 * count).map((_, i) => (i % 4 === 0 ? 1 : 0)), 4));
    const skinned = new T.SkinnedMesh(geometry, new T.MeshNormalMaterial());
    const bones = [new T.Bone(), new T.Bone()];
    bones[0].add(bones[1]);
    skinned.add(bones[0]);
    skinned.bind(new T.Skeleton(bones));
    skinned.position.set(30, 2, 30);
    scene.add(skinned);
    // A target that takes the box far from where it was.
    const morphed = new T.BoxGeometry();
    morphed.morphAttributes.position = [new T.Float32BufferAttribute(morphed.attributes.position.array.map((x, i) => (i % 3 === 2 ? x - 9 : x)), 3)];
    const morph = new T.Mesh(morphed, new T.MeshNormalMaterial());
    morph.position.set(0, 2, 12);
    morph.morphTargetInfluences = [0];
    scene.add(morph);
    // Nothing of it can be known.
    const lost = new T.Mesh(new T.BoxGeometry(), new T.MeshNormalMaterial());
    lost.position.x = NaN;
    const hidden = new T.Mesh(new T.BufferGeometry(), new T.MeshNormalMaterial());
    scene.add(lost, hidden);
    const eye = new T.Object3D();
    scene.add(eye);
    const gun = new T.Mesh(new T.BoxGeometry(0.1, 0.1, 0.4), new T.MeshNormalMaterial());
    gun.position.set(0.2, -0.2, -0.6);
    camera.add(gun);
    eye.add(camera);
    return {
      scene, camera, steps: 4, skinned, morph,
      step(i) {
        if (i === 0) bones[1].position.set(-30, 0, -40);
        if (i === 1) morph.morphTargetInfluences[0] = 3;
        if (i === 2) { turn(1.8); eye.position.set(3, 1, 3); }
        if (i === 3) { skinned.position.x -= 5; points.rotation.y += 1; }
      },
    };
  },

  // Three kinds of shadow over meshes.
  shadows(T, size) {
    const { scene, camera, turn } = stage(T, size, { light: false });
    ground(T, scene);
    const list = meshes(T, scene, 300, { shadow: true });
    const { sun, lamp, spot } = lights(T, scene);
    return {
      scene, camera, steps: 3,
      step(i) {
        if (i === 0) turn(2.4);
        if (i === 1) { sun.position.x = -30; lamp.position.set(-6, 6, 6); spot.position.x += 10; }
        if (i === 2) for (let k = 0; k < 100; k++) list[k].position.multiplyScalar(0.4);
      },
    };
  },

  // Instances with colours, and what is done to them.
  instances(T, size) {
    const { scene, camera, turn } = stage(T, size);
    ground(T, scene);
    const mesh = instanced(T, 1500);
    const group = new T.Group();
    group.add(mesh);
    const few = instanced(T, 40, 77);
    few.position.set(5, 0, 5);
    group.add(few);
    scene.add(group);
    return {
      scene, camera, steps: 5,
      step(i) {
        if (i === 0) turn(2.2);
        if (i === 1) { for (let k = 0; k < 400; k++) mesh.setMatrixAt(k, dummyMatrix(T, (k % 20) * 2 - 20, 2, -10 - Math.floor(k / 20) * 2)); mesh.instanceMatrix.needsUpdate = true; turn(0); }
        if (i === 2) { mesh.count = 500; group.rotation.y = 0.5; }
        if (i === 3) { mesh.setMatrixAt(5, dummyMatrix(T, 0, 3, -6, 2)); mesh.instanceMatrix.addUpdateRange(80, 16); mesh.instanceMatrix.needsUpdate = true; mesh.setColorAt(5, new T.Color(1, 0, 0)); mesh.instanceColor.needsUpdate = true; }
        if (i === 4) { mesh.count = 1500; few.dispose(); few.instanceMatrix = new T.InstancedBufferAttribute(few.instanceMatrix.array.map((x, k) => (k % 16 === 13 ? x + 2 : x)), 16); }
      },
    };
  },

  // Instances under three shadows: each pass has others.
  instancesInShadow(T, size) {
    const { scene, camera, turn } = stage(T, size, { light: false });
    ground(T, scene);
    const mesh = instanced(T, 450);
    mesh.castShadow = mesh.receiveShadow = true;
    scene.add(mesh);
    const { lamp, sun } = lights(T, scene);
    return {
      scene, camera, steps: 2,
      step(i) {
        if (i === 0) turn(2.2);
        if (i === 1) { lamp.position.set(-8, 5, 9); sun.position.z = -40; for (let k = 0; k < 200; k++) mesh.setMatrixAt(k, dummyMatrix(T, (k % 20) * 2 - 20, 2, -10 - Math.floor(k / 20) * 2)); mesh.instanceMatrix.needsUpdate = true; }
      },
    };
  },

  // A batch, opaque and see-through, and what is done to it.
  batch(T, size) {
    const { scene, camera, turn } = stage(T, size);
    ground(T, scene);
    const mesh = batched(T, 1000, new T.MeshLambertMaterial());
    const glass = batched(T, 200, new T.MeshLambertMaterial({ transparent: true, opacity: 0.5, depthWrite: false }), 31);
    const group = new T.Group();
    group.add(mesh, glass);
    scene.add(group);
    return {
      scene, camera, steps: 5,
      step(i) {
        if (i === 0) turn(2.2);
        if (i === 1) for (let k = 0; k < 200; k++) mesh.setMatrixAt(k, dummyMatrix(T, (k % 20) * 2 - 20, 2, 10 + Math.floor(k / 20) * 2));
        if (i === 2) { for (let k = 0; k < 700; k += 3) mesh.setVisibleAt(k, false); group.rotation.y = 0.8; }
        if (i === 3) { for (let k = 0; k < 100; k++) mesh.deleteInstance(k); for (let k = 0; k < 30; k++) { const id = mesh.addInstance(1); mesh.setMatrixAt(id, dummyMatrix(T, k - 15, 4, 8, 2)); } }
        if (i === 4) { mesh.sortObjects = false; glass.setGeometryIdAt(3, 2); for (let k = 150; k < 200; k++) mesh.setGeometryIdAt(k, k % 3); turn(0); }
      },
    };
  },

  // A batch under shadows.
  batchInShadow(T, size) {
    const { scene, camera, turn } = stage(T, size, { light: false });
    ground(T, scene);
    const mesh = batched(T, 300, new T.MeshLambertMaterial());
    mesh.castShadow = mesh.receiveShadow = true;
    scene.add(mesh);
    lights(T, scene);
    return { scene, camera, steps: 1, step() { turn(2.2); } };
  },

  // Two eyes drawn as one camera.
  eyes(T, size) {
    const { scene } = stage(T, size, { light: false });
    ground(T, scene);
    meshes(T, scene, 300, { shadow: true });
    const mesh = instanced(T, 300);
    scene.add(mesh);
    lights(T, scene);
    const eye = (i) => {
      const one = new T.PerspectiveCamera(40, size[0] / 2 / size[1], 0.1, 100);
      one.position.set(i * 0.5, 3, 0);
      one.lookAt(i ? -10 : 10, 2, -4);
      one.viewport = new T.Vector4((size[0] / 2) * i, 0, size[0] / 2, size[1]);
      one.updateMatrixWorld();
      return one;
    };
    const camera = new T.ArrayCamera([eye(0), eye(1)]);
    return {
      scene, camera, steps: 2,
      step(i) {
        if (i === 0) for (const [k, one] of camera.cameras.entries()) { one.lookAt(k ? -8 : 9, 1, 9); one.updateMatrixWorld(); }
        if (i === 1) camera.perCameraFrustumCulled = true;
      },
    };
  },

  // Two cameras, one after the other, into halves of one canvas; the second has parallel lines of sight.
  cascades(T, size) {
    const { scene, camera, turn } = stage(T, size, { light: false });
    ground(T, scene);
    meshes(T, scene, 400, { shadow: true });
    scene.add(instanced(T, 300));
    // Cascades: several lights of one direction, each with a larger box.
    for (const half of [10, 30, 90]) {
      const sun = new T.DirectionalLight(0xffffff, 0.6);
      sun.position.set(20, 50, 10);
      sun.castShadow = true;
      sun.shadow.mapSize.set(256, 256);
      Object.assign(sun.shadow.camera, { left: -half, right: half, top: half, bottom: -half, near: 1, far: 200 });
      scene.add(sun);
    }
    scene.add(new T.AmbientLight(0xffffff, 0.4));
    const plan = new T.OrthographicCamera(-20, 20, 12, -12, 1, 100);
    plan.position.set(0, 50, 0);
    plan.lookAt(0, 0, 0);
    const made = { scene, camera, steps: 3, step(i) { if (i === 0) turn(2.2); if (i === 1) made.camera = plan; if (i === 2) plan.position.x += 15; } };
    return made;
  },

  // Variance shadow maps: what receives a shadow is drawn into them too.
  variance(T, size) {
    const { scene, camera, turn } = stage(T, size, { light: false });
    ground(T, scene);
    const list = meshes(T, scene, 300, { shadow: true });
    for (const mesh of list.slice(0, 100)) mesh.castShadow = false;
    lights(T, scene);
    return {
      scene, camera, steps: 2, shadowType: 'VSMShadowMap',
      step(i) { if (i === 0) turn(2.4); if (i === 1) for (let k = 100; k < 200; k++) list[k].position.multiplyScalar(0.4); },
    };
  },

  // Cascades by three.js's own addon. WebGL's writes into materials, without moving a vertex.
  async addon(T, size) {
    const { scene, camera, turn } = stage(T, size, { light: false });
    ground(T, scene);
    meshes(T, scene, 400, { shadow: true });
    scene.add(new T.AmbientLight(0xffffff, 0.4));
    let update = () => {};
    if (t.renderer.isWebGPURenderer) {
      const { CSMShadowNode } = await import('three/addons/csm/CSMShadowNode.js');
      const sun = new T.DirectionalLight(0xffffff, 2);
      sun.position.set(20, 50, 10);
      sun.castShadow = true;
      sun.shadow.mapSize.set(256, 256);
      sun.shadow.camera.far = 400;
      sun.shadow.shadowNode = new CSMShadowNode(sun, { cascades: 3, maxFar: 120, mode: 'practical', lightMargin: 100 });
      scene.add(sun);
    } else {
      const { CSM } = await import('three/addons/csm/CSM.js');
      const csm = new CSM({ camera, parent: scene, cascades: 3, maxFar: 120, shadowMapSize: 256, lightDirection: new T.Vector3(-0.4, -1, -0.2).normalize(), lightMargin: 100, lightFar: 400 });
      scene.traverse((o) => { if (o.isMesh && !csm.shaders.has(o.material)) csm.setupMaterial(o.material); });
      update = () => { camera.updateMatrixWorld(); csm.update(); };
      update();
    }
    return { scene, camera, steps: 2, options: { movesVertices: () => false }, step(i) { turn(2.4 + i); update(); } };
  },

  // A group below a moved parent is culled, the rest of the scene is not ours.
  group(T, size) {
    const { scene, camera, turn } = stage(T, size);
    ground(T, scene);
    meshes(T, scene, 100);
    const parent = new T.Group();
    parent.position.set(4, 0, 2);
    const root = new T.Group();
    parent.add(root);
    scene.add(parent);
    meshes(T, root, 500, { seed: 44 });
    return { scene, camera, root, steps: 3, step(i) { if (i === 0) turn(2.2); if (i === 1) parent.rotation.y = 1; if (i === 2) { root.position.y = 2; root.visible = true; } } };
  },
};
