// Scenes of towns and buildings: under many shadows, in batches, cut open by planes.

import { batched, colour, dummyMatrix, ground, instanced, meshes, random, scenes, stage } from './scenes.js';

export const towns = {
  // The city under a sun with shadows, and eight lamps.
  litCity(T, size, count = 20_000) {
    const made = scenes.city(T, size, count);
    made.scene.traverse((o) => { if (o.isMesh) { o.castShadow = o.name !== ''; o.receiveShadow = true; } });
    const sun = made.scene.children.find((o) => o.isDirectionalLight);
    sun.castShadow = true;
    Object.assign(sun.shadow.camera, { left: -150, right: 150, top: 150, bottom: -150, near: 1, far: 400 });
    sun.shadow.mapSize.set(1024, 1024);
    for (let k = 0; k < 8; k++) {
      const lamp = new T.PointLight(0xffcc88, 300, 25);
      // Along the street of the walk, and in streets beside it.
      lamp.position.set(k % 2 ? 0 : (k % 4 ? -60 : 60), 5, 50 - 30 * k);
      lamp.castShadow = true;
      lamp.shadow.mapSize.set(512, 512);
      made.scene.add(lamp);
    }
    return made;
  },

  // Walls in a batch hide what is behind them: balls of the same batch, and meshes; until walls go, move, or are other shapes.
  batchedTown(T, size) {
    const { scene, camera } = stage(T, size);
    ground(T, scene);
    const next = random(41);
    const mesh = new T.BatchedMesh(640, 800, 3200, new T.MeshLambertMaterial());
    const [wall, ball, cone] = [new T.BoxGeometry(6, 8, 0.5), new T.SphereGeometry(0.6, 10, 8), new T.ConeGeometry(0.6, 1.4, 8)].map((g) => mesh.addGeometry(g, 120, 500));
    const walls = [];
    const put = (shape, x, y, z) => { const id = mesh.addInstance(shape); mesh.setMatrixAt(id, dummyMatrix(T, x, y, z)); mesh.setColorAt(id, colour(T, next)); return id; };
    for (let x = -24; x <= 24; x += 6) walls.push(put(wall, x, 4, -12));
    for (let k = 0; k < 500; k++) put(k % 2 ? ball : cone, (next() - 0.5) * 60, 0.7 + 3 * next(), -14 - 30 * next());
    for (let k = 0; k < 60; k++) put(ball, (next() - 0.5) * 20, next() * 6, -6 - 5 * next());
    scene.add(mesh);
    for (let k = 0; k < 100; k++) {
      const cube = new T.Mesh(new T.BoxGeometry(), new T.MeshLambertMaterial({ color: colour(T, next) }));
      cube.position.set((next() - 0.5) * 50, 1, -15 - 20 * next());
      scene.add(cube);
    }
    camera.rotation.set(0, 0, 0);
    return {
      scene, camera, steps: 7,
      step(i) {
        if (i === 0) camera.position.x = 2;
        if (i === 1) mesh.setMatrixAt(walls[3], dummyMatrix(T, -6, 14, -12));
        if (i === 2) { mesh.setVisibleAt(walls[5], false); mesh.setVisibleAt(walls[3], false); }
        if (i === 3) { mesh.setVisibleAt(walls[5], true); mesh.setGeometryIdAt(walls[4], ball); }
        if (i === 4) { mesh.deleteInstance(walls[2]); put(ball, 0, 3, -8); }
        if (i === 5) mesh.setGeometryAt(wall, new T.BoxGeometry(2, 8, 0.5));
        if (i === 6) { mesh.position.y = -2; mesh.material.transparent = true; mesh.material.opacity = 0.5; mesh.material.needsUpdate = true; }
      },
    };
  },

  // A town under a sun and eight lamps: few of their shadows are seen at once.
  lamps(T, size) {
    const { scene, camera, turn } = stage(T, size, { light: false });
    ground(T, scene);
    const list = meshes(T, scene, 220, { shadow: true, seed: 13 });
    const trees = instanced(T, 150, 15);
    const cars = batched(T, 100, new T.MeshLambertMaterial(), 17);
    for (const mesh of [trees, cars]) { mesh.castShadow = mesh.receiveShadow = true; scene.add(mesh); }
    const next = random(19);
    const sun = new T.DirectionalLight(0xffffff, 1);
    sun.position.set(30, 60, 20);
    Object.assign(sun.shadow.camera, { left: -70, right: 70, top: 70, bottom: -70, near: 1, far: 200 });
    const lights = [sun];
    for (let k = 0; k < 8; k++) {
      const lamp = k < 6 ? new T.PointLight(0xffaa66, 400, 22) : new T.SpotLight(0xaaccff, 2000, 45, 0.6, 0.3);
      lamp.position.set((next() - 0.5) * 120, 6, (next() - 0.5) * 120);
      if (k === 0) lamp.position.set(3, 7, -12);
      // Its light goes beyond its shadows.
      if (k === 1) { lamp.position.set(-4, 7, 10); lamp.distance = 0; lamp.decay = 0.7; lamp.intensity = 20; lamp.shadow.camera.far = 20; }
      if (k > 5) { lamp.position.y = 20; lamp.target.position.copy(lamp.position).setY(0); scene.add(lamp.target); }
      lights.push(lamp);
    }
    for (const light of lights) { light.castShadow = true; light.shadow.mapSize.set(128, 128); light.shadow.normalBias = 0.05; scene.add(light); }
    scene.add(new T.AmbientLight(0xffffff, 0.3));
    const plan = new T.OrthographicCamera(-14, 14, 9, -9, 1, 100);
    plan.position.set(30, 50, 30);
    plan.lookAt(30, 0, 30);
    const made = {
      scene, camera, steps: 12, lights,
      step(i) {
        if (i === 0) turn(2.4);
        // Casters come from where they were not seen.
        if (i === 1) for (let k = 0; k < 120; k++) list[k].position.multiplyScalar(0.35);
        if (i === 2) { lights[2].position.x += 60; sun.position.set(-40, 50, 10); for (const lamp of lights.slice(1)) { lamp.position.x += 9; lamp.target?.position.copy(lamp.position).setY(0); } }
        // Away, and meanwhile all is other; then back.
        if (i === 3) { camera.position.set(70, 4, 70); turn(-2.2); }
        if (i === 4) { for (const mesh of list) mesh.position.x += 3; for (const lamp of lights.slice(1)) { lamp.position.z -= 6; lamp.target?.position.copy(lamp.position).setY(0); } for (let k = 0; k < 40; k++) { trees.setMatrixAt(k, dummyMatrix(T, (k % 8) * 3 - 12, 2, -8 - 3 * Math.floor(k / 8))); cars.setMatrixAt(k, dummyMatrix(T, (k % 8) * 3 - 11, 1, -7 - 3 * Math.floor(k / 8))); } trees.instanceMatrix.needsUpdate = true; }
        if (i === 5) { camera.position.set(0, 3, 0); turn(0.1); }
        // No map is drawn from now on, so all of them must be whole.
        if (i === 6) for (const light of lights) light.shadow.autoUpdate = false;
        if (i === 7) turn(2);
        if (i === 8) turn(4);
        if (i === 9) for (const light of lights) light.shadow.autoUpdate = true;
        if (i === 10) made.camera = plan;
        if (i === 11) { plan.position.x = -25; list[0].material.side = T.DoubleSide; for (const mesh of list) mesh.position.y += 1; }
      },
    };
    return made;
  },

  // A building cut open by planes: of the renderer and of materials in WebGL, of a group in WebGPU.
  section(T, size) {
    const { scene, camera } = stage(T, size);
    ground(T, scene);
    const next = random(6);
    const isGL = t.renderer.isWebGLRenderer;
    const root = isGL ? new T.Group() : new T.ClippingGroup();
    scene.add(root);
    const [box, ball] = [new T.BoxGeometry(), new T.SphereGeometry(0.6, 12, 8)];
    const paint = Array.from({ length: 95 }, () => new T.MeshLambertMaterial({ color: colour(T, next), side: T.DoubleSide }));
    const put = (x, y, z, w, h, d, material, shape = box) => {
      const mesh = new T.Mesh(shape, material);
      mesh.position.set(x, y, z);
      mesh.scale.set(w, h, d);
      root.add(mesh);
    };
    const walls = new T.InstancedMesh(box, paint[4], 5 * 8);
    for (let floor = 0; floor < 5; floor++) {
      put(0, floor * 3, 0, 16, 0.2, 16, paint[0]);
      for (let k = 0; k < 8; k++) {
        const along = k < 4 ? -6 + 4 * k : 0;
        const across = k < 4 ? 0 : -6 + 4 * (k - 4);
        walls.setMatrixAt(8 * floor + k, new T.Matrix4().makeScale(k < 4 ? 0.2 : 16, 2.8, k < 4 ? 16 : 0.2).setPosition(along, floor * 3 + 1.5, across));
      }
      for (let k = 0; k < 40; k++) put((next() - 0.5) * 15, floor * 3 + 0.5, (next() - 0.5) * 15, 0.3 + next(), 0.8, 0.3 + next(), paint[5 + Math.floor(90 * next())], ball);
    }
    root.add(walls);
    for (const side of [-1, 1]) { put(8 * side, 7, 0, 0.3, 15, 16, paint[3]); put(0, 7, 8 * side, 16, 15, 0.3, paint[3]); }
    put(90, 1, 90, 1, 1, 1, paint[0], ball);
    meshes(T, scene, 80);
    camera.position.set(24, 14, 26);
    camera.lookAt(0, 6, 0);
    const planes = [new T.Plane(new T.Vector3(-1, 0, 0), 3), new T.Plane(new T.Vector3(0, 0, -1), 2)];
    const clip = (list, isIntersection) => {
      if (!isGL) { root.clippingPlanes = list; root.clipIntersection = isIntersection; return; }
      t.renderer.localClippingEnabled = true;
      t.renderer.clippingPlanes = isIntersection ? [] : list;
      for (const material of paint) { material.clippingPlanes = isIntersection ? list : null; material.clipIntersection = isIntersection; material.needsUpdate = true; }
    };
    clip([planes[0]], false);
    return {
      scene, camera, root, steps: 5, end: () => { if (isGL) { t.renderer.clippingPlanes = []; t.renderer.localClippingEnabled = false; } },
      step(i) {
        if (i === 0) planes[0].constant = -2.5;
        if (i === 1) clip(planes, true);
        if (i === 2) planes[1].constant = -5;
        if (i === 3) { planes[1].constant = 1; clip([planes[1], planes[0]], false); }
        // Cuts nothing: the outer walls hide all again.
        if (i === 4) { planes[0].constant = planes[1].constant = 50; camera.position.set(26, 12, 20); camera.lookAt(0, 6, 0); }
      },
    };
  },

  // A thousand meshes: houses of a town with what stands in its streets.
  town(T, size) {
    const { scene, camera } = stage(T, size);
    ground(T, scene);
    const put = placer(T, scene, 61);
    const { next } = put;
    for (let x = 0; x < 12; x++) {
      for (let z = 0; z < 12; z++) {
        const [cx, cz, height] = [16 * (x - 5.5), 16 * (z - 5.5), 5 + 6 * next()];
        put('box', cx, height / 2, cz, 10, height, 10);
        put('cone', cx, height + 1.5, cz, 12, 3, 12);
        for (let k = 0; k < 3; k++) put('box', cx - 6.5, 0.6, cz - 5 + 4 * k + next(), 1.7, 1.2, 3.6);
        for (let k = 0; k < 2; k++) put('ball', cx - 4 + 8 * k, 2, cz - 6.5, 1.6, 3, 1.6);
      }
    }
    camera.position.set(0, 1.7, 88);
    camera.rotation.set(0, 0, 0);
    return { scene, camera, steps: 4, step(i) { camera.position.z -= 20; camera.rotation.y = [0.5, -0.7, 1.2, 0][i]; } };
  },

  // A thousand meshes: rooms of an office along corridors, with doors, desks and what is on them.
  office(T, size) {
    const { scene, camera } = stage(T, size);
    ground(T, scene);
    const put = placer(T, scene, 67);
    const { next } = put;
    put('box', 0, 3.1, 0, 62, 0.2, 40);
    // Six rows of ten rooms, a corridor between each two.
    for (let row = 0; row < 6; row++) {
      const z = 5 * row - 12.5 + 2.5 * Math.floor(row / 2) - 2.5;
      const door = row % 2 ? -2.5 : 2.5;
      put('box', 0, 1.5, z - door, 60, 3, 0.15);
      for (let room = 0; room < 10; room++) {
        const x = 6 * room - 27;
        put('box', x - 3, 1.5, z, 0.15, 3, 5);
        put('box', x + 0.5, 1.5, z + door, 5, 3, 0.15);
        for (let desk = 0; desk < 3; desk++) {
          const [dx, dz] = [x - 1.8 + 1.8 * desk, z - Math.sign(door) * 1.2];
          put('box', dx, 0.72, dz, 1.4, 0.06, 0.8);
          put('box', dx, 1, dz, 0.5, 0.35, 0.05);
          put('box', dx, 0.45, dz + 0.9 * Math.sign(door), 0.5, 0.9, 0.5);
          put('ball', dx + 0.5, 0.85, dz, 0.15, 0.25, 0.15);
        }
        for (let k = 0; k < 2; k++) put('ball', x + 4 * next() - 2, 0.5, z + next(), 0.4, 1, 0.4);
      }
    }
    put('box', 30, 1.5, 0, 0.15, 3, 40);
    camera.position.set(-29, 1.6, -8.75);
    camera.rotation.set(0, -Math.PI / 2, 0, 'YXZ');
    return { scene, camera, steps: 4, step(i) { camera.position.x += [8, 8, 6, 12][i]; camera.position.z += [0, -3.5, 0, 3.5][i]; camera.rotation.y -= [0.2, 1.2, 2.2, 3][i]; } };
  },
};

// Puts single meshes of three shapes into a scene.
function placer(T, scene, seed) {
  const next = random(seed);
  const shapes = { box: new T.BoxGeometry(), ball: new T.SphereGeometry(0.5, 12, 8), cone: new T.ConeGeometry(0.7, 1, 4) };
  const materials = Array.from({ length: 8 }, () => new T.MeshLambertMaterial({ color: colour(T, next) }));
  const put = (shape, x, y, z, w, h, d) => {
    const mesh = new T.Mesh(shapes[shape], materials[Math.floor(8 * next())]);
    mesh.position.set(x, y, z);
    mesh.scale.set(w, h, d);
    scene.add(mesh);
  };
  return Object.assign(put, { next });
}
