// The REST side: one function per call, typed bodies, one error type. Must never retry: a command sent twice is two commands.

import { t } from '../language/language.svelte';

import type {
  AcknowledgeBody, AutopilotLogList, CameraViewList, CommandBody, CommandReceipt, CommandReceipts, Console, ControlAction, ControlBody, ControlReceipt, ControlReceipts, EmergencyKey,
  EmergencyStopBody, ErrorBody, EventList, FenceAnswer, FenceFileBody, FencePlan, FencePlanBody, FlightList, FormationPreview, FormationReceipt, FormationRequest, ImportedFencePlan, LogFetch, LogFetchAnswer, OverrideBody, ParameterBody,
  ParameterList, ParameterReceipt, PreflightAnswer, PluginList, PreflightOverride, ReadingAction, ReadingBody, ReferenceList, ReferenceSnapshot, ResumeBody, RestartList, RestartRecord, Route, RouteBody, SupervisionTree, Targets,
  RecordedFlight, ReplayChange, ReplayState, Timeline, UpgradeReceipt, VehicleCommand, VehicleSnapshot, LinkReport, AskedObserver, AskedObserverList, ObserveRequest, ObserverList, ObserverProposal,
  PayloadList, PayloadSnapshot, TrackChangeBody,
} from './types';
import { videoPath } from './video';
import type { Recording, RecordingList, RecordingReceipt, VideoAddress, VideoQuality, VideoStreamList, VideoStreamView } from './video';

/** A call that was answered with an error, or not at all (`status` 0). */
export class ApiError extends Error {
  override name = 'ApiError';
  constructor(
    readonly status: number,
    readonly code: string,
    message: string,
    /** The facts that go with the code, as the server has them. */
    readonly detail: unknown = null,
  ) {
    super(message);
  }
}

const TIMEOUT_MS = 8000;

/** The console that calls come from. */
let caller: string | null = null;

/** From now on every call says which console it comes from. */
export function callAs(console: string): void {
  caller = console;
}

/** A body that is no JSON: what a browser offers to receive. */
class Sdp {
  constructor(readonly text: string) {}
}

/** `path` is below the API's, or a whole address. */
async function call(method: string, path: string | URL, body?: unknown, secret?: string): Promise<Response> {
  const headers: Record<string, string> = {};
  if (caller !== null) headers['skein-console'] = caller;
  const init: RequestInit = { method, headers, signal: AbortSignal.timeout(TIMEOUT_MS), cache: 'no-store' };
  if (body instanceof Sdp) {
    init.body = body.text;
    headers['content-type'] = 'application/sdp';
  } else if (body !== undefined) {
    init.body = JSON.stringify(body);
    headers['content-type'] = 'application/json';
    if (secret !== undefined) headers.authorization = `Bearer ${secret}`;
  }
  let response: Response;
  try {
    response = await fetch(path instanceof URL ? path : new URL(`api/v1/${path}`, document.baseURI), init);
  } catch (error) {
    const timedOut = error instanceof DOMException && error.name === 'TimeoutError';
    throw new ApiError(0, timedOut ? 'timeout' : 'unreachable', timedOut ? t('no answer from the server') : t('the server cannot be reached'));
  }
  if (!response.ok) throw await errorOf(response);
  return response;
}

async function errorOf(response: Response): Promise<ApiError> {
  try {
    const { error } = (await response.json()) as ErrorBody;
    return new ApiError(response.status, error.code, error.message, error.detail);
  } catch {
    return new ApiError(response.status, 'http', t('the server answered {status}', { status: response.status }));
  }
}

export async function sendCommand(targets: Targets, command: VehicleCommand): Promise<CommandReceipt[]> {
  const body: CommandBody = { targets, command };
  return ((await (await call('POST', 'commands', body)).json()) as CommandReceipts).receipts;
}

/** Takes control authority over vehicles, asks for it, releases it, hands it over. */
export async function changeControl(vehicles: readonly number[], console: Console, action: ControlAction): Promise<ControlReceipt[]> {
  const body: ControlBody = { targets: { vehicles: [...vehicles] }, console, action };
  return ((await (await call('POST', 'control', body)).json()) as ControlReceipts).receipts;
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

/** Where the places of a formation would be about its anchor; nothing is flown. */
export async function previewFormation(request: FormationRequest): Promise<FormationPreview> {
  return (await (await call('POST', 'formation/preview', request)).json()) as FormationPreview;
}

/** What moves and may anchor a formation. */
export async function getReferences(): Promise<ReferenceSnapshot[]> {
  return ((await (await call('GET', 'references')).json()) as ReferenceList).references;
}

export async function getPreflight(): Promise<PreflightAnswer> {
  return (await (await call('GET', 'preflight')).json()) as PreflightAnswer;
}

/** Takes red items upon the operator whose secret this is. */
export async function overridePreflight(body: OverrideBody, secret: string): Promise<PreflightOverride> {
  return (await (await call('POST', 'preflight/overrides', body, secret)).json()) as PreflightOverride;
}

export async function getFences(): Promise<FenceAnswer> {
  return (await (await call('GET', 'fences')).json()) as FenceAnswer;
}

/** Puts other fences in force. */
export async function putFences(plan: FencePlan): Promise<FenceAnswer> {
  const body: FencePlanBody = { plan };
  return (await (await call('PUT', 'fences', body)).json()) as FenceAnswer;
}

/** What a GeoJSON or a plan of QGroundControl says; nothing is put in force by it. */
export async function importFences(name: string, text: string): Promise<ImportedFencePlan> {
  const body: FenceFileBody = { name, text };
  return (await (await call('POST', 'fences/import', body)).json()) as ImportedFencePlan;
}

/** Where the fences in force are as GeoJSON. */
export function fencesFileUrl(): string {
  return new URL('api/v1/fences/geojson', document.baseURI).href;
}

/** The first step of the emergency stop. Stops nothing. */
export async function unlockEmergencyStop(): Promise<EmergencyKey> {
  return (await (await call('POST', 'emergency-stop/unlock')).json()) as EmergencyKey;
}

/** The second step: the motors of these vehicles stop at once. */
export async function emergencyStop(key: string, targets: Targets): Promise<CommandReceipt[]> {
  const body: EmergencyStopBody = { key, targets };
  return ((await (await call('POST', 'emergency-stop', body)).json()) as CommandReceipts).receipts;
}

/** A sign of life of the operator before this page. */
export async function operatorAlive(): Promise<void> {
  await call('POST', 'operator/alive');
}

/** Has a node take the leadership. */
export async function makeCoordinator(node: number): Promise<void> {
  await call('POST', 'swarm/coordinator', { node });
}

/** The answer after the node ended in flight and has started again: whether the vehicles that it took back fly on. */
export async function resume(flyOn: boolean): Promise<void> {
  const body: ResumeBody = { fly_on: flyOn };
  await call('POST', 'resume', body);
}

/** One vehicle, whole. */
export async function getVehicle(id: number): Promise<VehicleSnapshot> {
  return (await (await call('GET', `vehicles/${id}`)).json()) as VehicleSnapshot;
}

/** What is known of the parameters of a vehicle's autopilot and has changed since a revision; `read` begins the reading of all. */
export async function getParameters(vehicle: number, since: number, read: boolean): Promise<ParameterList> {
  return (await (await call('GET', `vehicles/${vehicle}/parameters?since=${since}&read=${read}`)).json()) as ParameterList;
}

/** Begins the reading of all parameters, or ends it. */
export async function readParameters(vehicle: number, action: ReadingAction): Promise<void> {
  const body: ReadingBody = { action };
  await call('POST', `vehicles/${vehicle}/parameters/reading`, body);
}

/** Writes a parameter; answered when the autopilot has said what it keeps. */
export async function putParameter(vehicle: number, name: string, value: number): Promise<ParameterReceipt> {
  const body: ParameterBody = { value };
  return (await (await call('PUT', `vehicles/${vehicle}/parameters/${encodeURIComponent(name)}`, body)).json()) as ParameterReceipt;
}

/** The logs on the card of a vehicle's autopilot, which is asked for them. */
export async function getAutopilotLogs(vehicle: number): Promise<AutopilotLogList> {
  return (await (await call('GET', `vehicles/${vehicle}/logs`)).json()) as AutopilotLogList;
}

/** Begins to fetch one of them to the node. */
export async function fetchAutopilotLog(vehicle: number, number: number): Promise<LogFetch> {
  return (await (await call('POST', `vehicles/${vehicle}/logs/${number}/fetch`)).json()) as LogFetch;
}

/** The log of a vehicle that is being fetched, or was last. */
export async function getLogFetch(vehicle: number): Promise<LogFetchAnswer> {
  return (await (await call('GET', `vehicles/${vehicle}/logs/fetch`)).json()) as LogFetchAnswer;
}

/** What a vehicle carries, with the state of each. */
export async function getPayloads(vehicle: number): Promise<PayloadSnapshot[]> {
  return ((await (await call('GET', `vehicles/${vehicle}/payloads`)).json()) as PayloadList).payloads;
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

/** The video streams that there are. */
export async function getVideo(): Promise<VideoStreamView[]> {
  return ((await (await call('GET', 'video')).json()) as VideoStreamList).streams;
}

/** Offers to receive a stream over WebRTC: what the node answers, and where what was begun is ended; null if it does not say. */
export async function offerVideo(of: VideoAddress, quality: VideoQuality, sdp: string): Promise<{ sdp: string; session: URL | null }> {
  const response = await call('POST', videoPath(of, `/whep?quality=${quality}`), new Sdp(sdp));
  const location = response.headers.get('location');
  return { sdp: await response.text(), session: location === null ? null : new URL(location, response.url) };
}

/** Ends what an offer began. */
export async function endVideo(session: URL): Promise<void> {
  await call('DELETE', session);
}

/** Records a stream on the node from now on, or ends that. */
export async function recordVideo(of: VideoAddress, on: boolean): Promise<RecordingReceipt> {
  return (await (await call(on ? 'POST' : 'DELETE', videoPath(of, '/recording'))).json()) as RecordingReceipt;
}

export async function getRecordings(): Promise<Recording[]> {
  return ((await (await call('GET', 'video/recordings')).json()) as RecordingList).recordings;
}

/** Where a recording is. */
export function recordingUrl(file: string): string {
  return new URL(`api/v1/video/recordings/${encodeURIComponent(file)}`, document.baseURI).href;
}

/** The recordings of flights that the node keeps, the newest first. */
export async function getFlights(): Promise<RecordedFlight[]> {
  return ((await (await call('GET', 'flights')).json()) as FlightList).flights;
}

/** Where the recording of a flight is, or the log of an autopilot beside it. */
export function flightUrl(file: string): string {
  return new URL(`api/v1/flights/${encodeURIComponent(file)}`, document.baseURI).href;
}

/** Where its report is: a page by itself. */
export function flightReportUrl(file: string): string {
  return `${flightUrl(file)}/report`;
}

/** Where it is shown again: this page, below an address of its own. */
export function flightReplayUrl(file: string): string {
  return new URL(`replay/${encodeURIComponent(file)}/`, document.baseURI).href;
}

/** Has a replay go to another moment, at another pace, go on or stand still. */
export async function changeReplay(change: ReplayChange): Promise<ReplayState> {
  return (await (await call('PUT', 'replay', change)).json()) as ReplayState;
}

/** What happened in the recording that is shown. */
export async function getTimeline(): Promise<Timeline> {
  return (await (await call('GET', 'replay/timeline')).json()) as Timeline;
}

/** Marks alerts as seen, for all pages. That they are comes as an event. */
export async function postAcknowledged(events: readonly number[]): Promise<void> {
  const body: AcknowledgeBody = { events: [...events] };
  await call('POST', 'events/acknowledge', body);
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

/** What went over the links of this node, and how each vehicle is heard. */
export async function getLinks(): Promise<LinkReport> {
  return (await (await call('GET', 'links')).json()) as LinkReport;
}

/** Where the cameras of all vehicles look, as far as that is known. */
export async function getCameraViews(): Promise<CameraViewList> {
  return (await (await call('GET', 'cameras/views')).json()) as CameraViewList;
}

/** Names a track or has it kept; what is null stays as it is. */
export async function changeTrack(track: number, change: TrackChangeBody): Promise<void> {
  await call('PATCH', `tracks/${track}`, change);
}

/** Ends a track. */
export async function dropTrack(track: number): Promise<void> {
  await call('DELETE', `tracks/${track}`);
}

/** Who could keep a track in view, the best placed first. */
export async function getObservers(track: number): Promise<ObserverProposal[]> {
  return ((await (await call('GET', `tracks/${track}/observers`)).json()) as ObserverList).observers;
}

/** Has vehicles keep a track in view; what each answered. */
export async function observeTrack(track: number, request: ObserveRequest): Promise<AskedObserver[]> {
  return ((await (await call('POST', `tracks/${track}/observe`, request)).json()) as AskedObserverList).asked;
}

/** What runs under supervision, and how it is. */
export async function getSupervision(): Promise<SupervisionTree> {
  return (await (await call('GET', 'supervision')).json()) as SupervisionTree;
}

/** Restarts after failures, oldest first. */
export async function getRestarts(): Promise<RestartRecord[]> {
  return ((await (await call('GET', 'plugins/restarts')).json()) as RestartList).restarts;
}

/** Takes a payload off a vehicle: its plugin instance ends. */
export async function detachPayload(vehicle: number, payload: string): Promise<void> {
  await call('DELETE', `vehicles/${vehicle}/payloads/${encodeURIComponent(payload)}`);
}

export async function getPlugins(): Promise<PluginList> {
  return (await (await call('GET', 'plugins')).json()) as PluginList;
}

/** Looks for new and changed libraries. */
export async function rescanPlugins(): Promise<PluginList> {
  return (await (await call('POST', 'plugins/rescan')).json()) as PluginList;
}

/** Exchanges all instances for the newest version, or for the one before. */
export async function exchangePlugin(name: string, to: 'upgrade' | 'rollback'): Promise<UpgradeReceipt> {
  return (await (await call('POST', `plugins/${encodeURIComponent(name)}/${to}`)).json()) as UpgradeReceipt;
}

/** Forgets a plugin that nothing uses. */
export async function removePlugin(name: string): Promise<void> {
  await call('DELETE', `plugins/${encodeURIComponent(name)}`);
}
