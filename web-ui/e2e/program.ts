// Starts and ends the real program: simulated vehicles, a node that flies them, the dashboard it serves.

import { spawn } from 'node:child_process';
import { createSocket } from 'node:dgram';
import type { ChildProcess } from 'node:child_process';
import { copyFileSync, mkdtempSync, renameSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { once } from 'node:events';
import { dirname, join, resolve } from 'node:path';
import { createInterface } from 'node:readline';

const WEB_UI = resolve(import.meta.dirname, '..');
const BINARY = resolve(WEB_UI, process.env.SKEIN_BINARY ?? '../target/debug/skein');
const PLUGINS = resolve(WEB_UI, process.env.SKEIN_PLUGINS ?? join(dirname(BINARY), 'plugins'));
const START_MS = 60_000;

export async function freePort(): Promise<number> {
  const socket = createSocket('udp4');
  socket.bind(0, '127.0.0.1');
  await once(socket, 'listening');
  const { port } = socket.address();
  socket.close();
  return port;
}

/** Puts a library that the tests of the node are made with (`cargo build --workspace --all-targets`) into a folder of plugins, as a person
 *  installs it: beside, then over what is there in one step. */
export function install(example: string, folder: string): void {
  const beside = join(folder, 'new');
  copyFileSync(join(dirname(BINARY), 'examples', `lib${example}.so`), beside);
  renameSync(beside, join(folder, `lib${example}.so`));
}

export class Program {
  private constructor(
    private readonly process: ChildProcess,
    readonly url: string,
    /** What simulates its vehicles, where it does not do so itself. */
    private readonly simulator: ChildProcess | null = null,
  ) {}

  /** Starts it with vehicles on the ground; port 0 lets the system choose one. `more` are further arguments. */
  static async start(vehicles: number, port = 0, more: readonly string[] = []): Promise<Program> {
    return Program.#run(['demo', '--manual', '--vehicles', `${vehicles}`, '--port', `${port}`, '--plugins', PLUGINS, ...more]);
  }

  /** Starts a node without vehicles, with these lines of configuration. */
  static async node(lines: readonly string[]): Promise<Program> {
    const folder = mkdtempSync(join(tmpdir(), 'skein-'));
    const file = join(folder, 'node.toml');
    writeFileSync(file, [...lines, '[web]', 'listen = "127.0.0.1:0"', '[plugins]', `directories = [${JSON.stringify(PLUGINS)}]`].join('\n'));
    try {
      return await Program.#run(['run', '--config', file]);
    } finally {
      // read once, before the dashboard is there
      rmSync(folder, { recursive: true });
    }
  }

  /** Starts a node and simulated vehicles in a process of their own, as many as there are system ids: more than the demo takes. */
  static async crowd(vehicles: number): Promise<Program> {
    const port = await freePort();
    // What is looked at is the page: the node is not to take the machine for itself.
    const program = await Program.node([
      '[link]', 'position_rate_hz = 10.0', '[[endpoints]]', 'name = "crowd"', `address = "udp-listen://127.0.0.1:${port}"`,
      '[[adopt]]', 'name = "uav-{system_id}"', 'model = "generic-uav"',
    ]);
    const simulator = spawn(BINARY, ['sim', '--vehicles', `${vehicles}`, '--send-to', `127.0.0.1:${port}`], { stdio: 'ignore' });
    return new Program(program.process, program.url, simulator);
  }

  /** Starts simulated vehicles alone, which send to a port. Ends with the test run that started them, or when told. */
  static vehicles(count: number, firstId: number, sendTo: string): ChildProcess {
    return spawn(BINARY, ['sim', '--vehicles', `${count}`, '--first-system-id', `${firstId}`, '--at', `0,${firstId * 10}`, '--send-to', sendTo], { stdio: 'ignore' });
  }

  static async #run(args: readonly string[]): Promise<Program> {
    // Recordings go where nobody keeps his own.
    const env = { ...process.env, XDG_STATE_HOME: join(tmpdir(), 'skein-tests') };
    const child = spawn(BINARY, args, { stdio: ['ignore', 'pipe', 'pipe'], env });
    const said: string[] = [];
    child.stderr.on('data', (text: Buffer) => said.push(text.toString()));
    const url = await new Promise<string>((found, failed) => {
      const timer = setTimeout(() => failed(new Error(`no dashboard after ${START_MS} ms\n${said.join('')}`)), START_MS);
      child.once('error', (error) => failed(new Error(`${BINARY} cannot be started: ${error.message}`)));
      child.once('exit', (code) => failed(new Error(`${BINARY} ended with code ${code}\n${said.join('')}`)));
      createInterface({ input: child.stdout }).on('line', (line) => {
        said.push(`${line}\n`);
        const address = /^Dashboard: (http:\/\/\S+)/.exec(line)?.[1];
        if (!address) return;
        clearTimeout(timer);
        found(address);
      });
    });
    return new Program(child, url);
  }

  get port(): number {
    return Number(new URL(this.url).port);
  }

  /** Stands still, as a computer does that is overloaded: its connections stay, and nothing is said on them. */
  pause(): void {
    this.process.kill('SIGSTOP');
  }

  goOn(): void {
    this.process.kill('SIGCONT');
  }

  /** Ends it as an operator would, or at once. */
  async stop(signal: 'SIGINT' | 'SIGKILL' = 'SIGKILL'): Promise<void> {
    this.simulator?.kill('SIGKILL');
    if (this.process.exitCode !== null || this.process.signalCode !== null) return;
    const ended = once(this.process, 'exit');
    this.process.kill(signal);
    await ended;
  }
}
