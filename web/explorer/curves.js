// Curves over one coordinate, of all outputs, with the band of the certificate, what was measured, residuals and
// sensitivities.
class Curves {
  constructor(parent, state) {
    this.parent = parent;
    this.state = state;
    this.charts = [];
    this.values = this.others = null;
  }

  // Everything anew: after another codebook, coordinate, capture, colours or width.
  build() {
    const {state, parent} = this, {book, along} = state, coordinate = book.coordinates[along];
    this.codebook = new Codebook(book);
    this.preparedFor = null;
    const count = state.data.times;
    const places = coordinate.list || Array.from({length: count}, (unused, i) => i === count - 1 ? coordinate.upper
        : coordinate.lower + (coordinate.upper - coordinate.lower) * i / (count - 1));
    this.prepared = this.codebook.prepare(along, places);
    for (const chart of this.charts) chart.plot.destroy();
    this.charts = [];
    parent.textContent = "";
    this.colours = kit.colours();
    this.evaluate();
    this.addKey();
    book.outputs.forEach((output, o) => {
      const box = kit.add(parent, "div");
      this.addCurve(box, output, o);
      if (state.measured(output)) this.addResiduals(box, output, o);
      if (state.slopes) this.addSlopes(box, output, o);
    });
  }

  evaluate() {
    const {state} = this;
    this.values = this.codebook.curve(this.prepared, state.point);
    this.others = state.other && this.codebook.curve(this.prepared, state.other);
  }

  // After another point.
  update() {
    this.evaluate();
    for (const chart of this.charts) chart.plot.setData(chart.data());
  }

  // Says in words what the curves show, to who cannot see them.
  describe() {
    const {book, along} = this.state, {unit} = book.coordinates[along], places = this.prepared.places;
    book.outputs.forEach((output, o) => {
      const values = Array.from(this.values[o]), inUnit = (v) => kit.shown(Number.isFinite(v) ? v : null, 4);
      const [low, high] = kit.span(values, 0);
      const words = values.some(Number.isFinite) ? `${inUnit(values[0])} at ${kit.shown(places[0], 4)}, ` +
          `${inUnit(values[values.length - 1])} at ${kit.shown(places[places.length - 1], 4)}` + (unit === "1" ? "" : " " + unit) +
          `, from ${inUnit(low)} to ${inUnit(high)}` + (output.unit === "1" ? "" : " " + output.unit) : "no values";
      this.charts.find((chart) => chart.of === o).plot.root.querySelector("canvas")
          .setAttribute("aria-label", `${output.name} over ${this.label()}: ${words}`);
    });
  }

  // After another place on the curves.
  mark() {
    for (const chart of this.charts) chart.plot.redraw(false);
  }

  // Half the width of the band: the 95 % quantile of the certificate's errors, in the unit of the output.
  band(o) {
    const error = this.state.book.certificate && this.state.book.certificate.outputs[o];
    return error && error.p95 !== null && error.range !== null ? error.p95 * error.range : 0;
  }

  addKey() {
    const {state, colours} = this, key = kit.add(this.parent, "p", null, "all soft");
    const entry = (text, draw) => {
      const made = kit.add(key, "span", null, "key");
      const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
      for (const [name, value] of Object.entries({width: 26, height: 12, "aria-hidden": "true"})) svg.setAttribute(name, value);
      const shape = document.createElementNS("http://www.w3.org/2000/svg", draw.tag);
      for (const [name, value] of Object.entries(draw)) if (name !== "tag") shape.setAttribute(name, value);
      svg.append(shape);
      made.append(svg, text);
    };
    const stroke = (colour, more) => ({tag: "path", d: "M1 6H25", stroke: colour, "stroke-width": 2, ...more});
    entry("codebook", stroke(colours.model, {}));
    if (state.book.outputs.some((output, o) => this.band(o) > 0))
      entry("95 % of the certificate's points are within", {tag: "rect", x: 1, y: 1, width: 24, height: 10, fill: colours.model, opacity: 0.25});
    if (state.other) entry("for comparison", stroke(colours.second, {"stroke-dasharray": "5 3"}));
    if (state.book.outputs.some((output) => state.measured(output))) entry("measured", {tag: "circle", cx: 13, cy: 6, r: 3.2, fill: colours.measured});
  }

  label() {
    const {book, along} = this.state, {name, unit} = book.coordinates[along];
    return kit.withUnit(name, unit);
  }

  cursor() {
    return kit.rules([{at: () => this.state.point[this.state.along], axis: "x", colour: this.colours.faint}]).draw[0];
  }

  // Gaps are null to uPlot.
  static shown(values) {
    return Array.from(values, (v) => Number.isNaN(v) ? null : v);
  }

  addCurve(parent, output, o) {
    const {state, colours, prepared} = this, half = this.band(o), measured = state.measured(output);
    const points = (u) => {
      const now = measured && this.shifted(measured, o);
      if (!now) return;
      const {ctx, bbox} = u;
      ctx.save();
      ctx.beginPath();
      ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
      ctx.clip();
      ctx.fillStyle = colours.measured;
      measured.times.forEach((t, i) => {
        if (now[i] === null) return;
        ctx.beginPath();
        ctx.arc(u.valToPos(t, "x", true), u.valToPos(now[i], "y", true), 2.4 * devicePixelRatio, 0, 2 * Math.PI);
        ctx.fill();
      });
      ctx.restore();
    };
    const data = () => {
      const own = this.values[o];
      return [prepared.places, Curves.shown(own), Curves.shown(own.map((v) => v + half)), Curves.shown(own.map((v) => v - half)),
              this.others ? Curves.shown(this.others[o]) : own.length ? Array(own.length).fill(null) : []];
    };
    const range = () => {
      const last = prepared.places[prepared.places.length - 1], now = (measured && this.shifted(measured, o)) || [];
      const seen = now.filter((v, i) => measured.times[i] >= prepared.places[0] && measured.times[i] <= last);
      const all = [...this.values[o], ...(this.others ? this.others[o] : []), ...seen];
      const [low, high] = kit.span(all, 0.06);
      return [low - half, high + half];
    };
    kit.add(parent, "h3", kit.withUnit(output.name, output.unit));
    const plot = kit.chart(parent, {
      x: this.label(), y: kit.withUnit(output.name, output.unit), says: `${output.name} over ${this.label()}`, height: 190, legend: false, yScale: {range},
      xScale: prepared.places.length > 1 ? {range: () => kit.span(prepared.places, 0.01)} : {}, hooks: {draw: [points, this.cursor()]},
      bands: half > 0 ? [{series: [2, 3], fill: colours.model + "40"}] : [],
      series: [kit.line("codebook", colours.model, prepared.places.length < 2 ? {points: {show: true}} : {}), {show: half > 0, points: {show: false}},
               {show: half > 0, points: {show: false}}, kit.line("for comparison", colours.second, {dash: [6, 4]})],
    }, data());
    this.charts.push({plot, data, of: o});
  }

  // Measured angles, each at the turn that is next to the curve; quaternions with the sign that is.
  shifted(measured, o) {
    const {attitude, outputs} = this.state.book;
    if (attitude && attitude.places.includes(o)) {
      const model = this.atMeasured(measured), parts = attitude.places.map((place) => [place, this.state.measured(outputs[place])]);
      if (parts.some(([, part]) => !part)) return measured.values;
      const along = (i) => parts.reduce((sum, [place, part]) => sum + model[place][i] * part.values[i], 0);
      return measured.values.map((v, i) => v !== null && along(i) < 0 ? -v : v);
    }
    const {period} = measured;
    if (period === 0) return measured.values;
    const model = this.atMeasured(measured)[o];
    return measured.values.map((v, i) => v === null ? null : v + period * Math.round(((Number.isNaN(model[i]) ? v : model[i]) - v) / period));
  }

  atMeasured(measured) {
    if (this.preparedFor !== measured.times) [this.preparedFor, this.preparedMeasured] = [measured.times, this.codebook.prepare(0, measured.times)];
    return this.codebook.curve(this.preparedMeasured, this.state.point);
  }

  addResiduals(parent, output, o) {
    const {state, colours} = this, measured = state.measured(output);
    const note = kit.add(parent, "p", null, "soft");
    const data = () => {
      const model = this.atMeasured(measured)[o], now = this.shifted(measured, o);
      const rest = now.map((v, i) => v === null || Number.isNaN(model[i]) ? null : measured.gain * (v - model[i])), seen = rest.filter((v) => v !== null);
      const rms = Math.sqrt(seen.reduce((s, v) => s + v * v, 0) / seen.length);
      note.textContent = seen.length ? `Residuals: rms ${kit.shown(rms, 3)}${output.unit === "1" ? "" : " " + output.unit} of ${kit.counted(seen.length, "frame")}`
          : "No frame of this capture lies in the time of the codebook";
      note.dataset.rms = String(rms);
      return [measured.times, rest];
    };
    const first = data();
    const plot = kit.chart(parent, {x: this.label(), y: "residual", says: `Residuals of ${output.name} over ${this.label()}`, height: 130, legend: false, hooks: {draw: [...kit.rules([{at: 0, axis: "y", colour: colours.faint}]).draw, this.cursor()]},
                                    xScale: {range: () => kit.span(this.prepared.places, 0.01)}, series: [kit.points("measured − codebook", colours.measured)]}, first);
    this.charts.push({plot, data});
  }

  // How much an output would change if a coordinate moved over its box, to first order.
  addSlopes(parent, output, o) {
    const {book, along} = this.state, others = book.coordinates.map((c, k) => k).filter((k) => k !== along && !book.coordinates[k].list);
    if (!others.length) return;
    const data = () => [this.prepared.places, ...others.map((k) => {
      const {lower, upper} = book.coordinates[k];
      return Curves.shown(this.codebook.curve(this.prepared, this.state.point, k)[o].map((v) => v * (upper - lower)));
    })];
    const tones = [this.colours.model, this.colours.second, this.colours.good, this.colours.measured, this.colours.doubt || this.colours.threshold, this.colours.soft, this.colours.ink];
    kit.add(parent, "p", `Sensitivities: d${output.name}/d.., times the width of the box`, "soft");
    const plot = kit.chart(parent, {x: this.label(), y: kit.withUnit(output.name, output.unit), says: `Sensitivities of ${output.name} over ${this.label()}`, height: 170, hooks: {draw: [this.cursor()]},
                                    xScale: {range: () => kit.span(this.prepared.places, 0.01)},
                                    series: others.map((k, n) => kit.line(book.coordinates[k].name, tones[n % tones.length], {dash: [[], [6, 4], [2, 3], [10, 3, 2, 3]][n % 4]}))}, data());
    this.charts.push({plot, data});
  }
}
