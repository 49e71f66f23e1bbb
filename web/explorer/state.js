// What the page carries and what it shows: the codebooks, the point of the box, a second one for comparison. The state
// stands in the address behind "#", so that a link or a bookmark brings it back.

// The data of the page, with its numbers in place.
function readExplored() {
  const data = JSON.parse(document.getElementById("explored").textContent);
  const stored = document.getElementById("numbers"), text = atob(stored.textContent), bytes = new Uint8Array(text.length);
  for (let k = 0; k < text.length; ++k) bytes[k] = text.charCodeAt(k);
  stored.textContent = "";  // which may be of 27 MB
  const view = new DataView(bytes.buffer), numbers = new Float64Array(bytes.length / 8);
  for (let k = 0; k < numbers.length; ++k) numbers[k] = view.getFloat64(8 * k, true);
  const get = ([at, count]) => numbers.subarray(at, at + count);
  for (const book of data.books) {
    for (const piece of book.pieces) {
      for (const group of piece.groups) {
        if (group.cores) {
          for (const core of group.cores) core.data = get(core.data);
        } else {
          group.weights = get(group.weights);
          group.factors = group.factors.map(get);
        }
      }
    }
    if (book.body) book.body.vertices = get(book.body.vertices);
    // The values of coordinates that are lists, over all pieces.
    book.coordinates.forEach((coordinate, k) => {
      const axes = book.pieces.map((piece) => piece.axes[k]);
      coordinate.list = axes.every(isList) ? [...new Set(axes.flatMap((axis) => axis.nodes))].sort((a, b) => a - b) : null;
    });
  }
  return data;
}

// Of the picture of the body: beyond, nothing more is to be seen.
const LEAST_ZOOM = 0.25, MOST_ZOOM = 256;

class State {
  constructor(data) {
    this.data = data;
    this.number = 0;       // of the codebook
    this.capture = -1;     // number of the capture shown
    this.slopes = false;   // whether sensitivities are shown
    this.seen = {};        // how the body is looked at: degrees, and times as large
    this.look();
    this.choose(0);
    if (data.fit) this.takeFit();
    if (data.captures.length) this.takeCapture(0);
  }

  get book() { return this.data.books[this.number]; }

  choose(number) {
    this.number = number;
    this.along = 0;
    this.point = this.book.coordinates.map((c, k) => k === 0 ? c.lower : this.nearest(c, (c.lower + c.upper) / 2));
    this.other = null;
  }

  nearest(coordinate, value) {
    const inside = Math.min(coordinate.upper, Math.max(coordinate.lower, value));
    if (!coordinate.list) return inside;
    return coordinate.list.reduce((best, v) => Math.abs(v - inside) < Math.abs(best - inside) ? v : best);
  }

  // Why a value of a coordinate cannot be shown, or nothing.
  problem(coordinate, value) {
    if (!Number.isFinite(value)) return "a number was expected";
    if (value < coordinate.lower || value > coordinate.upper) return `from ${coordinate.lower} to ${coordinate.upper} was expected`;
    if (coordinate.list && !coordinate.list.includes(value)) return `one of ${coordinate.list.slice(0, 12).join(", ")} was expected`;
    return "";
  }

  // Values by name, as far as they are coordinates; into the box.
  take(values) {
    this.book.coordinates.forEach((c, k) => {
      if (c.name in values && Number.isFinite(values[c.name])) this.point[k] = this.nearest(c, values[c.name]);
    });
  }

  takeFit() {
    this.take(Object.fromEntries(this.data.fit.coefficients.map((c) => [c.name, c.value])));
  }

  // What a fit says of a capture, or nothing.
  fitted(capture) {
    const place = capture >= 0 ? this.data.captures[capture].placeInFit : null;
    return place === null ? undefined : this.data.fit.captures[place];
  }

  ownOf(capture) {
    const found = this.fitted(capture);
    return found ? found.own : {};
  }

  // Since the release, by the delay of the capture's clock and the start of its motion.
  timesOf(capture) {
    const found = this.fitted(capture), shown = this.data.captures[capture];
    if (!found) return shown.times;
    const delay = {...this.data.fit.measurement, ...found.own}.delay || 0;
    return shown.sinceStart = shown.sinceStart || shown.times.map((t) => t - found.start + delay);
  }

  takeCapture(number) {
    this.capture = number;
    this.take(this.ownOf(number));
  }

  // Measured values of an output, as the model counts them: without the delay, the gain and the offset that the fit
  // found. period: of an angle; 0 for what does not repeat.
  measured(output) {
    if (this.capture < 0 || !this.book.hasTime || this.along !== 0) return null;
    const capture = this.data.captures[this.capture];
    const channel = capture.channels.find((c) => c.quantity === output.name && c.unit === output.unit);
    if (!channel) return null;
    const found = this.fitted(this.capture), own = found ? {...this.data.fit.measurement, ...found.own} : {};
    const offset = own[`offset of ${output.name}`] || 0, gain = own[`gain of ${output.name}`] || 1;
    const known = found ? this.data.fit.periods[output.name] : undefined;
    const period = known === undefined ? (channel.isAngle ? 2 * Math.PI : 0) : known;
    return {times: this.timesOf(this.capture), values: channel.values.map((v) => v === null ? null : (v - offset) / gain), gain,
            period: period / Math.abs(gain)};
  }

  // The view from the front, of all.
  look({turn = 0, tilt = 0, zoom = 1} = {}) {
    const inside = (value, least, most) => Math.min(most, Math.max(least, value));
    Object.assign(this.seen, {turn: turn - 360 * Math.round(turn / 360), tilt: inside(tilt, -90, 90), zoom: inside(zoom, LEAST_ZOOM, MOST_ZOOM)});
  }

  toHash() {
    const words = new URLSearchParams(), {coordinates} = this.book;
    if (this.data.books.length > 1) words.set("book", this.number);
    if (this.along !== 0) words.set("over", coordinates[this.along].name);
    coordinates.forEach((c, k) => words.set("p." + c.name, this.point[k]));
    if (this.other) coordinates.forEach((c, k) => words.set("b." + c.name, this.other[k]));
    if (this.data.captures.length) words.set("capture", this.capture);
    if (this.slopes) words.set("slopes", "1");
    const {turn, tilt, zoom} = this.seen;
    if (turn !== 0 || tilt !== 0 || zoom !== 1) words.set("view", [turn, tilt, zoom].map((v) => Number(v.toPrecision(6))).join(","));
    return words.toString();
  }

  // What is not understood, or lies outside the box, is left out.
  fromHash(text) {
    const words = new URLSearchParams(text.replace(/^#/, ""));
    const number = Number(words.get("book"));
    if (words.has("book") && this.data.books[number]) this.choose(number);
    const along = this.book.coordinates.findIndex((c) => c.name === words.get("over"));
    if (along >= 0) this.along = along;
    const read = (prefix, into) => this.book.coordinates.forEach((c, k) => {
      const word = words.get(prefix + c.name);
      if (word !== null && word.trim() !== "" && !this.problem(c, Number(word))) into[k] = Number(word);
    });
    read("p.", this.point);
    if ([...words.keys()].some((key) => key.startsWith("b."))) read("b.", this.other = [...this.point]);
    const capture = Number(words.get("capture"));
    if (words.has("capture") && (capture === -1 || this.data.captures[capture])) this.capture = capture;
    this.slopes = words.get("slopes") === "1";
    const [turn, tilt, zoom, ...more] = (words.get("view") || "").split(",").map((word) => word.trim() === "" ? NaN : Number(word));
    const isView = [turn, tilt, zoom].every(Number.isFinite) && more.length === 0;
    this.look(isView ? {turn, tilt, zoom} : {});
  }

  // The line of the command that gives the values shown.
  query() {
    const quoted = (word) => /^[\w@%+=:,.\/-]+$/.test(word) ? word : `'${word.replaceAll("'", "'\\''")}'`;
    const words = ["samara", "query", quoted(this.book.file)];
    this.book.coordinates.forEach((c, k) => {
      if (k === 0 && this.book.hasTime) return;
      words.push("--set", quoted(`${c.name}=${this.point[k]}`));
    });
    if (this.book.hasTime) words.push("--at", this.point[0]);
    return words.join(" ");
  }
}
