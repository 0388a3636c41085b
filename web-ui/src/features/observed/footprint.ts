// What of the ground a camera sees: the corners of its picture carried down to flat ground at the height of the swarm frame's origin. Pure.

export type Spot = { north: number; east: number };

/** Where a camera is and looks: NED in metres, angles in radians, yaw from north, pitch upwards. */
export type Pose = {
  position: { north_m: number; east_m: number; down_m: number };
  roll_rad: number;
  pitch_rad: number;
  yaw_rad: number;
  field_of_view_rad: number;
};

/** The outline on the ground. Of the side that starts at each corner `cut` says that the camera sees on beyond it. */
export type Footprint = { corners: Spot[]; cut: boolean[] };

const NOTHING: Footprint = { corners: [], cut: [] };
/** A camera lower than this stands on the ground, in metres. */
const LOWEST_M = 0.5;
/** The ground is drawn as far away as this many heights of the camera, and no further than the second, in metres. */
const REACH_HEIGHTS = 8;
const REACH_M = 400;

type Ray = readonly [north: number, east: number, down: number];
const mix = (a: Ray, b: Ray, t: number): Ray => [a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t, a[2] + (b[2] - a[2]) * t];

/** The directions of the picture's corners, clockwise from its upper left one. */
function cornerRays(pose: Pose, aspect: number): Ray[] {
  const [sp, cp] = [Math.sin(pose.pitch_rad), Math.cos(pose.pitch_rad)];
  const [sy, cy] = [Math.sin(pose.yaw_rad), Math.cos(pose.yaw_rad)];
  const [sr, cr] = [Math.sin(pose.roll_rad), Math.cos(pose.roll_rad)];
  const forward: Ray = [cp * cy, cp * sy, -sp];
  const levelRight: Ray = [-sy, cy, 0];
  const levelDown: Ray = [sp * cy, sp * sy, cp];
  const turned = (a: number, b: number): Ray => [a * levelRight[0] + b * levelDown[0], a * levelRight[1] + b * levelDown[1], b * levelDown[2]];
  const right = turned(cr, sr);
  const down = turned(-sr, cr);
  const half = Math.tan(pose.field_of_view_rad / 2);
  return [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([x = 0, y = 0]) => {
    const [u, v] = [x * half, (y * half) / aspect];
    return [forward[0] + u * right[0] + v * down[0], forward[1] + u * right[1] + v * down[1], forward[2] + u * right[2] + v * down[2]];
  });
}

export function footprint(pose: Pose, widthPx: number, heightPx: number): Footprint {
  const heightM = -pose.position.down_m;
  const known = heightM >= LOWEST_M && pose.field_of_view_rad > 0 && pose.field_of_view_rad < Math.PI && widthPx > 0 && heightPx > 0;
  if (!known) return NOTHING;
  // Rays that come down more slowly than this reach the ground too far away to be of use, or never.
  const slowest = Math.max(1 / REACH_HEIGHTS, heightM / REACH_M);
  const rays = cornerRays(pose, widthPx / heightPx);
  const corners: Spot[] = [];
  const cut: boolean[] = [];
  const reached = (ray: Ray, seenOn: boolean) => {
    const times = heightM / ray[2];
    corners.push({ north: pose.position.north_m + ray[0] * times, east: pose.position.east_m + ray[1] * times });
    cut.push(seenOn);
  };
  rays.forEach((ray, k) => {
    const next = rays[(k + 1) % rays.length] ?? ray;
    const [here, there] = [ray[2] >= slowest, next[2] >= slowest];
    if (here) reached(ray, false);
    // Where the picture leaves the ground the outline goes on along the cut.
    if (here !== there) reached(mix(ray, next, (slowest - ray[2]) / (next[2] - ray[2])), here);
  });
  return corners.length < 3 ? NOTHING : { corners, cut };
}
