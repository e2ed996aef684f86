// The record of `info` in words, as the program `cullet info` prints it.

const SHOWN = 20;

/** A number with narrow no-break spaces between groups of three digits. */
const grouped = (n) => String(n).replace(/\B(?=(\d{3})+$)/g, '\u202f');
const count = (n, one, many) => `${grouped(n)} ${n === 1 ? one : many}`;
/** Names come from files: without control characters they cannot command a terminal. */
const printable = (text) => text.replace(/\p{Cc}/gu, '\ufffd');

/** The lines of a record; `all` lists every mesh and warning, not only the first ones. */
export function lines(record, all = false) {
  const { scene, meshes } = record;
  const shown = all ? Infinity : SHOWN;
  const out = [printable(scene.name)];
  const row = (what, value) => out.push(`  ${what.padEnd(12)}${value}`);
  const more = (length) => { if (length > shown) out.push(`  and ${grouped(length - shown)} more; --all lists them`); };

  row('instances', grouped(scene.instances));
  row('meshes', scene.meshes === 1
    ? `1, ${scene.solids === 1 ? 'a solid' : 'not a solid'}`
    : `${grouped(scene.meshes)}, of which ${count(scene.solids, 'is a solid', 'are solids')}`);
  const polygons = scene.polygons === scene.triangles ? '' : ` from ${count(scene.polygons, 'polygon', 'polygons')}`;
  row('triangles', `${grouped(scene.triangles)}${polygons} (${grouped(scene.unique_triangles)} stored)`);
  if (scene.extent) {
    const [min, max] = scene.extent;
    row('size', `${max.map((v, axis) => (v - min[axis]).toFixed(3)).join(' × ')} (x × y × z)`);
  }
  row('materials', grouped(scene.materials));
  if (record.groups) {
    const { nodes, depth, widest, empty } = record.groups;
    row('node tree', `${count(nodes, 'node', 'nodes')}, ${depth} deep, at most ${grouped(widest)} in one; ${grouped(empty)} with nothing to draw below`);
  }
  if (record.cells > 0) row('cells', `${record.cells}, with ${count(record.portals, 'portal', 'portals')}`);
  if (record.cameras.length > 0) row('cameras', `${record.cameras.length}: ${record.cameras.slice(0, 8).map(printable).join(', ')}`);
  if (record.is_baked) row('baked', 'yes; the program `cullet` of the Python package or of a checkout lists it');

  const sum = (key) => meshes.reduce((all, mesh) => all + mesh[key], 0);
  const notes = [
    [record.mirrored_instances, 'instance is', 'instances are', 'mirrored'],
    [record.non_finite_instances, 'instance is', 'instances are', 'with a transform that is not finite'],
    [record.unbounded_instances, 'instance is', 'instances are', 'without finite bounds within ±1e18, and so kept in every view'],
    [record.singular_instances, 'instance is', 'instances are', 'scaled to nothing along an axis'],
    [sum('degenerate'), 'stored triangle has', 'stored triangles have', 'no area'],
    [sum('duplicate'), 'stored triangle is a duplicate', 'stored triangles are duplicates', 'of another'],
  ];
  for (const [n, one, many, what] of notes) if (n > 0) row('note', `${count(n, one, many)} ${what}`);

  const defects = meshes.filter((mesh) => mesh.defect !== null);
  if (defects.length > 0) {
    out.push('', `Meshes that are not solids (${grouped(defects.length)}):`);
    const listed = defects.slice(0, shown).map((mesh) => ({ ...mesh, name: printable(mesh.name) }));
    const width = Math.min(40, Math.max(...listed.map(({ name }) => [...name].length)));
    for (const mesh of listed) {
      const pad = ' '.repeat(Math.max(0, width - [...mesh.name].length));
      out.push(`  ${mesh.name}${pad}  ${count(mesh.triangles, 'triangle', 'triangles')}, ${mesh.sides}: ${mesh.defect}`);
    }
    more(defects.length);
  }
  if (scene.warnings.length > 0) {
    out.push('', `Warnings (${grouped(scene.warnings.length)}):`);
    for (const warning of scene.warnings.slice(0, shown)) out.push(`  ${printable(warning)}`);
    more(scene.warnings.length);
  }
  return out;
}
