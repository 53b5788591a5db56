// Converts pad, keys and gamepad stick to a velocity. Pure. x right, y up, both -1..1 -> {vx, wz}: m/s, rad/s.

const DEAD_ZONE = 0.12; // a released stick is not exactly centred

export function fromStick(x, y, limits, dead = DEAD_ZONE) {
  const length = Math.hypot(x, y);
  if (!Number.isFinite(length) || length < dead) return { vx: 0, wz: 0 };
  const reach = (Math.min(1, length) - dead) / (1 - dead);
  const vx = (y / length) * reach * limits.vx;
  const turn = (-x / length) * reach * limits.wz;
  return { vx: round(vx), wz: round(turn) };
}

const DIRECTIONS = {
  ArrowUp: [0, 1], KeyW: [0, 1],
  ArrowDown: [0, -1], KeyS: [0, -1],
  ArrowLeft: [-1, 0], KeyA: [-1, 0],
  ArrowRight: [1, 0], KeyD: [1, 0],
};

export const isDriveKey = (code) => code in DIRECTIONS;

export function fromKeys(codes, limits) {
  let x = 0;
  let y = 0;
  for (const code of codes) {
    const [dx, dy] = DIRECTIONS[code] ?? [0, 0];
    x += dx;
    y += dy;
  }
  return { vx: round(Math.sign(y) * limits.vx), wz: round(-Math.sign(x) * limits.wz) };
}

// The standard layout: a shoulder button (4 or 5) is held, the left stick steers.
export function fromGamepad(pad, limits) {
  const held = [4, 5].some((number) => pad?.buttons?.[number]?.pressed);
  if (!held) return null;
  return fromStick(pad.axes[0] ?? 0, -(pad.axes[1] ?? 0), limits, 0.15);
}

const round = (value) => Math.round(value * 1000) / 1000 || 0;
