// The page of the explorer: it holds the parts together, plays the motion, and saves what is shown.
const explorer = (() => {
  const $ = (id) => document.getElementById(id);
  const data = readExplored(), state = new State(data), curves = new Curves($("curves"), state);
  state.fromHash(location.hash);
  const view = new BodyView($("body"), state.seen), viewing = new Viewing($("view"), $("body"), state, () => touch("mark"));
  const controls = new Controls($("controls"), state, (what) => what === "all" ? buildAll() : touch());
  const calm = matchMedia("(prefers-reduced-motion: reduce)");
  let wants = null;     // what the next frame has to do: "mark" (the place on the curves moved) or "point"
  let playing = false, running = 0, last = 0, speech = 0, address = 0;

  const coordinate = () => state.book.coordinates[state.along];
  const hasBody = () => state.book.pose !== null;
  const hasMotion = () => hasBody() && state.book.hasTime && state.along === 0;  // which can be saved
  const mesh = () => state.book.body && (state.book.shape = state.book.shape || meshOf(state.book.body));
  const inUnit = (value, unit, digits = 5) => kit.shown(value, digits) + (unit === "1" ? "" : " " + unit);

  // Numbers that are not finite come as null: an error without bound, or, where nothing was compared, none that is known.
  const ofRange = (error, isKnown, whose) => error !== null ? `${kit.small(error)} of ${whose} range` : isKnown ? "without bound" : "unknown";

  // Head --------------------------------------------------------------------------------------------------
  function head() {
    const {book} = state, c = book.certificate, at = (x) => x.map((v, k) => `${book.coordinates[k].name} = ${inUnit(v, book.coordinates[k].unit, 4)}`).join(", ");
    $("certificate").textContent = !c ? `No certificate: nobody knows how far this codebook of ${book.model} is from its equations.`
        : `Certificate ${c.verdict}: largest error ${ofRange(c.max, c.points > c.failed, "an output's")} (asked for ${c.tolerance}), ` +
          `at ${c.points} points${c.times ? ` × ${c.times} times` : ""}, against ${c.integrator}` + (c.failed ? `, which failed at ${c.failed} points.` : ".");
    $("certificate").className = "lead " + (c && c.met ? "good" : "bad");
    $("certificate").dataset.met = String(Boolean(c && c.met));
    $("build").hidden = book.converged;
    $("build").textContent = book.converged ? "" : `The build did not end well: ${book.message}.`;
    $("worst").textContent = "";
    if (!c) return;
    const errors = book.outputs.map((output, o) => ({output, ...c.outputs[o]})).filter((e) => e.worst && e.worst.length === book.coordinates.length)
        .sort((one, other) => (other.max ?? Infinity) - (one.max ?? Infinity) || 0);
    let parent = $("worst");
    errors.forEach((error, n) => {
      if (n === 1) {
        parent = kit.add($("worst"), "details");
        kit.add(parent, "summary", "Worst points of the other outputs");
      }
      const button = kit.add(parent, "button", `Worst point${n ? "" : " of all"}: ${error.output.name}, ${ofRange(error.max, true, "its")}`);
      Object.assign(button, {type: "button", title: at(error.worst)});
      button.dataset.output = error.output.name;
      button.addEventListener("click", () => {
        state.point = error.worst.map((v, k) => state.nearest(book.coordinates[k], v));
        stop();
        touch();
      });
    });
  }

  // Values at the place -----------------------------------------------------------------------------------
  let cells = [];  // of each output: value, half of the band, compared, difference
  function buildValues() {
    $("values").textContent = "";
    const table = kit.table($("values"), ["output", "value#", "±#", ...(state.other ? ["compared#", "difference#"] : [])]);
    cells = state.book.outputs.map((output) => {
      const line = kit.row(table, [kit.withUnit(output.name, output.unit), ...Array(state.other ? 4 : 2).fill({value: null})]);
      line.dataset.output = output.name;
      return [...line.children].slice(1);
    });
    // What scrolls can be reached by keys.
    const box = table.parentElement;
    values();
    if (box.scrollWidth > box.clientWidth) Object.assign(box, {tabIndex: 0, role: "region", ariaLabel: "Table of values"});
  }
  function values() {
    const now = here(), then = state.other && curves.codebook.at(withPlace(state.other));
    $("values-heading").textContent = `Values at ${coordinate().name} = ${inUnit(state.point[state.along], coordinate().unit, 4)}`;
    cells.forEach((line, o) => {
      const digits = then ? 4 : 6;  // all that fit beside each other
      const numbers = [[now[o], digits], [curves.band(o) || NaN, 2], ...(then ? [[then[o], digits], [now[o] - then[o], 3]] : [])];
      numbers.forEach(([value, shown], k) => {
        line[k].textContent = kit.shown(Number.isNaN(value) ? null : value, shown);
        if (Number.isNaN(value)) delete line[k].dataset.value; else line[k].dataset.value = String(value);
      });
    });
    $("query").value = state.query();
  }
  // The outputs at the place, evaluated once a frame.
  let known = {point: null, values: null};
  function here() {
    if (known.book !== state.book || !known.point || known.point.some((v, k) => v !== state.point[k]))
      known = {book: state.book, point: [...state.point], values: curves.codebook.at(state.point)};
    return known.values;
  }
  function withPlace(point) {
    return point.map((v, k) => k === state.along ? state.point[k] : v);
  }

  // Body --------------------------------------------------------------------------------------------------
  function body() {
    if (!hasBody()) return;
    const {pose} = state.book, count = curves.prepared.places.length;
    const path = (all) => Array.from({length: count}, (unused, i) => poseOf(pose, all, i));
    const alone = (values) => poseOf(pose, values.map((v) => [v]), 0);
    const sets = [{path: path(curves.values), pose: alone(here()), colour: curves.colours.model}];
    if (state.other) sets.push({path: path(curves.others), pose: alone(curves.codebook.at(withPlace(state.other))), colour: curves.colours.second, isOutline: true});
    const larger = view.draw(sets, mesh(), pose.unit, curves.colours);
    const changes = state.book.body ? state.book.body.changes : [];
    $("view-note").textContent = (Number.isNaN(larger) ? "Drawn as a plate: nothing says what the body looks like. "
        : larger > 1.05 ? `The body is drawn ${kit.shown(larger, 2)} times its size. ` : "") +
        (changes.length ? `It is that of the middle of the box, whatever ${changes.join(", ")} may be. ` : "") + viewing.words();
    $("body").setAttribute("aria-label", `${sentence()}. ${viewing.words()}`.trim());
    viewing.show();
  }
  function sentence() {
    const now = here();
    return `At ${coordinate().name} = ${inUnit(state.point[state.along], coordinate().unit, 4)}: ` +
        state.book.outputs.map((output, o) => `${output.name} ${inUnit(now[o], output.unit, 4)}`).join(", ");
  }

  // Frames ------------------------------------------------------------------------------------------------
  function buildAll() {
    const focused = document.activeElement && document.activeElement.id;
    document.querySelector(".panes").classList.toggle("without-body", !hasBody());
    document.querySelector(".panes").classList.toggle("compared", state.other !== null);
    $("glb").hidden = !hasMotion();
    const c = coordinate(), place = {min: c.list ? 0 : c.lower, max: c.list ? c.list.length - 1 : c.upper, step: c.list ? 1 : "any"};
    Object.assign($("clock"), place);
    Object.assign($("clock-number"), {min: c.lower, max: c.upper});
    $("clock").setAttribute("aria-label", c.name);
    $("clock-number").setAttribute("aria-label", c.name + " as a number");
    head();
    controls.build();
    speeds();
    curves.build();
    buildValues();
    render("mark");
    // What was built anew keeps the keyboard; of what is gone, its neighbour takes it.
    const next = focused && ($(focused) || $("keep"));
    if (next && next !== document.activeElement) next.focus();
  }
  function render(what) {
    if (what === "point") curves.update();
    else if (what === "mark") curves.mark();
    body();  // which looks at sizes, before others change what stands on the page
    const c = coordinate(), at = state.point[state.along];
    $("clock").value = c.list ? c.list.indexOf(at) : at;
    $("clock").setAttribute("aria-valuetext", inUnit(at, c.unit, 4));
    if (document.activeElement !== $("clock-number")) $("clock-number").value = Number(at.toPrecision(6));
    controls.show();
    values();
    // Neither the address nor a reader of the screen follows every frame.
    clearTimeout(address);
    address = setTimeout(() => { if (!playing && !location.hash.startsWith("#check")) history.replaceState(null, "", "#" + state.toHash()); }, 250);
    clearTimeout(speech);
    if (!playing) speech = setTimeout(() => { $("spoken").textContent = sentence(); curves.describe(); }, 700);
  }
  function touch(what = "point") {
    if (wants === null) requestAnimationFrame(frame);
    if (wants !== "point") wants = what;
  }
  function frame(now) {
    const what = wants;
    wants = null;
    if (playing) advance(now);
    if (what) render(what);
  }

  // Playing -----------------------------------------------------------------------------------------------
  const length = () => coordinate().upper - coordinate().lower;
  function speeds() {
    const select = $("speed"), isTime = state.along === 0 && state.book.hasTime && coordinate().unit === "s";
    select.textContent = "";
    const factors = isTime ? [0.01, 0.02, 0.05, 0.1, 0.25, 0.5, 1, 2, 5, 10, 100] : [1, 2, 4, 8, 16];
    for (const f of factors) kit.add(select, "option", isTime ? `${f} × real time` : `${f} s for all`).value = f;
    const lasts = (f) => isTime ? length() / f : f;
    select.value = factors.reduce((best, f) => Math.abs(Math.log(lasts(f) / 4)) < Math.abs(Math.log(lasts(best) / 4)) ? f : best);
    select.dataset.real = String(isTime);
  }
  function advance(now) {
    const c = coordinate(), rate = $("speed").dataset.real === "true" ? Number($("speed").value) : length() / Number($("speed").value);
    // Who asked for less motion sees a picture twice a second.
    if (calm.matches && now - last < 500) return touch("mark");
    // Of a list the place between its values goes on, too.
    const shown = state.nearest(c, running) === state.point[state.along] ? running : state.point[state.along];
    let at = shown + Math.min(now - last, calm.matches ? 600 : 100) / 1000 * rate;
    last = now;
    if (at > c.upper) at = c.lower;
    running = at;
    state.point[state.along] = state.nearest(c, at);
    touch("mark");
  }
  function stop() {
    playing = false;
    $("play").textContent = "Play";
  }
  $("play").addEventListener("click", () => {
    if (playing) return stop(), touch("mark");
    playing = true;
    last = performance.now();
    $("play").textContent = "Pause";
    touch("mark");
  });
  $("clock").addEventListener("input", () => {
    const c = coordinate(), value = Number($("clock").value);
    state.point[state.along] = c.list ? c.list[value] : Math.min(c.upper, Math.max(c.lower, value));
    touch("mark");
  });
  $("clock-number").addEventListener("change", () => {
    const field = $("clock-number"), problem = state.problem(coordinate(), field.value.trim() === "" ? NaN : Number(field.value));
    field.setCustomValidity(problem);
    if (problem) return field.reportValidity();
    state.point[state.along] = Number(field.value);
    touch("mark");
  });

  // Saving ------------------------------------------------------------------------------------------------
  const parameters = () => state.book.coordinates.map((c, k) => [c.name, state.point[k]]).filter((entry, k) => k !== state.along);
  const lineOf = (text) => text.replace(/\s+/g, " ");
  // As `samara fit` reads it: the curves, with what they are of in comments.
  function csv() {
    const {book} = state, cell = (text) => /[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
    const header = [coordinate(), ...book.outputs].map((c) => cell(`${c.name}[${c.unit}]`)).join(",");
    const rows = curves.prepared.places.map((t, i) => [t, ...curves.values.map((v) => Number.isNaN(v[i]) ? "" : v[i])].join(","));
    const comments = [["model", book.model], ["codebook", book.file], ...parameters()].map(([key, value]) => `# ${lineOf(String(key)).replaceAll(":", "")}: ${lineOf(String(value))}`);
    return [...comments, header, ...rows].join("\n") + "\n";
  }
  function motion() {
    const {book} = state, c = coordinate();
    const posesAt = (times) => {
      const found = curves.codebook.curve(curves.codebook.prepare(state.along, times), state.point);
      return times.map((unused, i) => poseOf(book.pose, found, i));
    };
    const shape = mesh() || plainPlate(0.1 * Math.max(...[0, 1, 2].map((k) => {
      const [low, high] = kit.span(curves.prepared.places.map((unused, i) => poseOf(book.pose, curves.values, i).p[k]), 0);
      return high - low;
    })));
    const {times, poses} = denseKeys(posesAt, c.lower, c.upper, sizeOf(shape));
    return glbOf({name: book.model, mesh: shape, times, poses, extras: {model: book.model, codebook: book.file, parameters: {...book.fixed, ...Object.fromEntries(parameters())}}});
  }
  // All that is drawn, one below the other.
  function picture() {
    const drawn = [...(hasBody() ? [$("body")] : []), ...document.querySelectorAll("#curves canvas")], ratio = window.devicePixelRatio || 1;
    const canvas = document.createElement("canvas"), g = canvas.getContext("2d"), gap = 12 * ratio;
    canvas.width = Math.max(...drawn.map((d) => d.width)) + 2 * gap;
    canvas.height = drawn.reduce((sum, d) => sum + d.height + gap, 3 * gap);
    g.fillStyle = curves.colours.paper;
    g.fillRect(0, 0, canvas.width, canvas.height);
    g.fillStyle = curves.colours.ink;
    g.font = `${12 * ratio}px system-ui`;
    g.fillText([state.book.model, ...parameters().map(([key, value]) => `${key} = ${kit.shown(value, 4)}`)].join(", "), gap, 1.6 * gap);
    let top = 3 * gap;
    for (const d of drawn) {
      g.drawImage(d, gap, top);
      top += d.height + gap;
    }
    return canvas;
  }
  function save(name, content, type) {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([content], {type}));
    link.download = name;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  }
  $("csv").addEventListener("click", () => save("trajectory.csv", csv(), "text/csv"));
  $("glb").addEventListener("click", () => {
    try {
      save("motion.glb", motion(), "model/gltf-binary");
    } catch (problem) {
      kit.complain(problem.message);
    }
  });
  $("png").addEventListener("click", () => picture().toBlob((blob) => save("explorer.png", blob, "image/png")));
  $("copy").addEventListener("click", async () => {
    const field = $("query");
    field.select();
    try {
      await navigator.clipboard.writeText(field.value);
      $("spoken").textContent = "Copied.";
    } catch {
      $("spoken").textContent = "The line is selected: copy it by the keyboard.";
    }
  });

  // Begin -------------------------------------------------------------------------------------------------
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", buildAll);
  window.addEventListener("hashchange", () => {
    state.choose(state.number);  // what the address leaves out is as at the beginning
    state.fromHash(location.hash);
    buildAll();
  });
  let width = window.innerWidth;
  window.addEventListener("resize", () => {
    if (window.innerWidth === width) return;
    width = window.innerWidth;
    buildAll();
  });
  buildAll();
  kit.countPainted();
  return {state, curves, render, csv, motion, picture};
})();
