// The REST side: one function per call, typed bodies, one error type. Must never retry: a command sent twice is two commands.

import type {
  CommandBody, CommandReceipt, CommandReceipts, ErrorBody, EventList, FormationReceipt, FormationRequest, Route, RouteBody,
  Targets, VehicleCommand, VehicleSnapshot,
} from './types';

/** A call that was answered with an error, or not at all (`status` 0). */
export class ApiError extends Error {
  override name = 'ApiError';
  constructor(
    readonly status: number,
    readonly code: string,
    message: string,
  ) {
    super(message);
  }
}

const TIMEOUT_MS = 8000;

async function call(method: string, path: string, body?: unknown): Promise<Response> {
  const init: RequestInit = { method, signal: AbortSignal.timeout(TIMEOUT_MS), cache: 'no-store' };
  if (body !== undefined) {
    init.body = JSON.stringify(body);
    init.headers = { 'content-type': 'application/json' };
  }
  let response: Response;
  try {
    response = await fetch(new URL(`api/v1/${path}`, document.baseURI), init);
  } catch (error) {
    const timedOut = error instanceof DOMException && error.name === 'TimeoutError';
    throw new ApiError(0, timedOut ? 'timeout' : 'unreachable', timedOut ? 'no answer from the server' : 'the server cannot be reached');
  }
  if (!response.ok) throw await errorOf(response);
  return response;
}

async function errorOf(response: Response): Promise<ApiError> {
  try {
    const { error } = (await response.json()) as ErrorBody;
    return new ApiError(response.status, error.code, error.message);
  } catch {
    return new ApiError(response.status, 'http', `the server answered ${response.status}`);
  }
}

export async function sendCommand(targets: Targets, command: VehicleCommand): Promise<CommandReceipt[]> {
  const body: CommandBody = { targets, command };
  return ((await (await call('POST', 'commands', body)).json()) as CommandReceipts).receipts;
}

export async function putFormation(request: FormationRequest): Promise<FormationReceipt> {
  return (await (await call('PUT', 'formation', request)).json()) as FormationReceipt;
}

export async function endFormation(): Promise<void> {
  await call('DELETE', 'formation');
}

export async function putRoute(route: Route): Promise<void> {
  const body: RouteBody = { route };
  await call('PUT', 'formation/route', body);
}

/** One vehicle, whole. */
export async function getVehicle(id: number): Promise<VehicleSnapshot> {
  return (await (await call('GET', `vehicles/${id}`)).json()) as VehicleSnapshot;
}

/** A command to a payload, as its plugin's command schema has it. */
export async function commandPayload(vehicle: number, payload: string, command: object): Promise<void> {
  await call('POST', `vehicles/${vehicle}/payloads/${encodeURIComponent(payload)}/command`, command);
}

/** Starts the plugin of a payload, or with null that of the vehicle itself, anew. */
export async function restartPlugin(vehicle: number, payload: string | null): Promise<void> {
  const what = payload === null ? 'model' : `payloads/${encodeURIComponent(payload)}`;
  await call('POST', `vehicles/${vehicle}/${what}/restart`);
}

/** Where the last frame of a camera is; `count` makes the address new, so that the browser asks again. */
export function pictureUrl(vehicle: number, payload: string, count: number): string {
  return new URL(`api/v1/vehicles/${vehicle}/payloads/${encodeURIComponent(payload)}/frame?n=${count}`, document.baseURI).href;
}

/** Events after a sequence number, oldest first, as far back as the server keeps them. */
export async function getEvents(after: number): Promise<EventList> {
  return (await (await call('GET', `events?after=${after}`)).json()) as EventList;
}

/** Round trip of a small request in ms: the latency between this page and the server. */
export async function measureLatencyMs(): Promise<number> {
  const from = performance.now();
  await call('GET', 'version');
  return performance.now() - from;
}
