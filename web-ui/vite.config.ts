// Build and unit-test set-up. The result goes into `dist`, which the Rust program embeds: URLs are relative, nothing is
// inlined (the page runs under `default-src 'self'`, so no data: URL and no inline script would be let through).
import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { brotliCompressSync, gzipSync } from 'node:zlib';
import { svelte } from '@sveltejs/vite-plugin-svelte';
import type { Plugin } from 'vite';
import { defineConfig } from 'vitest/config';

/** Where `vite` sends the API during development; `npm run dev:swarm` or a real `skein run` listens there. */
const backend = process.env.SKEIN_BACKEND ?? 'http://127.0.0.1:8080';

/** Leaves out the decoders of GeoTIFF that are WebAssembly: the policy lets none run, and they would be 180 kB in the program. */
const withoutWebAssembly: Plugin = {
  name: 'without-webassembly',
  enforce: 'pre',
  resolveId: (source, importer) => (importer?.includes('/geotiff/') && /^\.\/(zstd|lerc)\.js$/.test(source) ? '\0absent-decoder' : null),
  load: (id) => (id === '\0absent-decoder' ? 'export default null; export const zstd = { init: async () => {} };' : null),
};

/** A file that hardly becomes smaller is sent as it is. */
const WORTH_IT = 0.9;

/** Lays `name.br` and `name.gz` beside what the build wrote: the program sends them as they lie and packs nothing itself. Gzip as well, since a browser
 *  takes brotli over plain HTTP from its own machine only. */
const compressed: Plugin = {
  name: 'compressed',
  apply: 'build',
  writeBundle: {
    order: 'post',
    handler({ dir }, bundle) {
      for (const name of Object.keys(bundle)) {
        const file = join(dir ?? '', name);
        const plain = readFileSync(file);
        for (const [ending, packed] of [['br', brotliCompressSync(plain)], ['gz', gzipSync(plain, { level: 9 })]] as const) {
          if (packed.length < plain.length * WORTH_IT) writeFileSync(`${file}.${ending}`, packed);
        }
      }
    },
  },
};

/** Makes a file of its own of `app/early` and has it run as soon as it is there: what belongs to one page otherwise becomes one file. */
const early: Plugin = {
  name: 'early',
  apply: 'build',
  buildStart() {
    this.emitFile({ type: 'chunk', id: 'src/app/early.ts', name: 'early' });
  },
  transformIndexHtml: {
    order: 'post',
    handler: (_, { bundle = {} }) =>
      Object.values(bundle)
        .filter((file) => file.type === 'chunk' && file.name === 'early' && file.isEntry)
        .map(({ fileName }) => ({ tag: 'script', attrs: { type: 'module', async: true, crossorigin: true, src: `./${fileName}` }, injectTo: 'head-prepend' })),
  },
};

export default defineConfig({
  base: './',
  plugins: [svelte(), early, compressed],
  build: {
    outDir: 'dist',
    emptyOutDir: true,
    assetsInlineLimit: 0,
    modulePreload: { polyfill: false },
    // What `app/early` needs, without the framework.
    rolldownOptions: { output: { codeSplitting: { groups: [{ name: 'first', test: /preload-helper|src\/(app\/remembered|language\/choice|model\/tab|protocol\/(early|streamUrl))\.ts/ }] } } },
    target: 'es2022',
    reportCompressedSize: true,
    // three.js, loaded only by whom looks at the view in space, is one file of 540 kB (136 kB compressed).
    chunkSizeWarningLimit: 600,
  },
  // A GeoTIFF is read by a worker, a file of its own origin like every other; in this format its decoders are fetched one by one.
  worker: { format: 'es', plugins: () => [withoutWebAssembly] },
  server: { host: '127.0.0.1', proxy: { '/api': { target: backend, ws: true } } },
  // The colours are read from the style sheet itself. Files share a process: each in its own took 90 s instead of 14. What a test changes outside of itself it puts back.
  test: { include: ['src/**/*.test.ts'], environment: 'node', css: true, isolate: false },
});
