// Writes the motion of a body as binary glTF 2.0: one node, linear keys, y up.

// Times at which a line between poses is at most half a degree and a thousandth of the body from the motion.
// posesOf: times to poses. A jump, as where pieces of a codebook meet, stands between two keys a millionth of the whole
// apart: single precision, in which they are held, tells no nearer ones apart.
function denseKeys(posesOf, from, to, size) {
  const ANGLE = 0.4 * Math.PI / 180, DISTANCE = 8e-4 * size, MOST = 20000, SHORTEST = 1e-6 * (to - from);
  const posesAt = (times) => {
    const poses = posesOf(times), gap = poses.findIndex(({p, q}) => ![...p, ...q].every(Number.isFinite));
    if (gap >= 0) throw new Error(`the codebook has no pose at ${kit.shown(times[gap], 5)}: no .glb is saved`);
    return poses;
  };
  let times = Array.from({length: 65}, (unused, i) => from + (to - from) * i / 64), poses = posesAt(times);
  let settled = new Array(64).fill(false);
  while (settled.includes(false) && times.length < MOST) {
    const asked = [];
    settled.forEach((done, i) => {
      if (!done) for (const share of [0.25, 0.5, 0.75]) asked.push(times[i] + share * (times[i + 1] - times[i]));
    });
    const found = posesAt(asked), next = {times: [times[0]], poses: [poses[0]], settled: []};
    let at = 0;
    settled.forEach((done, i) => {
      const end = {t: times[i + 1], pose: poses[i + 1]};
      if (!done) {
        const own = found.slice(at, at + 3), middle = asked[at + 1];
        at += 3;
        const isNear = end.t - times[i] < SHORTEST ||
            own.every((pose, k) => isBetween(poses[i], end.pose, [0.25, 0.5, 0.75][k], pose, ANGLE, DISTANCE));
        if (!isNear) {
          next.times.push(middle);
          next.poses.push(own[1]);
          next.settled.push(false);
        }
        next.settled.push(isNear);
      } else {
        next.settled.push(true);
      }
      next.times.push(end.t);
      next.poses.push(end.pose);
    });
    ({times, poses, settled} = next);
  }
  if (settled.includes(false)) throw new Error(`the motion needs more than ${MOST} keys: no .glb is saved`);
  return {times, poses};
}

// Whether a pose lies as near as that to the share of the way from a to b, turned evenly.
function isBetween(a, b, share, pose, angle, distance) {
  const away = Math.hypot(...pose.p.map((v, k) => v - a.p[k] - share * (b.p[k] - a.p[k])));
  const dot = (u, v) => u.reduce((s, part, k) => s + part * v[k], 0);
  const cosine = dot(a.q, b.q), sign = cosine < 0 ? -1 : 1, half = Math.acos(Math.min(1, Math.abs(cosine)));
  const [one, other] = half < 1e-9 ? [1 - share, share] : [Math.sin((1 - share) * half) / Math.sin(half), Math.sin(share * half) / Math.sin(half)];
  const between = a.q.map((v, k) => one * v + sign * other * b.q[k]);
  return away <= distance && 2 * Math.acos(Math.min(1, Math.abs(dot(between, pose.q)))) <= angle;
}

function glbOf({name, mesh, times, poses, extras}) {
  const yUp = ([x, y, z]) => [x, z, -y];
  const corners = new Float32Array(mesh.corners.flatMap(yUp)), indices = new Uint32Array(mesh.triangles.flat());
  const places = new Float32Array(poses.flatMap(({p}) => yUp(p))), turns = new Float32Array(4 * poses.length);
  let last = null;
  poses.forEach(({q}, i) => {
    let turn = [...yUp(q.slice(1)), q[0]];
    if (last && turn.reduce((s, v, k) => s + v * last[k], 0) < 0) turn = turn.map((v) => -v);
    turns.set(last = turn, 4 * i);
  });
  const start = times[0], keys = new Float32Array(times.map((t) => t - start));
  const arrays = [corners, indices, keys, places, turns];
  let length = 0;
  const bufferViews = arrays.map((array) => {
    const view = {buffer: 0, byteOffset: length, byteLength: array.byteLength};
    length += array.byteLength;
    return view;
  });
  bufferViews[0].target = 34962;
  bufferViews[1].target = 34963;
  const ends = (k, choose) => [0, 1, 2].map((axis) => choose(...Array.from({length: corners.length / 3}, (unused, i) => corners[3 * i + axis])));
  const accessor = (bufferView, componentType, count, type, more = {}) => ({bufferView, componentType, count, type, ...more});
  const json = {
    asset: {version: "2.0", generator: "samara explore"}, scene: 0, scenes: [{nodes: [0], name, extras}],
    nodes: [{name: "body", mesh: 0, extras: {start}}],
    meshes: [{primitives: [{attributes: {POSITION: 0}, indices: 1, material: 0}]}],
    materials: [{pbrMetallicRoughness: {baseColorFactor: [0.55, 0.33, 0.16, 1], metallicFactor: 0, roughnessFactor: 0.8}, doubleSided: true}],
    accessors: [accessor(0, 5126, corners.length / 3, "VEC3", {min: ends(0, Math.min), max: ends(0, Math.max)}),
                accessor(1, 5125, indices.length, "SCALAR"), accessor(2, 5126, keys.length, "SCALAR", {min: [0], max: [keys[keys.length - 1]]}),
                accessor(3, 5126, poses.length, "VEC3"), accessor(4, 5126, poses.length, "VEC4")],
    animations: [{name, samplers: [{input: 2, output: 3, interpolation: "LINEAR"}, {input: 2, output: 4, interpolation: "LINEAR"}],
                  channels: [{sampler: 0, target: {node: 0, path: "translation"}}, {sampler: 1, target: {node: 0, path: "rotation"}}]}],
    bufferViews, buffers: [{byteLength: length}],
  };
  const bare = new TextEncoder().encode(JSON.stringify(json)), text = new Uint8Array((bare.length + 3) & ~3).fill(32);
  text.set(bare);
  const file = new Uint8Array(28 + text.length + length), view = new DataView(file.buffer);
  [0x46546C67, 2, file.length, text.length, 0x4E4F534A].forEach((word, k) => view.setUint32(4 * k, word, true));
  file.set(text, 20);
  view.setUint32(20 + text.length, length, true);
  view.setUint32(24 + text.length, 0x004E4942, true);
  arrays.forEach((array, k) => file.set(new Uint8Array(array.buffer), 28 + text.length + bufferViews[k].byteOffset));
  return file;
}
