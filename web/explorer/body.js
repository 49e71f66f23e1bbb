// Draws a body, its path and a scale, in a world with z up; parallel projection, far triangles first.

// The pose {p, q} at instant i of the curves of a book: q = (w, x, y, z) turns the body into the world.
function poseOf(pose, values, i) {
  const v = pose.places.map((place) => values[place][i]);
  switch (pose.kind) {
    case "line": return {p: [0, 0, pose.downward ? -v[0] : v[0]], q: [1, 0, 0, 0]};
    case "plane": return {p: [v[0], 0, v[1]], q: [Math.cos(v[2] / 2), 0, -Math.sin(v[2] / 2), 0]};
    case "point": return {p: v, q: [1, 0, 0, 0]};
    default: {
      const q = v.slice(3), length = Math.hypot(...q);
      return {p: v.slice(0, 3), q: q.map((part) => part / length)};
    }
  }
}

// The vector v turned by the unit quaternion q.
function turned([w, x, y, z], v) {
  const t = [2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]), 2 * (x * v[1] - y * v[0])];
  return [v[0] + w * t[0] + y * t[2] - z * t[1], v[1] + w * t[1] + z * t[0] - x * t[2], v[2] + w * t[2] + x * t[1] - y * t[0]];
}

// Corners and triangles of a box, for bodies whose shape nobody said.
function plainPlate(size) {
  const corners = [];
  for (const z of [-0.04, 0.04]) for (const y of [-0.5, 0.5]) for (const x of [-0.5, 0.5]) corners.push([x * size, y * size, z * size]);
  const triangles = [];
  for (const [a, b, c, d] of [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]) triangles.push([a, b, c], [a, c, d]);
  return {corners, triangles};
}

function meshOf(body) {
  const corners = [], triangles = [];
  for (let k = 0; k < body.vertices.length; k += 3) corners.push([body.vertices[k], body.vertices[k + 1], body.vertices[k + 2]]);
  for (let k = 0; k < body.triangles.length; k += 3) triangles.push(body.triangles.slice(k, k + 3));
  // Each side of a triangle of a closed mesh is run through the other way by a neighbour.
  const sides = triangles.flatMap(([a, b, c]) => [[a, b], [b, c], [c, a]]), known = new Set(sides.map(([a, b]) => `${a} ${b}`));
  return {corners, triangles, isOpen: sides.some(([a, b]) => !known.has(`${b} ${a}`))};
}

const sizeOf = (mesh) => 2 * Math.max(...mesh.corners.map((corner) => Math.hypot(...corner)));

// 1, 2 or 5 times a power of ten, at most x.
function roundLength(x) {
  const power = 10 ** Math.floor(Math.log10(x));
  return power * [5, 2, 1].find((digit) => digit * power <= x);
}

class BodyView {
  // seen: {turn, tilt, zoom}: degrees about the vertical and from above, and how many times as large as the whole path needs
  constructor(canvas, seen) {
    Object.assign(this, {canvas, seen});
  }

  // Right, up and away from the viewer.
  axes() {
    const [a, b] = [this.seen.turn, this.seen.tilt].map((v) => v * Math.PI / 180), [ca, sa, cb, sb] = [Math.cos(a), Math.sin(a), Math.cos(b), Math.sin(b)];
    return [[ca, sa, 0], [-sa * sb, ca * sb, cb], [-sa * cb, ca * cb, -sb]];
  }

  // sets: [{path: [pose, ..], pose, colour, isOutline}], the first one in front. Returns how many times its size the body has.
  draw(sets, mesh, unit, colours) {
    const {canvas} = this, ratio = window.devicePixelRatio || 1, g = canvas.getContext("2d");
    const width = canvas.clientWidth || 640, height = canvas.clientHeight || 300;
    if (canvas.width !== Math.round(width * ratio)) canvas.width = Math.round(width * ratio);
    if (canvas.height !== Math.round(height * ratio)) canvas.height = Math.round(height * ratio);
    g.setTransform(ratio, 0, 0, ratio, 0, 0);
    g.clearRect(0, 0, width, height);
    const axes = this.axes(), dot = (u, v) => u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
    let [left, right, bottom, top] = [Infinity, -Infinity, Infinity, -Infinity];
    for (const set of sets) {
      for (const {p} of set.path) {
        const x = dot(p, axes[0]), y = dot(p, axes[1]);
        if (!Number.isFinite(x) || !Number.isFinite(y)) continue;
        [left, right, bottom, top] = [Math.min(left, x), Math.max(right, x), Math.min(bottom, y), Math.max(top, y)];
      }
    }
    if (!(right >= left)) return 1;
    const known = mesh !== null, size = known ? sizeOf(mesh) : 0.1 * Math.max(right - left, top - bottom, 1e-9);
    const shape = mesh || plainPlate(size);
    const scale = this.seen.zoom * Math.min(0.8 * width / (right - left + size), 0.8 * height / (top - bottom + size));
    const larger = Math.max(1, 0.11 * Math.min(width, height) / (scale * size));
    // What is larger than the picture follows the body in front.
    const near = (middle, extent, axis) => {
      const at = dot(sets[0].pose.p, axis), room = Math.max(0, 0.4 * extent / scale - size / 2);
      return Number.isFinite(at) ? Math.min(at + room, Math.max(at - room, middle)) : middle;
    };
    const middleX = near((left + right) / 2, width, axes[0]), middleY = near((bottom + top) / 2, height, axes[1]);
    const place = (v) => [width / 2 + scale * (dot(v, axes[0]) - middleX), height / 2 - scale * (dot(v, axes[1]) - middleY)];
    for (const set of [...sets].reverse()) {
      g.strokeStyle = set.colour;
      g.lineWidth = 1.5;
      g.globalAlpha = 0.7;
      g.setLineDash(set.isOutline ? [5, 4] : []);
      g.beginPath();
      for (const {p} of set.path) if (p.every(Number.isFinite)) g.lineTo(...place(p));
      g.stroke();
      g.setLineDash([]);
      g.globalAlpha = 1;
      if (set.pose.p.every(Number.isFinite)) this.drawMesh(g, set, shape, larger, axes, place, dot);
    }
    this.drawScale(g, scale, width, height, unit, colours);
    return known ? larger : NaN;
  }

  drawMesh(g, set, shape, larger, axes, place, dot) {
    const corners = shape.corners.map((corner) => turned(set.pose.q, corner).map((v, k) => set.pose.p[k] + larger * v));
    const light = axes[0].map((v, k) => -0.35 * v + 0.55 * axes[1][k] - 0.75 * axes[2][k]);
    const rgb = [1, 3, 5].map((at) => parseInt(set.colour.slice(at, at + 2), 16));
    const faces = [];
    for (const [a, b, c] of shape.triangles) {
      const [A, B, C] = [corners[a], corners[b], corners[c]];
      const u = B.map((v, k) => v - A[k]), w = C.map((v, k) => v - A[k]);
      let n = [u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2], u[0] * w[1] - u[1] * w[0]];
      if (dot(n, axes[2]) >= 0) {  // turned away
        if (!shape.isOpen) continue;
        n = n.map((v) => -v);
      }
      const shade = 0.45 + 0.55 * Math.max(0, dot(n, light) / (Math.hypot(...n) || 1));
      faces.push({points: [A, B, C].map(place), depth: dot(A, axes[2]) + dot(B, axes[2]) + dot(C, axes[2]), shade});
    }
    faces.sort((one, other) => other.depth - one.depth);
    g.lineWidth = 1;
    g.lineJoin = "round";
    for (const {points, shade} of faces) {
      g.fillStyle = g.strokeStyle = `rgb(${rgb.map((v) => Math.round(v * shade)).join(",")})`;
      g.globalAlpha = set.isOutline ? 0.35 : 1;
      g.beginPath();
      for (const point of points) g.lineTo(...point);
      g.closePath();
      g.fill();
      if (!set.isOutline) g.stroke();
    }
    g.globalAlpha = 1;
  }

  drawScale(g, scale, width, height, unit, colours) {
    const length = roundLength(0.25 * width / scale), pixels = length * scale;
    g.strokeStyle = g.fillStyle = colours.ink;
    g.lineWidth = 1.5;
    g.beginPath();
    g.moveTo(14, height - 18);
    g.lineTo(14, height - 14);
    g.lineTo(14 + pixels, height - 14);
    g.lineTo(14 + pixels, height - 18);
    g.stroke();
    g.font = "12px system-ui";
    g.fillText(kit.shown(length, 3) + (unit === "1" ? "" : " " + unit), 14, height - 24);
  }
}
