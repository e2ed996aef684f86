// Taken by tsc --strict: what a user writes, and what is to be refused.
import { CullingPlugin, init, type CullingPluginOptions } from 'cullet/tiles';

await init();
const options: CullingPluginOptions = { horizon: true, lowest: -11500, preset: 'fast', ahead: 0, occludes: (mesh) => mesh.name !== 'glass' };
const plugin = new CullingPlugin(options);
const share: number = plugin.stats.hidden / plugin.stats.tested;
// @ts-expect-error: counts are not to be set
plugin.stats.hidden = share;
// @ts-expect-error: no such preset
new CullingPlugin({ preset: 'best' });
plugin.dispose();
