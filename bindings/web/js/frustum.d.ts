export { BoxSet, CulletError, init, type CulletErrorCode, type Numbers, type Source } from './core/boxes.js';
