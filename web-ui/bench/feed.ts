// Where the vehicles of a measurement come from: the real program as far as it goes, the made-up swarm beyond.

import { spawn } from 'node:child_process';
import { once } from 'node:events';
import { resolve } from 'node:path';
import { Program, freePort } from '../e2e/program';

/** The demo takes as many. */
const DEMO = 100;
/** One node flies as many as there are system ids. */
const NODE = 250;

export type Feed = { url: string; what: string; isMadeUp: boolean; stop(): Promise<void> };

export async function feed(vehicles: number): Promise<Feed> {
  if (vehicles <= NODE) {
    const program = await (vehicles <= DEMO ? Program.start(vehicles) : Program.crowd(vehicles));
    return { url: program.url, what: 'the real program', isMadeUp: false, stop: () => program.stop() };
  }
  const port = await freePort();
  const script = resolve(import.meta.dirname, '../dev/swarm.mjs');
  const child = spawn(process.execPath, [script, `${vehicles}`], { env: { ...process.env, PORT: `${port}` }, stdio: ['pipe', 'pipe', 'inherit'] });
  await once(child.stdout, 'data');
  return {
    url: `http://127.0.0.1:${port}`,
    what: 'a made-up swarm',
    isMadeUp: true,
    stop: async () => {
      child.kill();
      await once(child, 'exit');
    },
  };
}
