// Development aid: speaks the dashboard's wire protocol for a made-up swarm. `npm run dev:swarm -- 6` beside `npm run dev`,
// or alone: it also serves `dist` under the same content security policy as the program. Must never be used by a test.
// Typed on standard input: `silence 3`, `hear 3`, `pilot 3`, `fault 3`, `drain 3`, `restart 3`; `grab 3`, `ask 3`, `drop 3` by another operator.
import { createServer } from 'node:http';
import { readFile } from 'node:fs/promises';
import { createInterface } from 'node:readline';
import { extname, join, normalize } from 'node:path';
import { WebSocketServer } from 'ws';
import { Vehicle, slotsOf } from './flight.mjs';

const count = Number(process.argv[2] ?? 6);
const port = Number(process.env.PORT ?? 8080);
const origin = { latitude_deg: 47.397742, longitude_deg: 8.545594, altitude_amsl_m: 488 };
const columns = Math.ceil(Math.sqrt(count));
const vehicles = Array.from({ length: count }, (_, k) => new Vehicle(k + 1, Math.floor(k / columns) * 4, (k % columns) * 4));
const project = (n, e) => [
  origin.latitude_deg + n / 111194.93,
  origin.longitude_deg + e / (111194.93 * Math.cos((origin.latitude_deg * Math.PI) / 180)),
];
const startedAt = Date.now();
const nodeTime = () => (Date.now() - startedAt) * 1000;
const events = [];
let sequence = 0;
let nextCommand = 1;
let formation = null;
let heading = 0;
const clients = new Set();

function say(vehicle, severity, kind, text) {
  const record = { seq: events.length + 1, time: nodeTime(), vehicle, severity, kind, text };
  events.push(record);
  for (const client of clients) client.send(JSON.stringify({ type: 'event', ...record }));
}

const health = (name, incarnation) => ({ name, status: 'running', incarnation, last_error: '', since: 0 });
function fleetInfo() {
  return {
    type: 'fleet', frame: { origin }, formation, faults_enabled: false, actors: [health('coordinator', 1)],
    dead_man: { state: process.env.DEAD_MAN ?? 'off', warns_after_s: process.env.DEAD_MAN ? 20 : null },
    resume: null,
    unadopted: [{ system_id: 99, endpoint: 'sitl', why: 'no adoption rule fits system id 99' }],
    vehicles: vehicles.map((v) => ({
      id: v.id, name: `uav-${v.id}`, system_id: v.id, plugin: 'generic-uav', plugin_version: '0.1.0', state_detail: '',
      home: { latitude_deg: project(...v.home)[0], longitude_deg: project(...v.home)[1], altitude_amsl_m: 488 },
      node: null, simulated: true, payloads: [], degraded: [],
      actor: health(`vehicle-${v.id}`, 1), model: health(`model-${v.id}`, v.model),
    })),
  };
}

function progress(v, step) {
  if (!v.command) return;
  const { id, name } = v.command;
  say(v.id, 'info', { kind: 'command', id, command: name, progress: step }, `${name} ${step.progress}`);
  if (step.progress !== 'executing') v.command = null;
}
const done = (v) => progress(v, { progress: 'done' });

function command(v, id, c, index) {
  const refuse = (refusal) => ({ vehicle: v.id, id, refusal });
  if (Date.now() - v.heardAt > 1500) return refuse({ reason: 'link_lost', vehicle: v.id });
  if (v.state === 'pilot_control') return refuse({ reason: 'pilot_in_control' });
  const ground = v.state === 'idle' || v.state === 'arming';
  if (ground !== ['arm', 'disarm', 'take_off'].includes(c.command)) return refuse({ reason: 'wrong_state', state: v.state, command: c.command });
  progress(v, { progress: 'refused', refusal: { reason: 'superseded' } });
  v.command = { id, name: c.command };
  setTimeout(() => progress(v, { progress: 'executing' }), 60);
  v.slot = null;
  if (c.command === 'take_off') Object.assign(v, { state: 'taking_off', armed: true, height: c.height_m, startAt: Date.now() + 300 + index * Math.min(400, 5000 / vehicles.length) });
  if (c.command === 'go_to') Object.assign(v, { state: 'going_to', goal: [c.position.north_m, c.position.east_m, -c.position.down_m] });
  if (c.command === 'arm') Object.assign(v, { state: 'arming', armed: true, startAt: Date.now() + 500 });
  if (c.command === 'disarm') Object.assign(v, { state: 'idle', armed: false }), setTimeout(() => done(v), 200);
  if (c.command === 'land') v.state = 'landing';
  if (c.command === 'return') Object.assign(v, { state: 'returning', goal: [...v.home, v.up] });
  if (c.command === 'hold') v.enter('holding', (x) => setTimeout(() => done(x), 150));
  return { vehicle: v.id, id, refusal: null };
}

function form(request) {
  const able = vehicles.filter((v) => ['holding', 'following', 'leading', 'going_to'].includes(v.state));
  const members = request.members ? able.filter((v) => request.members.includes(v.id)) : able;
  if (members.length < 2) return { code: 'not_enough_vehicles', message: `${members.length} vehicles are available, 2 are needed` };
  if (request.spacing_m < 2.8) return { code: 'too_close', message: `${request.spacing_m} m from vehicle 2, under the limit of 2.8 m` };
  const leader = members.find((v) => v.id === request.leader) ?? members[0];
  const ordered = [leader, ...members.filter((v) => v !== leader)];
  if (request.heading.kind === 'fixed') heading = (request.heading.heading_deg * Math.PI) / 180;
  for (const v of vehicles) Object.assign(v, { leader: v === leader, slot: null });
  for (const v of ordered) v.state = v === leader ? 'leading' : 'following';
  leader.goal = [leader.north, leader.east, leader.up];
  formation = {
    request: { ...request, leader: leader.id }, leader: leader.id, members: ordered.map((v) => v.id), route: null, route_finished: false,
    anchor: null, keeps_itself: false, max_speed_m_s: 5, settled_at: nodeTime() + 6e6, planned_min_distance_m: 4.2, intent_version: (formation?.intent_version ?? 0) + 1,
  };
  say(null, 'info', { kind: 'formation' }, `formation ${request.shape}, leader ${leader.id}`);
  return { leader: leader.id, members: formation.members, duration_s: 6, planned_min_distance_m: 4.2, max_speed_m_s: 5 };
}

function step(dt) {
  if (formation) {
    const members = formation.members.map((id) => vehicles[id - 1]);
    const leader = members[0];
    const next = formation.route?.waypoints[formation.leg];
    if (next && leader.state === 'leading') {
      leader.goal = [next.north_m, next.east_m, -next.down_m];
      if (Math.hypot(leader.north - next.north_m, leader.east - next.east_m) < 2) formation.leg++;
      if (formation.leg === formation.route.waypoints.length) formation.route_finished = true;
      if (formation.request.heading.kind !== 'fixed') {
        const turn = Math.atan2(Math.sin(leader.yaw - heading), Math.cos(leader.yaw - heading));
        heading += Math.max(-0.3 * dt, Math.min(0.3 * dt, turn));
      }
    }
    const slots = slotsOf(formation.request.shape, members.length, formation.request.spacing_m, formation.request.altitude_step_m);
    members.forEach((v, k) => {
      if (v.state !== 'following') return;
      const [f, r, u] = slots[k];
      v.slot = [
        leader.north + f * Math.cos(heading) - r * Math.sin(heading),
        leader.east + f * Math.sin(heading) + r * Math.cos(heading),
        leader.up + u,
      ];
    });
  }
  for (const v of vehicles) {
    v.step(dt, done);
    if (!v.silent) v.heardAt = Date.now() - Math.floor(Math.random() * 20);
  }
}
setInterval(() => step(0.05), 50);

function frame() {
  const view = new DataView(new ArrayBuffer(16 + 64 * vehicles.length));
  view.setUint32(0, 0x314e4b53, true);
  view.setUint32(4, ++sequence, true);
  view.setUint32(8, vehicles.length, true);
  view.setUint32(12, Date.now() - startedAt, true);
  vehicles.forEach((v, k) => v.write(view, 16 + 64 * k, project, Date.now()));
  return view.buffer;
}

const TYPES = { '.html': 'text/html', '.js': 'text/javascript', '.css': 'text/css', '.svg': 'image/svg+xml' };
async function asset(path, response) {
  const file = join(import.meta.dirname, '..', 'dist', normalize(path === '/' ? '/index.html' : path));
  try {
    const body = await readFile(file);
    response.writeHead(200, { 'content-type': TYPES[extname(file)] ?? 'application/octet-stream', 'content-security-policy': "default-src 'self'" });
    response.end(body);
  } catch {
    response.writeHead(404).end();
  }
}

/** What is asked for beside the stream, as far as the page needs it to be worked on. */
let fences = {
  zones: [
    {
      name: 'fence', kind: 'inclusion', outline: { shape: 'local_polygon', corners_m: [[-120, -160], [160, -160], [160, 160], [-120, 160]] },
      floor_m: -5, ceiling_m: 60, altitude_reference: 'origin', action: 'hold',
    },
    {
      name: 'mast', kind: 'exclusion', outline: { shape: 'local_circle', centre_m: [45, 30], radius_m: 12 },
      floor_m: 0, ceiling_m: 40, altitude_reference: 'origin', action: 'hold',
    },
  ],
  breach_return: null,
};
let emergencyKey = '';
/** A bird that flies to and fro. */
const track = () => ({
  track: 1000001, source: 'fused', name: '', pinned: false, class: 'bird', classes: { bird: 0.7, drone: 0.2 }, guessed_range: false, age_s: nodeTime() / 1e6, seen: nodeTime(), sensors: ['2/camera'],
  covariance_m2: [30, 12, 0, 9, 0, 16], time: nodeTime(),
  position: { north_m: 30 * Math.sin(Date.now() / 9000), east_m: 40, down_m: -15 }, velocity: { north_m_s: 3.3 * Math.cos(Date.now() / 9000), east_m_s: 0, down_m_s: 0 },
});

/** Who has control authority over which vehicle; Ben is no page but what is typed. */
const BEN = { id: 'ben', name: 'Ben' };
const held = new Map();
const controlled = () =>
  [...held].sort(([a], [b]) => a - b).map(([vehicle, h]) => ({ vehicle, ...h, is_heard: h.console === BEN || [...clients].some((client) => client.console === h.console.id) }));
function change(vehicle, { console, action }) {
  const has = held.get(vehicle);
  const take = () => has?.console.id === console.id || held.set(vehicle, { console, since: nodeTime(), requests: [] });
  const free = !has || has.console.id === console.id || !controlled().find((h) => h.vehicle === vehicle).is_heard;
  const refuse = (refusal) => ({ vehicle, refusal });
  if (action.action === 'take' && !free) return refuse({ reason: 'no_control_authority', vehicle, holder: has.console.name });
  if (action.action === 'take' || (action.action === 'request' && free)) take();
  else if (action.action === 'request') has.requests = [...has.requests.filter((r) => r.console.id !== console.id), { console, since: nodeTime() }];
  else if (has?.console.id !== console.id) return refuse({ reason: 'not_permitted', detail: `vehicle ${vehicle} is not under this console's control` });
  else if (action.action === 'release') held.delete(vehicle);
  else held.set(vehicle, { console: has.requests.find((r) => r.console.id === action.to).console, since: nodeTime(), requests: [] });
  return { vehicle, refusal: null };
}
const safety = (v) => ({
  id: v.id, failsafe: null, avoiding: null, stopped: v.stopped ?? false,
  energy: {
    remaining: v.battery / 100, needed_home: 0.05, reserve: 0.15, margin: v.battery / 100 - 0.2, endurance_s: v.battery * 12,
    return_in_s: v.battery * 9, level: v.battery < 25 ? 'return_now' : 'ok', learned: true, ground_speed_home_m_s: 4,
  },
});
const item = (id, title, status, value, why, limit = null, unit = '') => ({
  id, title, status, value, number: null, unit, limit, why, may_be_overridden: status === 'red',
});
const preflight = () => ({
  overrides: [],
  swarm: {
    vehicle: null, made_at: nodeTime(),
    items: [item('fences', 'Fences', fences.zones.length > 0 ? 'green' : 'amber', `${fences.zones.length}`, 'what bounds the flight must be known before it begins')],
  },
  vehicles: vehicles.map((v) => ({
    vehicle: v.id, made_at: nodeTime(),
    items: [
      item('link', 'Link', v.silent ? 'red' : 'green', v.silent ? 'not heard' : 'heard', 'what is not heard cannot be commanded'),
      item('battery', 'Charge', v.battery < 30 ? 'red' : 'green', (v.battery / 100).toFixed(2), 'there must be enough to come back', 0.3),
    ],
  })),
});
const cameraView = (v) => ({
  vehicle: v.id, payload: 'camera', width_px: 640, height_px: 480, known_from: 'frame', age_s: 0.1,
  pose: { position: { north_m: v.north, east_m: v.east, down_m: -v.up }, roll_rad: 0, pitch_rad: -0.6, yaw_rad: v.yaw, field_of_view_rad: 1.1 },
});
function preview(request) {
  const drawn = request.offsets?.slice(0, request.members?.length ?? count);
  if (drawn) return { slots: drawn, smallest_distance_m: Math.min(...drawn.flatMap((a, i) => drawn.slice(i + 1).map((b) => Math.hypot(a.forward_m - b.forward_m, a.right_m - b.right_m, a.down_m - b.down_m)))), views: drawn.map(() => 'ahead'), looking: 0 };
  const slots = slotsOf(request.shape, request.members?.length ?? count, request.spacing_m * request.scale, request.altitude_step_m);
  return { slots: slots.map(([f, r, u]) => ({ forward_m: f, right_m: r, down_m: -u })), smallest_distance_m: request.spacing_m, views: slots.map(() => 'ahead'), looking: 0 };
}

// As many parameters as PX4 has; vehicle 2 is flown over DDS and has none.
const PREFIXES = ['BAT1', 'CAL', 'COM', 'EKF2', 'GF', 'IMU', 'MAV', 'MC', 'MPC', 'NAV', 'RC', 'RTL', 'SDLOG', 'SENS', 'SYS'];
const parameters = Array.from({ length: 1500 }, (_, k) => ({
  name: `${PREFIXES[k % PREFIXES.length]}_MADE_UP_${k}`,
  value: k % 3 === 0 ? { type: 'integer', value: k } : { type: 'real', value: k / 8 },
  changed_from: null,
  revision: k + 1,
})).sort((a, b) => (a.name < b.name ? -1 : 1));
let parameterRevision = parameters.length;
let readingSince = null;
/** The parameters as they have been read so far: two hundred a second. */
function parameterList(url) {
  if (readingSince === null && url.searchParams.get('read') === 'true') readingSince = Date.now();
  const read = readingSince === null ? 0 : Math.min(parameters.length, Math.floor((Date.now() - readingSince) / 5));
  const since = Number(url.searchParams.get('since') ?? 0);
  const state = readingSince === null ? 'not_begun' : read < parameters.length ? 'reading' : 'complete';
  const known = parameters.filter((one) => (one.revision <= read || one.revision > parameters.length) && one.revision > since);
  const revision = read < parameters.length ? read : parameterRevision;
  return { reading: { state }, read, total: read > 0 ? parameters.length : null, revision, whole: since === 0, parameters: known.map(({ name, value, changed_from }) => ({ name, value, changed_from })) };
}
function writeParameter(id, name, value) {
  const one = parameters.find((other) => other.name === name);
  const fail = (status, reason, more) => ({ status, error: { code: reason, message: reason, detail: { reason, name, ...more } } });
  if (!one) return fail(404, 'unknown');
  if (vehicles[id - 1]?.armed) return fail(409, 'armed');
  if (one.value.type === 'integer' && !Number.isInteger(value)) return fail(422, 'wrong_type', { actual: 'a whole number', value: { type: 'real', value } });
  const before = one.value;
  Object.assign(one, { value: { ...before, value }, changed_from: one.changed_from ?? before, revision: ++parameterRevision });
  if (one.changed_from.value === value) one.changed_from = null;
  say(id, 'advisory', { kind: 'parameter', name }, `parameter ${name} set to ${value}, was ${before.value}`);
  return { status: 200, receipt: { name, value: one.value, before } };
}

const server = createServer(async (request, response) => {
  const url = new URL(request.url, 'http://localhost');
  if (!url.pathname.startsWith('/api/v1/')) return asset(url.pathname, response);
  let text = '';
  for await (const part of request) text += part;
  const body = text ? JSON.parse(text) : null;
  const answer = (status, value) => response.writeHead(status, { 'content-type': 'application/json' }).end(JSON.stringify(value));
  const refuse = (error) => answer(409, { error: { detail: null, ...error } });
  const [, of, parameter] = /^\/api\/v1\/vehicles\/(\d+)\/parameters(?:\/(\w+))?$/.exec(url.pathname) ?? [];
  if (of !== undefined) {
    if (of === '2') return refuse({ code: 'not_supported', message: 'not supported: parameters over DDS', detail: { reason: 'not_supported', detail: 'parameters over DDS' } });
    if (request.method === 'GET') return answer(200, parameterList(url));
    if (parameter === 'reading') {
      readingSince = body.action === 'stop' ? null : Date.now();
      return answer(202, { accepted: true });
    }
    const { status, error, receipt } = writeParameter(Number(of), parameter, body.value);
    return answer(status, error ? { error } : receipt);
  }
  switch (`${request.method} ${url.pathname.slice(8)}`) {
    case 'GET version':
      return answer(200, { program: 'skein', version: '0.1.0-dev', node: 'dev', protocol: 1 });
    case 'POST operator/alive':
      return response.writeHead(204).end();
    case 'GET references':
      return answer(200, { references: [] });
    case 'GET video':
      return answer(200, { streams: [] });
    case 'GET video/recordings':
      return answer(200, { recordings: [] });
    case 'GET cameras/views':
      return answer(200, { time: nodeTime(), views: vehicles.filter((v) => v.id % 3 === 2).map(cameraView) });
    case 'GET preflight':
      return answer(200, preflight());
    case 'GET fences':
      return answer(200, { plan: fences, outside: [] });
    case 'PUT fences':
      fences = body.plan;
      say(null, 'info', { kind: 'fences' }, `${fences.zones.length} zones in force`);
      return answer(200, { plan: fences, outside: [] });
    case 'POST formation/preview':
      return answer(200, preview(body));
    case 'POST emergency-stop/unlock':
      emergencyKey = `${Date.now()}`;
      return answer(200, { key: emergencyKey, valid_s: 10 });
    case 'POST emergency-stop': {
      if (body.key !== emergencyKey) return answer(403, { error: { code: 'not_permitted', message: 'not unlocked', detail: null } });
      const ids = body.targets === 'all' ? vehicles.map((v) => v.id) : body.targets.vehicles;
      for (const id of ids) Object.assign(vehicles[id - 1], { stopped: true, state: 'idle', armed: false, up: 0, slot: null });
      return answer(200, { receipts: ids.map((vehicle) => ({ vehicle, id: nextCommand++, refusal: null })) });
    }
    case 'GET events':
      return answer(200, { events: events.filter((e) => e.seq > Number(url.searchParams.get('after') ?? 0)), missed: 0 });
    case 'POST control':
      return answer(200, { receipts: body.targets.vehicles.map((vehicle) => change(vehicle, body)) });
    case 'POST commands': {
      const id = nextCommand++;
      const kept = (vehicle) => !['hold', 'land', 'return'].includes(body.command.command) && controlled().find((h) => h.vehicle === vehicle && h.is_heard && h.console.id !== request.headers['skein-console']);
      const ids = body.targets === 'all' ? vehicles.map((v) => v.id) : body.targets.vehicles;
      return answer(200, { receipts: ids.map((vehicle, k) => (kept(vehicle) ? { vehicle, id, refusal: { reason: 'no_control_authority', vehicle, holder: kept(vehicle).console.name } } : vehicles[vehicle - 1] ? command(vehicles[vehicle - 1], id, body.command, k) : { vehicle, id, refusal: { reason: 'unknown_vehicle', vehicle } })) });
    }
    case 'PUT formation': {
      const result = form(body);
      return result.code ? refuse(result) : answer(200, result);
    }
    case 'DELETE formation':
      for (const v of vehicles) if (v.slot || v.leader) Object.assign(v, { state: 'holding', slot: null, leader: false, goal: [v.north, v.east, v.up] });
      formation = null;
      return answer(200, { accepted: true });
    case 'PUT formation/route':
      if (!formation) return refuse({ code: 'wrong_state', message: 'no formation is flown' });
      Object.assign(formation, { route: body.route, leg: 0, route_finished: false });
      return answer(202, { accepted: true });
    default:
      return answer(404, { error: { code: 'not_found', message: 'no such path', detail: null } });
  }
});

new WebSocketServer({ server, path: '/api/v1/stream' }).on('connection', (socket, request) => {
  socket.console = new URL(request.url, 'http://localhost').searchParams.get('console');
  clients.add(socket);
  let timer;
  const rate = (hz) => (clearInterval(timer), (timer = setInterval(() => socket.send(frame()), 1000 / hz)));
  socket.send(JSON.stringify({ type: 'hello', protocol: 1, version: '0.1.0-dev', node: 'dev' }));
  socket.on('message', (data) => rate(Math.max(1, Math.min(50, JSON.parse(data).rate_hz))));
  let told = '[]';
  const tell = () => {
    const control = JSON.stringify(controlled());
    if (control !== told) socket.send(`{"type":"control","vehicles":${(told = control)}}`);
    socket.send(JSON.stringify(fleetInfo()));
    socket.send(JSON.stringify({ type: 'safety', vehicles: vehicles.map(safety) }));
    socket.send(JSON.stringify({ type: 'tracks', time: nodeTime(), tracks: [track()] }));
  };
  const slow = setInterval(tell, 500);
  tell();
  rate(10);
  socket.on('close', () => (clients.delete(socket), clearInterval(timer), clearInterval(slow)));
});

createInterface({ input: process.stdin }).on('line', (line) => {
  const [verb, id] = line.split(' ');
  const v = vehicles[Number(id) - 1];
  if (!v) return;
  if (verb === 'grab') held.set(v.id, { console: BEN, since: nodeTime(), requests: [] });
  if (verb === 'ask') change(v.id, { console: BEN, action: { action: 'request' } });
  if (verb === 'drop') change(v.id, { console: BEN, action: { action: 'release' } });
  if (verb === 'silence') (v.silent = true), say(v.id, 'critical', { kind: 'link_lost' }, 'the link is lost');
  if (verb === 'hear') (v.silent = false), say(v.id, 'info', { kind: 'link_regained' }, 'heard again');
  if (verb === 'pilot') (v.state = 'pilot_control'), (v.slot = null), say(v.id, 'warning', { kind: 'flight_state', state: 'pilot_control' }, 'the pilot took over');
  if (verb === 'fault') (v.state = 'faulted'), say(v.id, 'critical', { kind: 'flight_state', state: 'faulted' }, 'motor 3 reports no current');
  if (verb === 'drain') (v.battery = 20), say(v.id, 'warning', { kind: 'status_text' }, 'Battery low, land now');
  if (verb === 'restart') v.model++, say(v.id, 'warning', { kind: 'supervision', actor: `model-${v.id}`, status: 'restarting' }, 'the model panicked and was restarted');
});

server.listen(port, '127.0.0.1', () => console.log(`Dashboard: http://127.0.0.1:${server.address().port}`));
