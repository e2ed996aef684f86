// Taken by tsc --strict where the types know `Symbol.dispose`.
import { BoxSet, init, Scene } from 'cullet';
import { Scene as FileScene } from 'cullet/files';

await init();
using set = new BoxSet(1);
using scene = new Scene();
using view = scene.view();
using opened = FileScene.open(new ArrayBuffer(1));
console.log(set.length, view.cull().length, opened.instanceCount);
