// Evaluates a codebook as `samara query` does (docs/codebook_file.md says what stands in one): sums of products and
// trains, all bases and transforms, cells and slabs, quaternions of the length with which they began.
//
// An axis: {basis, transform, lower, upper, nodes, borders, reference}; `reference` are the nodes of an element on
// [-1, 1]. A group: {outputs, terms, weights, factors} or {outputs, cores}, of numbers in one array each: weights[o +
// M r], factors[k][n + N r], cores[k] = {left, size, right, data[l + left (i + size r)]}, core 0 of the outputs.

// T(x) - T(a), without the difference of two values of T.
const DISTANCE = {
  none: (a, x) => x - a,
  log: (a, x) => Math.log1p((x - a) / a),
  reciprocal: (a, x) => (x - a) / a / x,
  square_root: (a, x) => x === a ? 0 : (x - a) / (Math.sqrt(x) + Math.sqrt(a)),
};
const TRANSFORM_SLOPE = {none: () => 1, log: (x) => 1 / x, reciprocal: (x) => 1 / x / x, square_root: (x) => 0.5 / Math.sqrt(x)};

// Barycentric interpolation through the nodes of an element, its weights and its matrix of derivatives.
function lagrangeBasis(nodes) {
  const n = nodes.length, weights = new Float64Array(n).fill(1), slopes = new Float64Array(n * n);
  for (let j = 0; j < n; ++j) for (let k = 0; k < n; ++k) if (k !== j) weights[j] /= 2 * (nodes[j] - nodes[k]);
  for (let i = 0; i < n; ++i) {
    for (let j = 0; j < n; ++j) {
      if (j === i) continue;
      slopes[i * n + j] = weights[j] / weights[i] / (nodes[i] - nodes[j]);
      slopes[i * n + i] -= slopes[i * n + j];
    }
  }
  return {nodes, weights, slopes};
}

// Values of the interpolating functions at x, of which at(j) is x less node j and scaled(d) what the weights are divided by.
function barycentric(n, weight, at, scaled) {
  const value = new Float64Array(n);
  let sum = 0;
  for (let j = 0; j < n; ++j) {
    const difference = at(j);
    if (difference === 0) {
      value.fill(0);
      value[j] = 1;
      return value;
    }
    value[j] = weight(j) / scaled(difference);
    sum += value[j];
  }
  for (let j = 0; j < n; ++j) value[j] /= sum;
  return value;
}

const isList = (axis) => axis.basis === "discrete" || axis.basis === "imported";

// The nodes that x touches on an axis: {first, value, slope}; the slope, on demand, is the derivative of the weights.
function stencil(axis, x, withSlope) {
  const {nodes} = axis;
  if (isList(axis)) {
    const first = nodes.indexOf(x);
    return {first, value: Float64Array.of(1), slope: withSlope ? Float64Array.of(NaN) : null};
  }
  if (axis.basis === "fourier") {
    const length = axis.upper - axis.lower, n = nodes.length;
    const inside = x >= axis.lower && x < axis.upper;
    const wrapped = inside ? x : x - length * Math.floor((x - axis.lower) / length);
    const value = barycentric(n, (j) => j % 2 === 0 ? 1 : -1, (j) => wrapped - nodes[j], (d) => Math.sin(Math.PI * d / length));
    if (!withSlope) return {first: 0, value, slope: null};
    const slope = new Float64Array(n);
    for (let j = 0; j < n; ++j) {
      for (let i = 0; i < n; ++i) {
        if (i === j) continue;
        const sign = (i - j) % 2 === 0 ? 1 : -1;
        slope[j] += sign * Math.PI / length / Math.sin(Math.PI * (i - j) / n) * value[i];
      }
    }
    return {first: 0, value, slope};
  }
  const {borders} = axis;
  axis.local = axis.local || lagrangeBasis(axis.reference);
  const {nodes: places, weights, slopes} = axis.local, n = places.length;
  let low = 0, high = borders.length - 2;  // the first element whose upper border is not below x
  while (low < high) {
    const middle = (low + high) >> 1;
    if (borders[middle + 1] < x) low = middle + 1; else high = middle;
  }
  const left = borders[low], right = borders[low + 1], distance = DISTANCE[axis.transform];
  const place = (distance(left, x) - distance(x, right)) / distance(left, right);
  const value = barycentric(n, (j) => weights[j], (j) => place - places[j], (d) => d);
  if (!withSlope) return {first: low * (n - 1), value, slope: null};
  const scale = 2 / distance(left, right) * TRANSFORM_SLOPE[axis.transform](x), slope = new Float64Array(n);
  for (let j = 0; j < n; ++j) {
    for (let i = 0; i < n; ++i) slope[j] += slopes[i * n + j] * value[i];
    slope[j] *= scale;
  }
  return {first: low * (n - 1), value, slope};
}

// A sum of products at the nodes of axis `along`: values[node * outputs + output]. `stencils` of all other axes;
// `weightsOf` says whether their values or slopes count.
function sumAtNodes(group, along, stencils, weightsOf) {
  const R = group.terms, M = group.outputs.length, c = new Float64Array(R).fill(1);
  group.factors.forEach((factor, k) => {
    if (k === along) return;
    const {first} = stencils[k], w = weightsOf(k), N = factor.length / R;
    for (let r = 0; r < R; ++r) {
      let s = 0;
      for (let i = 0; i < w.length; ++i) s += w[i] * factor[first + i + N * r];
      c[r] *= s;
    }
  });
  const factor = group.factors[along], N = R ? factor.length / R : group.sizes[along], values = new Float64Array(N * M);
  for (let r = 0; r < R; ++r) {
    for (let o = 0; o < M; ++o) {
      const s = group.weights[o + M * r] * c[r];
      for (let n = 0; n < N; ++n) values[n * M + o] += s * factor[n + N * r];
    }
  }
  return values;
}

// The same of a train.
function trainAtNodes(group, along, stencils, weightsOf) {
  const {cores} = group, M = group.outputs.length;
  let behind = Float64Array.of(1);
  for (let k = cores.length - 2; k > along; --k) {
    const {left, size, right, data} = cores[k + 1], {first} = stencils[k], w = weightsOf(k), next = new Float64Array(left);
    for (let b = 0; b < right; ++b) {
      for (let i = 0; i < w.length; ++i) {
        const s = w[i] * behind[b], at = left * (first + i + size * b);
        for (let l = 0; l < left; ++l) next[l] += s * data[at + l];
      }
    }
    behind = next;
  }
  let before = cores[0].data, rank = cores[0].right;  // [output + M l]
  for (let k = 0; k < along; ++k) {
    const {left, size, right, data} = cores[k + 1], {first} = stencils[k], w = weightsOf(k), next = new Float64Array(M * right);
    for (let b = 0; b < right; ++b) {
      for (let l = 0; l < left; ++l) {
        let s = 0;
        for (let i = 0; i < w.length; ++i) s += w[i] * data[l + left * (first + i + size * b)];
        for (let o = 0; o < M; ++o) next[o + M * b] += before[o + M * l] * s;
      }
    }
    [before, rank] = [next, right];
  }
  const {left, size, right, data} = cores[along + 1], values = new Float64Array(size * M), through = new Float64Array(rank);
  for (let n = 0; n < size; ++n) {
    through.fill(0);
    for (let b = 0; b < right; ++b) {
      const at = left * (n + size * b);
      for (let l = 0; l < left; ++l) through[l] += data[at + l] * behind[b];
    }
    for (let l = 0; l < rank; ++l) for (let o = 0; o < M; ++o) values[n * M + o] += before[o + M * l] * through[l];
  }
  return values;
}

class Codebook {
  // book: {coordinates, outputs, pieces: [{lower, upper, axes, groups}], attitude: {places, length} or null}
  constructor(book) {
    this.book = book;
  }

  // What does not depend on the other coordinates: places of coordinate number `along`, in every piece.
  prepare(along, places) {
    const pieces = this.book.pieces.map((piece) => {
      const axis = piece.axes[along], rows = [];
      places.forEach((x, i) => {
        if (x >= piece.lower[along] && x <= piece.upper[along] && (!isList(axis) || axis.nodes.includes(x))) rows.push(i);
      });
      return {rows, stencils: rows.map((i) => stencil(axis, places[i], true))};
    });
    return {along, places, pieces};
  }

  // Outputs at all prepared places, at the point x of the other coordinates: [output][place], NaN where no piece holds
  // the point. by: number of a coordinate to derive by; else the values themselves.
  curve(prepared, x, by = null) {
    const {along, places} = prepared, {book} = this;
    const values = book.outputs.map(() => new Float64Array(places.length).fill(NaN));
    // The lowest piece answers at borders: it is written last.
    for (let p = book.pieces.length - 1; p >= 0; --p) {
      const piece = book.pieces[p], {rows, stencils: own} = prepared.pieces[p];
      if (!rows.length || !piece.axes.every((axis, k) => k === along ||
          (x[k] >= piece.lower[k] && x[k] <= piece.upper[k] && (!isList(axis) || axis.nodes.includes(x[k]))))) continue;
      const stencils = piece.axes.map((axis, k) => k === along ? null : stencil(axis, x[k], k === by));
      const weightsOf = (k) => k === by ? stencils[k].slope : stencils[k].value;
      for (const group of piece.groups) {
        const M = group.outputs.length;
        const atNodes = (group.cores ? trainAtNodes : sumAtNodes)(group, along, stencils, weightsOf);
        group.outputs.forEach((output, o) => {
          const target = values[output];
          rows.forEach((place, row) => {
            const {first, value, slope} = own[row], w = by === along ? slope : value;
            let s = 0;
            for (let i = 0; i < w.length; ++i) s += w[i] * atNodes[(first + i) * M + o];
            target[place] = s;
          });
        });
      }
    }
    if (book.attitude) this.restore(values, by === null ? null : this.stored(prepared, x));
    return values;
  }

  stored(prepared, x) {
    return new Codebook({...this.book, attitude: null}).curve(prepared, x);
  }

  // Gives quaternions the length with which they began; of derivatives, `at` are the values as they are stored.
  restore(values, at) {
    const {places, length} = this.book.attitude;
    for (let i = 0; i < values[0].length; ++i) {
      const q = places.map((o) => (at || values)[o][i]), n = Math.hypot(...q) / length;
      if (!at) {
        places.forEach((o, k) => { values[o][i] = q[k] / n; });
        continue;
      }
      const u = q.map((v) => v / n), by = places.map((o) => values[o][i]);
      const slope = u.reduce((s, v, k) => s + v * by[k], 0) / (length * length);
      places.forEach((o, k) => { values[o][i] = (by[k] - u[k] * slope) / n; });
    }
  }

  // All outputs at one point, or their derivatives by coordinate `by`.
  at(x, by = null) {
    return this.curve(this.prepare(0, [x[0]]), x, by).map((column) => column[0]);
  }
}
