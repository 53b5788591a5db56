// Draws trail, plan, scan, marks, robot and the pose being placed over the map. `paint` holds the theme's colours.

import { placeLabels } from "./mark_labels.js";

const MIN_SYMBOL_PIXELS = 24; // pixels: the smallest symbol of the robot
const PI2 = 2 * Math.PI;

export function paintOf(element) {
  const style = getComputedStyle(element);
  const paint = {};
  for (const name of ["robot", "robot-old", "robot-edge", "scan", "plan", "trail", "mark", "charger", "place", "zone", "label", "halo"]) {
    paint[name] = style.getPropertyValue(`--draw-${name}`).trim();
  }
  paint.font = `600 13px ${style.fontFamily}`;
  return paint;
}

function path(context, view, points) {
  context.beginPath();
  for (let i = 0; i < points.length; i += 1) {
    const [px, py] = view.toScreen(points[i][0], points[i][1]);
    if (i === 0) context.moveTo(px, py);
    else context.lineTo(px, py);
  }
}

export function drawTrail(context, view, paint, trail) {
  context.strokeStyle = paint.trail;
  context.lineWidth = 3;
  context.lineJoin = "round";
  context.lineCap = "round";
  for (const line of trail.lines) {
    path(context, view, line);
    context.stroke();
  }
}

export function drawPlan(context, view, paint, points) {
  if (!points || points.length < 2) return;
  path(context, view, points);
  context.lineJoin = "round";
  context.strokeStyle = paint.halo;
  context.lineWidth = 6;
  context.stroke();
  context.strokeStyle = paint.plan;
  context.lineWidth = 3;
  context.setLineDash([8, 5]);
  context.stroke();
  context.setLineDash([]);
}

export function drawScan(context, view, paint, scan, old) {
  if (!scan) return;
  context.fillStyle = paint.scan;
  context.globalAlpha = old ? 0.25 : 0.9;
  const { points } = scan;
  for (let i = 0; i < points.length; i += 2) {
    const [px, py] = view.toScreen(points[i], points[i + 1]);
    context.fillRect(px - 1.5, py - 1.5, 3, 3);
  }
  context.globalAlpha = 1;
}

// Those of a simulated robot, [x, y, radius] in m.
export function drawObstacles(context, view, paint, circles) {
  context.fillStyle = paint["robot-old"];
  for (const [x, y, radius] of circles ?? []) {
    context.beginPath();
    context.arc(...view.toScreen(x, y), Math.max(4, radius * view.scale), 0, PI2);
    context.fill();
  }
}

// `cover` is an element over the map: no name is written under it.
export function drawMarks(context, view, paint, marks, chosen, cover) {
  const pins = [];
  for (const mark of marks ?? []) {
    if (!Number.isFinite(mark.x) || !Number.isFinite(mark.y)) continue;
    const [px, py] = view.toScreen(mark.x, mark.y);
    if (px < -60 || py < -20 || px > view.width + 60 || py > view.height + 40) continue;
    pin(context, paint, px, py, mark.charger, mark.name === chosen ? 13 : view.width < 420 ? 8 : 10);
    pins.push({ text: mark.name, x: px, y: py, first: mark.name === chosen });
  }
  context.font = paint.font;
  context.textAlign = "center";
  const { offsetLeft: left, offsetTop: top, offsetWidth: width, offsetHeight: height } = cover;
  const covered = { left, top, right: left + width, bottom: top + height };
  const labels = placeLabels(pins, (each) => context.measureText(each).width, covered);
  for (const { text, x, y } of labels) label(context, paint, text, x, y);
}

// A drop whose tip is the place. A charger also has a flash, so that colour is not the only difference.
function pin(context, paint, px, py, charger, r) {
  context.beginPath();
  context.arc(px, py - 1.6 * r, r, 0.85 * Math.PI, 2.15 * Math.PI);
  context.lineTo(px, py);
  context.closePath();
  context.fillStyle = charger ? paint.charger : paint.mark;
  context.fill();
  context.lineWidth = 2;
  context.strokeStyle = paint.halo;
  context.stroke();
  context.beginPath();
  if (charger) {
    const s = r / 10;
    const y = py - 1.6 * r;
    context.moveTo(px + 1.5 * s, y - 6 * s);
    context.lineTo(px - 4 * s, y + 1 * s);
    context.lineTo(px - 0.5 * s, y + 1 * s);
    context.lineTo(px - 1.5 * s, y + 6 * s);
    context.lineTo(px + 4 * s, y - 1.5 * s);
    context.lineTo(px + 0.5 * s, y - 1.5 * s);
    context.closePath();
  } else {
    context.arc(px, py - 1.6 * r, 0.36 * r, 0, PI2);
  }
  context.fillStyle = paint.halo;
  context.fill();
}

function label(context, paint, text, px, py) {
  context.lineWidth = 4;
  context.lineJoin = "round";
  context.strokeStyle = paint.halo;
  context.strokeText(text, px, py);
  context.fillStyle = paint.label;
  context.fillText(text, px, py);
}

// The robot's outline as the current path: a circle unless the robot names it. Not smaller than MIN_SYMBOL_PIXELS.
function outline(context, view, corners) {
  context.beginPath();
  if (!corners?.length) {
    context.arc(0, 0, Math.max(0.3 * view.scale, MIN_SYMBOL_PIXELS / 2), 0, PI2);
    return;
  }
  const least = Math.min(...[0, 1].map((at) => Math.max(...corners.map((one) => Math.abs(one[at])))));
  const scale = Math.max(view.scale, MIN_SYMBOL_PIXELS / 2 / Math.max(least, 0.01));
  corners.forEach(([x, y]) => context.lineTo(x * scale, -y * scale));
  context.closePath();
}

// A light and a dark edge: one of them contrasts with any background.
export function drawRobot(context, view, paint, pose, old, corners) {
  if (!pose) return;
  const [px, py] = view.toScreen(pose.x, pose.y);
  context.save();
  context.translate(px, py);
  context.rotate(-pose.yaw);
  outline(context, view, corners);
  context.lineJoin = "round";
  context.lineWidth = 7;
  context.strokeStyle = paint.halo;
  context.stroke();
  context.fillStyle = old ? paint.halo : paint.robot;
  context.fill();
  context.lineWidth = 3;
  context.strokeStyle = old ? paint["robot-old"] : paint["robot-edge"];
  if (old) context.setLineDash([4, 4]); // an old pose has a dashed outline
  context.stroke();
  context.setLineDash([]);
  arrow(context, Math.max(9, 0.2 * view.scale), old ? paint["robot-old"] : paint.halo);
  context.restore();
}

function arrow(context, size, colour) {
  context.beginPath();
  context.moveTo(size, 0);
  context.lineTo(-0.7 * size, 0.65 * size);
  context.lineTo(-0.35 * size, 0);
  context.lineTo(-0.7 * size, -0.65 * size);
  context.closePath();
  context.fillStyle = colour;
  context.fill();
}

// The pose being placed: a translucent robot with its heading.
export function drawPlacing(context, view, paint, place, corners) {
  if (!place) return;
  const [px, py] = view.toScreen(place.x, place.y);
  context.save();
  context.translate(px, py);
  context.rotate(-place.yaw);
  outline(context, view, corners);
  context.strokeStyle = paint.place;
  context.lineWidth = 2.5;
  context.setLineDash([6, 4]);
  context.stroke();
  context.setLineDash([]);
  context.beginPath();
  context.moveTo(0, 0);
  context.lineTo(52, 0);
  context.lineWidth = 4;
  context.stroke();
  context.translate(58, 0);
  arrow(context, 13, paint.place);
  context.restore();
}
