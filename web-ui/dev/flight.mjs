// Development aid: vehicles that move plausibly, so that the page can be worked on without the Rust program. Points with a
// speed limit, no dynamics. Must never be used by a test.

export const STATES = ['idle', 'arming', 'taking_off', 'holding', 'going_to', 'following', 'leading', 'returning', 'landing', 'pilot_control', 'faulted'];
const MODES = { idle: 7, arming: 7, taking_off: 8, holding: 6, going_to: 6, following: 6, leading: 6, returning: 11, landing: 12, pilot_control: 3, faulted: 9 };

/** Slots of a formation, leader first: [forward, right, up]. */
export function slotsOf(shape, count, spacing, step) {
  const slots = [];
  for (let k = 0; k < count; k++) {
    const rank = Math.ceil(k / 2);
    const side = k % 2 ? -1 : 1;
    if (shape === 'line') slots.push([0, side * rank * spacing, step * k]);
    else if (shape === 'column') slots.push([-k * spacing, 0, step * k]);
    else if (shape === 'wedge') slots.push([-rank * spacing, side * rank * spacing, step * k]);
    else if (shape === 'circle') {
      const r = count < 2 ? 0 : spacing / (2 * Math.sin(Math.PI / count));
      const a = (2 * Math.PI * k) / count;
      slots.push([r * (Math.cos(a) - 1), r * Math.sin(a), step * k]);
    } else {
      const columns = Math.ceil(Math.sqrt(count));
      const middle = Math.floor((columns - 1) / 2);
      slots.push([-Math.floor(k / columns) * spacing, ((k % columns) - middle) * spacing, step * k]);
    }
  }
  return slots;
}

export class Vehicle {
  constructor(id, north, east) {
    Object.assign(this, {
      id, north, east, up: 0, vn: 0, ve: 0, vu: 0, yaw: 0, state: 'idle', armed: false, battery: 97 - (id % 7), goal: null,
      home: [north, east], command: null, heardAt: Date.now(), slot: null, height: 10, startAt: 0, leader: false, silent: false, model: 1,
    });
  }

  get airborne() {
    return this.up > 0.2;
  }

  step(dt, done) {
    const goal = this.slot ?? this.goal ?? [this.north, this.east, this.up];
    const limit = this.state === 'following' ? 8 : 5;
    const move = (at, to, max) => Math.max(-max, Math.min(max, (to - at) * 1.6));
    const horizontal = ['idle', 'arming', 'taking_off', 'landing'].includes(this.state) ? 0 : limit;
    this.vn += (move(this.north, goal[0], horizontal) - this.vn) * Math.min(1, dt * 3);
    this.ve += (move(this.east, goal[1], horizontal) - this.ve) * Math.min(1, dt * 3);
    let wanted = move(this.up, goal[2], 2.5);
    if (this.state === 'taking_off') wanted = Date.now() < this.startAt ? 0 : move(this.up, this.height, 2.5);
    if (this.state === 'landing') wanted = -1.2;
    if (this.state === 'idle') wanted = 0;
    this.vu = wanted;
    this.north += this.vn * dt;
    this.east += this.ve * dt;
    this.up = Math.max(0, this.up + this.vu * dt);
    if (Math.hypot(this.vn, this.ve) > 0.6) this.yaw = Math.atan2(this.ve, this.vn);
    if (this.armed) this.battery -= dt * 0.04;
    if (this.state === 'taking_off' && Math.abs(this.up - this.height) < 0.3) this.enter('holding', done);
    if (this.state === 'landing' && this.up <= 0.02) {
      this.armed = false;
      this.enter('idle', done);
    }
    if (this.state === 'going_to' && this.goal && Math.hypot(this.north - this.goal[0], this.east - this.goal[1]) < 0.5) this.enter('holding', done);
    if (this.state === 'returning' && Math.hypot(this.north - this.home[0], this.east - this.home[1]) < 0.5) this.state = 'landing';
    if (this.state === 'arming' && Date.now() > this.startAt) done(this);
  }

  enter(state, done) {
    this.state = state;
    this.goal = [this.north, this.east, this.up];
    done(this);
  }

  write(v, o, project, now) {
    const place = project(this.north, this.east);
    const state = STATES.indexOf(this.state);
    let flags = (this.armed ? 1 : 0) | 4 | (this.slot ? 8 : 0) | 16 | (this.leader ? 32 : 0);
    const age = now - this.heardAt;
    if (age < 1500) flags |= 2;
    if (this.state === 'pilot_control') flags |= 64;
    if (this.state === 'faulted') flags |= 128;
    v.setUint16(o, this.id, true);
    v.setUint8(o + 2, MODES[this.state]);
    v.setUint8(o + 3, flags);
    v.setInt32(o + 4, Math.round(place[0] * 1e7), true);
    v.setInt32(o + 8, Math.round(place[1] * 1e7), true);
    v.setInt32(o + 12, Math.round((488 + this.up) * 1000), true);
    v.setInt16(o + 16, Math.round(this.vn * 100), true);
    v.setInt16(o + 18, Math.round(this.ve * 100), true);
    v.setInt16(o + 20, Math.round(-this.vu * 100), true);
    v.setUint16(o + 26, Math.round(((this.yaw * 180) / Math.PI + 360) * 100) % 36000, true);
    v.setUint8(o + 28, Math.round(this.battery));
    v.setUint8(o + 29, this.id % 5 === 4 ? 3 : 0);
    v.setUint8(o + 30, 14 + (this.id % 5));
    v.setUint8(o + 31, this.id % 3 ? 3 : 6);
    v.setUint16(o + 32, Math.round(1400 + this.battery * 2.6), true);
    v.setUint16(o + 34, Math.min(65535, age), true);
    v.setUint32(o + 36, now >>> 0, true);
    if (this.slot) {
      const slot = project(this.slot[0], this.slot[1]);
      v.setInt32(o + 40, Math.round(slot[0] * 1e7), true);
      v.setInt32(o + 44, Math.round(slot[1] * 1e7), true);
      v.setInt32(o + 48, Math.round((488 + this.slot[2]) * 1000), true);
    }
    v.setUint8(o + 52, state);
    v.setUint8(o + 53, this.airborne ? (this.state === 'landing' ? 4 : 2) : 1);
    const error = this.slot ? Math.hypot(this.slot[0] - this.north, this.slot[1] - this.east, this.slot[2] - this.up) : NaN;
    v.setUint16(o + 54, Number.isNaN(error) ? 65535 : Math.min(65534, Math.round(error * 100)), true);
    v.setUint16(o + 56, 12 + ((this.id * 7) % 20), true);
    v.setUint16(o + 58, this.airborne ? 500 : 0, true);
    v.setUint16(o + 60, 1, true);
    v.setUint16(o + 62, this.model, true);
  }
}
