// What other programs make of baked files: `node readers.mjs TRIANGLES FILE...`.
//
// The validator of Khronos must find neither errors nor warnings; three.js must read each mesh's triangles, as many as the
// baker counted, for what is baked is none of its business.
import { readFile } from 'node:fs/promises';
import process from 'node:process';
import validator from 'gltf-validator';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';

const [expected, ...files] = process.argv.slice(2);
let failed = files.length === 0;

/** Triangles of all meshes, each counted once however often it is placed. */
function triangles(scene) {
  const counts = new Map();
  scene.traverse(({ isMesh, geometry }) => {
    if (isMesh) counts.set(geometry.uuid, (geometry.index ?? geometry.attributes.position).count / 3);
  });
  return [...counts.values()].reduce((a, b) => a + b, 0);
}

function tell(file, name, message, isFine) {
  console.log(`${file}: ${name}: ${message}${isFine ? '' : ': FAILED'}`);
  failed ||= !isFine;
}

for (const file of files) {
  const bytes = new Uint8Array(await readFile(file));
  const { issues } = await validator.validateBytes(bytes, { maxIssues: 100 });
  const { numErrors, numWarnings, messages } = issues;
  tell(file, 'gltf-validator', `${numErrors} errors, ${numWarnings} warnings`, numErrors + numWarnings === 0);
  for (const { severity, code, message, pointer } of messages) {
    // 0 is an error, 1 a warning.
    if (severity < 2) console.log(`  ${code} at ${pointer}: ${message}`);
  }
  const { scene } = await new GLTFLoader().parseAsync(bytes.buffer, '');
  const found = triangles(scene);
  tell(file, 'three.js', `${found} triangles of ${expected}`, found === Number(expected));
}
process.exit(failed ? 1 : 0);
