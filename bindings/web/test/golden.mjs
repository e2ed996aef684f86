// The shared answers, held against this package: the same in Node and in a page.

/** Compares one scene with its answers; throws at the first that differs. Returns how many views there were. */
export function compare(Scene, bytes, { name, file, instances, views }) {
  const scene = Scene.open(bytes, file);
  if (scene.instanceCount !== instances) throw new Error(`${name}: ${scene.instanceCount} instances, not ${instances}`);
  views.forEach(({ clip_from_world: matrix, viewport, preset, visible, funnel }, i) => {
    const view = scene.view({ preset, depth: 'reversed' }).setCamera(matrix, ...viewport);
    const same = (what, ours, theirs) => {
      if (JSON.stringify(ours) !== JSON.stringify(theirs)) throw new Error(`${name}, view ${i} (${preset}): ${what} is ${JSON.stringify(ours).slice(0, 200)}, not ${JSON.stringify(theirs).slice(0, 200)}`);
    };
    same('visible', [...view.cull()], visible);
    const counts = (c) => [c.instances, c.clusters, c.triangles];
    same('funnel', view.funnel().map((row) => ({ stage: row.stage, unit: row.unit, in: counts(row.entered), out: counts(row.left) })), funnel);
    // Again from what it remembers.
    same('visible, the second time', [...view.cull()], visible);
    view.dispose();
  });
  scene.dispose();
  return views.length;
}
