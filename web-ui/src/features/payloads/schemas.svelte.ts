// The schemas of the plugins: asked for once, and again when a plugin or a version turns up that is not known.

import { getPlugins } from '../../protocol/rest';
import type { PluginInfo } from '../../protocol/types';

/** Not asked again sooner than this. */
const AGAIN_MS = 5000;

export class Schemas {
  #plugins = $state.raw<ReadonlyMap<string, PluginInfo>>(new Map());
  #askedAt = -Infinity;

  /** The plugin of this name, if its version is the one that runs. */
  of(name: string, version: string): PluginInfo | undefined {
    const found = this.#plugins.get(name);
    return found?.version === version ? found : undefined;
  }

  /** Asks if one of these is not known. */
  async want(wanted: readonly { plugin: string; version: string }[]): Promise<void> {
    const missing = wanted.some(({ plugin, version }) => !this.of(plugin, version));
    if (!missing || performance.now() - this.#askedAt < AGAIN_MS) return;
    this.#askedAt = performance.now();
    try {
      this.#plugins = new Map((await getPlugins()).plugins.map((plugin) => [plugin.name, plugin]));
    } catch {
      // Asked again with the next look; until then the panel has no forms.
    }
  }
}
