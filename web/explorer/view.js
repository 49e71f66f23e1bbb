// How the body is looked at: turned and enlarged by mouse, touch and keys on its picture, and by fields beside it.
class Viewing {
  // changed: called after each change of state.seen
  constructor(panel, canvas, state, changed) {
    Object.assign(this, {state, canvas, changed});
    this.fields = Object.fromEntries(["turn", "tilt", "zoom"].map((name) => [name, panel.querySelector(`#${name}`)]));
    // The slider of the size goes by powers of two.
    for (const name of ["turn", "tilt"]) this.fields[name].addEventListener("input", () => this.look({[name]: Number(this.fields[name].value)}));
    this.fields.zoom.addEventListener("input", () => this.look({zoom: 2 ** Number(this.fields.zoom.value)}));
    panel.querySelector("#front").addEventListener("click", () => this.front());
    canvas.addEventListener("keydown", (event) => this.press(event));
    // The wheel alone scrolls the page.
    canvas.addEventListener("wheel", (event) => {
      if (!event.ctrlKey) return;
      event.preventDefault();
      this.enlarge(Math.exp(-0.002 * event.deltaY));
    }, {passive: false});
    this.held = new Map();  // where each finger, or the mouse, was last
    canvas.addEventListener("pointerdown", (event) => {
      this.held.set(event.pointerId, [event.clientX, event.clientY]);
      canvas.setPointerCapture(event.pointerId);
    });
    for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) canvas.addEventListener(end, (event) => this.held.delete(event.pointerId));
    canvas.addEventListener("pointermove", (event) => this.drag(event));
  }

  look(some) {
    this.state.look({...this.state.seen, ...some});
    this.changed();
  }

  front() {
    this.state.look();
    this.changed();
  }

  enlarge(times) {
    this.look({zoom: this.state.seen.zoom * times});
  }

  turnBy(turn, tilt) {
    const {seen} = this.state;
    this.look({turn: seen.turn + turn, tilt: seen.tilt + tilt});
  }

  press(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;  // which are the browser's
    const acts = {ArrowLeft: () => this.turnBy(5, 0), ArrowRight: () => this.turnBy(-5, 0), ArrowUp: () => this.turnBy(0, -5), ArrowDown: () => this.turnBy(0, 5),
                  "+": () => this.enlarge(Math.SQRT2), "=": () => this.enlarge(Math.SQRT2), "-": () => this.enlarge(Math.SQRT1_2), "0": () => this.front()};
    if (!(event.key in acts)) return;
    event.preventDefault();
    acts[event.key]();
  }

  // One turns, two enlarge by how far they are apart.
  drag(event) {
    const last = this.held.get(event.pointerId);
    if (!last) return;
    const at = [event.clientX, event.clientY], other = [...this.held].filter(([id]) => id !== event.pointerId).map(([, place]) => place)[0];
    this.held.set(event.pointerId, at);
    if (!other) return this.turnBy(-0.6 * (at[0] - last[0]), 0.6 * (at[1] - last[1]));
    const apart = (place) => Math.hypot(place[0] - other[0], place[1] - other[1]);
    if (apart(last) > 0 && apart(at) > 0) this.enlarge(apart(at) / apart(last));
  }

  // Shows the state in the fields, if it is another one: each frame of a motion comes here.
  show() {
    const {turn, tilt, zoom} = this.state.seen, shown = [turn, tilt, zoom].join();
    if (shown === this.shown) return;
    this.shown = shown;
    this.fields.turn.value = turn;
    this.fields.tilt.value = tilt;
    this.fields.zoom.value = Math.log2(zoom);
    this.fields.zoom.setAttribute("aria-valuetext", `${kit.shown(zoom, 3)} times`);
  }

  // What is not seen from the front, in words.
  words() {
    const {turn, tilt, zoom} = this.state.seen, parts = [], degrees = (v) => `${kit.shown(Math.abs(v), 3)} degrees`;
    if (turn !== 0) parts.push(`${degrees(turn)} from the ${turn > 0 ? "right" : "left"}`);
    if (tilt !== 0) parts.push(`${degrees(tilt)} from ${tilt > 0 ? "above" : "below"}`);
    if (zoom !== 1) parts.push(`${kit.shown(zoom, 3)} times as large as all of it needs`);
    return parts.length ? `Seen ${parts.join(", ")}.` : "";
  }
}
