"use strict";
// Draws the page of a planned motion from the JSON in it. Texts of files only ever become text nodes.
(() => {
  const {add, row, table, shown, small, withUnit, chart, line, span} = kit;
  const {ink: INK, soft: SOFT, faint: FAINT, model: MODEL, measured: MEASURED, second: SECOND, good: GOOD, bad: BAD} = kit.colours();

  const page = JSON.parse(document.getElementById("motion").textContent);
  const report = document.getElementById("report");
  const section = (title) => kit.section(report, title);
  const {length, time} = page.units;

  function summary() {
    add(report, "p", page.message, "lead").id = "summary";
    const made = table(report, ["status", "on the way#", "deviation#", "asked#", "from the landing place#", "knots#", "replayed until#"]);
    made.id = "status";
    const status = {text: page.status, name: page.status === "found" ? "good" : "bad"};
    row(made, [status, {value: page.end, digits: 5}, {value: page.deviation, digits: 4}, {value: page.asked_deviation, digits: 4},
               {value: page.landing_miss, digits: 4}, {value: page.knots}, {value: page.replayed_until, digits: 5}]);
    add(report, "p", `Lengths in ${length === "1" ? "units of the model" : length}, times in ${time === "1" ? "units of the model" : time}. ` +
        "The motion is one solution of the model whose coefficients change; nothing in it is blended.", "soft");
  }

  // From the side: place over height, equally scaled, the fall over its sketch.
  function view(part, axis) {
    const xs = page.path[axis], zs = page.path.z;
    const sketch = page.sketch ? page.sketch.map((p) => [p[axis === "x" ? 0 : 1], p[2]]) : [];
    const landing = page.landing ? [page.landing[axis === "x" ? 0 : 1], page.ground] : null;
    const all = sketch.concat(landing ? [landing] : []);
    const across = span(xs.concat(all.map((p) => p[0]))), up = span(zs.concat(all.map((p) => p[1])));
    // So wide and high is what axes and labels leave.
    const wide = kit.width(part) - 90;
    const high = Math.max(220, Math.min(640, wide * (up[1] - up[0]) / (across[1] - across[0])));
    const scale = Math.max((across[1] - across[0]) / wide, (up[1] - up[0]) / high);
    const widened = (range, pixels) => {
      const middle = 0.5 * (range[0] + range[1]), half = 0.5 * scale * pixels;
      return [middle - half, middle + half];
    };
    const xRange = widened(across, wide), yRange = widened(up, high);
    const paint = (u) => {
      const {ctx} = u;
      const trace = (points, colour, dash) => {
        ctx.strokeStyle = colour;
        ctx.setLineDash(dash.map((d) => d * devicePixelRatio));
        ctx.beginPath();
        for (const [x, y] of points) ctx.lineTo(u.valToPos(x, "x", true), u.valToPos(y, "y", true));
        ctx.stroke();
      };
      ctx.save();
      ctx.lineWidth = 1.75 * devicePixelRatio;
      if (sketch.length) trace(sketch, MEASURED, [7, 5]);
      trace(xs.map((x, k) => [x, zs[k]]), MODEL, []);
      ctx.fillStyle = INK;
      for (const event of page.events) {
        ctx.beginPath();
        ctx.arc(u.valToPos(event[axis], "x", true), u.valToPos(event.z, "y", true), 2.5 * devicePixelRatio, 0, 2 * Math.PI);
        ctx.fill();
      }
      if (landing) {
        ctx.setLineDash([]);
        ctx.strokeStyle = SECOND;
        ctx.beginPath();
        ctx.arc(u.valToPos(landing[0], "x", true), u.valToPos(landing[1], "y", true), 7 * devicePixelRatio, 0, 2 * Math.PI);
        ctx.stroke();
      }
      ctx.restore();
    };
    const made = add(part, "div", null, "wide");
    made.id = `path-${axis}`;
    chart(made, {x: withUnit(axis, length), y: withUnit("height", length), height: high + 80, legend: false, hooks: {draw: [paint]},
                 xScale: {range: () => xRange}, yScale: {range: () => yRange}, series: [{show: false}],
                 says: `the fall from the side, ${axis} over height${sketch.length ? ", over its sketch" : ""}`}, [xRange, [null, null]]);
  }
  function path() {
    const part = section(page.sketch ? "The fall over its sketch" : "The fall");
    const words = ["Blue, the fall"];
    if (page.sketch) words.push("dashed, the sketch");
    if (page.landing) words.push("the circle, the landing place");
    if (page.events.length) words.push("dots, events");
    add(part, "p", words.join("; ") + ".", "soft");
    view(part, "x");
    if (!page.planar) view(part, "y");
  }

  function coefficients() {
    const part = section("Coefficients over time");
    add(part, "p", "Each within the range that it may have, which is the height of its chart; the dashed line is what the body has by itself.", "soft");
    const charts = add(part, "div", null, "charts");
    for (const one of page.coefficients) {
      const place = add(charts, "div");
      const room = 0.05 * (one.upper - one.lower);
      chart(place, {x: withUnit("t", time), y: withUnit(one.name, one.unit), height: 200, legend: false, series: [line(one.name, MODEL)],
                    hooks: kit.rules([{at: one.natural, axis: "y", colour: FAINT, dash: [5, 5]}]),
                    yScale: {range: () => [one.lower - room, one.upper + room]}}, [page.times, one.values]);
    }
    const made = table(part, ["coefficient", "from#", "to#", "natural#", "least on the way#", "most#"]);
    made.id = "coefficients";
    for (const one of page.coefficients)
      row(made, [withUnit(one.name, one.unit), {value: one.lower}, {value: one.upper}, {value: one.natural, digits: 4},
                 {value: Math.min(...one.values), digits: 4}, {value: Math.max(...one.values), digits: 4}]);
  }

  function ghost() {
    const {times, force, torque, force_max, torque_max} = page.ghost;
    const part = section("The invisible force");
    add(part, "p", `What the motion would need besides all that its model knows: at most ${small(force_max)} net weights, and a torque of ` +
        `${small(torque_max)} of these times the semi-length. Of a blend of recordings it is 1 and more.`, "soft").id = "ghost-says";
    chart(add(part, "div", null, "wide"), {x: withUnit("t", time), y: "net weights", height: 240, logs: true, yScale: {distr: 3},
          series: [line("force", MODEL), line("torque", SECOND, {dash: [6, 4]})]}, [times, force, torque]);
  }

  const outcome = (asked, got) => (asked === got ? {text: got, name: "good"} : {text: got, name: asked ? "bad" : ""});
  function sequence() {
    if (!page.sequence) return;
    const {origin, seed, asked, had, not_reached, log_likelihood, segments, stretches} = page.sequence;
    const part = section("Kinds asked and got");
    const from = origin === "given" ? "Given in the plan" : seed === null ? `By the chain of ${origin}` : `Drawn from ${origin} with the seed ${seed}`;
    const counts = asked ? `: ${had} of ${kit.counted(asked, stretches.length ? "stretch" : "kind").replace("stretchs", "stretches")} as asked, ${not_reached} not reached` : "";
    const chain = log_likelihood === null ? "" : ` Mean log-likelihood of a segment under the chain: ${shown(log_likelihood, 3)}.`;
    add(part, "p", `${from}${counts}. What was got is told from the motion that came out, not from the search.${chain}`, "soft").id = "sequence-says";
    if (stretches.length) {
      const made = table(part, ["from#", "to#", "asked", "got", "why"]);
      made.id = "stretches";
      for (const s of stretches) row(made, [{value: s.begin, digits: 4}, {value: s.end, digits: 4}, s.asked, outcome(s.asked, s.got), {text: s.why, name: "wrap"}]);
    }
    const made = table(part, ["segment#", "from#", "to#", "asked", "got"]);
    made.id = "segments";
    segments.forEach((s, k) => row(made, [{value: k + 1}, {value: s.begin, digits: 4}, {value: s.end, digits: 4}, s.asked || "", outcome(s.asked, s.got)]));
  }

  function cost() {
    const part = section("What it costs, and how it was found");
    add(part, "p", "Parts of the one sum that search and windows make small, in semi-lengths squared.", "soft");
    const parts = table(part, ["part", "cost#"]);
    parts.id = "cost";
    for (const [name, value] of Object.entries(page.cost)) row(parts, [name, {value, digits: 4}]);
    const made = table(part, ["stage", "depth of the best#", "its cost#", "falls run#"]);
    made.id = "history";
    for (const step of page.history) row(made, [step.stage, {value: step.depth, digits: 4}, {value: step.cost, digits: 4}, {value: step.pieces}]);
    add(section("The plan"), "pre", page.plan).id = "plan";
  }

  summary();
  path();
  coefficients();
  sequence();
  ghost();
  cost();
  kit.countPainted();
})();
