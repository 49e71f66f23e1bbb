// The form: a slider and a number for every coordinate that no curve runs over, and what else is chosen.
class Controls {
  // changed(what): "point", or "all" where the page is to be built anew
  constructor(form, state, changed) {
    Object.assign(this, {form, state, changed});
    form.addEventListener("submit", (event) => event.preventDefault());
  }

  build() {
    const {form, state} = this, {data, book} = state;
    form.textContent = "";
    this.fields = [];
    if (data.books.length > 1)
      this.select("codebook", "Codebook", data.books.map((b, k) => [k, `${k + 1}: ${b.file}`]), state.number, (value) => state.choose(Number(value)));
    if (book.coordinates.length > 1)
      this.select("over", "Curves over", book.coordinates.map((c, k) => [k, c.name]), state.along, (value) => { state.along = Number(value); });
    if (data.captures.length) {
      this.select("capture", "Capture", [[-1, "none"], ...data.captures.map((c, k) => [k, c.label])], state.capture,
                  (value) => state.takeCapture(Number(value)));
    }
    book.coordinates.forEach((coordinate, k) => { if (k !== state.along) this.slider(coordinate, k); });
    const bar = kit.add(form, "div", null, "line");
    this.button(bar, "reset", "Middle of the box", () => {
      book.coordinates.forEach((c, k) => { if (k !== state.along) state.point[k] = state.nearest(c, (c.lower + c.upper) / 2); });
      this.changed("point");
    });
    if (data.fit) this.button(bar, "fit", "Values of the fit", () => { state.takeFit(); state.take(state.ownOf(state.capture)); this.changed("point"); });
    const second = kit.add(form, "div", null, "line");
    this.button(second, "keep", "Keep for comparison", () => { state.other = [...state.point]; this.changed("all"); });
    if (state.other) {
      this.button(second, "swap", "Swap", () => {
        const at = state.point[state.along];
        [state.point, state.other] = [state.other, state.point];
        state.point[state.along] = at;
        this.changed("point");
      });
      this.button(second, "drop", "Drop", () => { state.other = null; this.changed("all"); });
    }
    const line = kit.add(form, "div", null, "line"), box = kit.add(line, "input");
    Object.assign(box, {type: "checkbox", id: "slopes", checked: state.slopes});
    kit.add(line, "label", "Sensitivities").htmlFor = "slopes";
    box.addEventListener("change", () => { state.slopes = box.checked; this.changed("all"); });
    if (data.fit) kit.add(form, "p", data.fit.message, data.fit.converged ? "soft" : "bad");
    const isLess = data.fit && data.fit.leftOut && state.fitted(state.capture);
    if (isLess) kit.add(form, "p", data.fit.leftOut[0].toUpperCase() + data.fit.leftOut.slice(1) + ".", "bad").id = "left-out";
  }

  button(parent, id, text, act) {
    const made = kit.add(parent, "button", text);
    Object.assign(made, {type: "button", id});
    made.addEventListener("click", act);
  }

  select(id, text, entries, value, act) {
    kit.add(this.form, "label", text).htmlFor = id;
    const made = kit.add(this.form, "select");
    made.id = id;
    for (const [key, label] of entries) kit.add(made, "option", label).value = key;
    made.value = value;
    made.addEventListener("change", () => {
      act(made.value);
      this.changed("all");
    });
  }

  slider(coordinate, k) {
    const {state, form} = this, id = `coordinate-${k}`, {list} = coordinate;
    const fit = state.data.fit && state.data.fit.coefficients.find((c) => c.name === coordinate.name);
    kit.add(form, "label", kit.withUnit(coordinate.name, coordinate.unit)).htmlFor = id;
    const line = kit.add(form, "div", null, "line"), slider = kit.add(line, "input"), number = kit.add(line, "input");
    Object.assign(slider, {type: "range", id, ...(list ? {min: 0, max: list.length - 1, step: 1}
        : {min: coordinate.lower, max: coordinate.upper, step: (coordinate.upper - coordinate.lower) / 400})});
    Object.assign(number, {type: "number", step: "any", id: id + "-number"});
    if (!list) Object.assign(number, {min: coordinate.lower, max: coordinate.upper});
    number.setAttribute("aria-label", coordinate.name + " as a number");
    if (fit) kit.add(form, "p", `fit: ${kit.shown(fit.value, 5)}${fit.error === null ? "" : " ± " + kit.shown(fit.error, 2)}`, "soft");
    slider.addEventListener("input", () => {
      const value = Number(slider.value);
      // The last step of a slider may fall short of the end by rounding.
      state.point[k] = list ? list[value] : Math.min(coordinate.upper, Math.max(coordinate.lower, value));
      this.changed("point");
    });
    number.addEventListener("change", () => {
      const problem = number.value.trim() === "" ? "a number was expected" : state.problem(coordinate, Number(number.value));
      number.setCustomValidity(problem);
      if (problem) {
        number.reportValidity();
        return;
      }
      state.point[k] = Number(number.value);
      this.changed("point");
    });
    this.fields.push({k, list, slider, number});
  }

  // Shows the point in all fields.
  show() {
    for (const {k, list, slider, number} of this.fields) {
      const value = this.state.point[k];
      slider.value = list ? list.indexOf(value) : value;
      slider.setAttribute("aria-valuetext", kit.shown(value, 5));
      if (document.activeElement !== number || number.validity.valid) {
        number.value = Number(value.toPrecision(10));
        number.setCustomValidity("");
      }
    }
  }
}
