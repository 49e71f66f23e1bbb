"use strict";
// Draws the page of patterns from the JSON in it. Texts of files only ever become text nodes.
(() => {
  const {add, row, table, shown, withUnit, chart, span} = kit;
  const {draw, drawShares, named, key, choice} = patternMarks;
  const {ink: INK, soft: SOFT, faint: FAINT} = kit.colours();

  const page = JSON.parse(document.getElementById("patterns").textContent);
  const report = document.getElementById("report");
  const section = (title) => kit.section(report, title);
  const isSweep = page.kind === "sweep";

  function summary() {
    add(report, "p", page.summary, "lead").id = "summary";
    const text = Object.entries(page.thresholds).map(([name, value]) => `${name} ${shown(value)}`).join(", ");
    add(report, "p", `Called by the rule with the thresholds ${text}.`, "soft").id = "thresholds";
  }

  // Re and I*: logarithmic both, lines between regimes, and the body, or the points of a sweep with their shares.
  function diagram() {
    const {boundaries, bodies, missing, Re: measuredRe, I_disc: measuredI} = page.diagram;
    const part = section("Where the body stands");
    add(part, "p", "Lines are the boundaries between the regimes of discs in the laboratory (Field, Klaus, Moore, Nori 1997, and others), " +
        "rounded: 97 % of 347 measured discs lie on their right side. " +
        `Discs were measured from Re ${measuredRe.join(" to ")} and I* ${measuredI.join(" to ")}; beyond, and of other outlines, it is a guess.`, "soft");
    if (missing) add(part, "p", `The body is not in it: ${missing}.`, "doubt").id = "no-body";
    const reach = (own, measured) => {
      const decades = own.concat(measured).map(Math.log10);
      return [10 ** Math.floor(Math.min(...decades)), 10 ** Math.ceil(Math.max(...decades))];
    };
    const xs = reach(bodies.map((b) => b.Re), measuredRe), ys = reach(bodies.map((b) => b.I_disc), measuredI);
    const paint = (u) => {
      const {ctx} = u;
      const at = (Re, I) => [u.valToPos(Re, "x", true), u.valToPos(I, "y", true)];
      ctx.save();
      ctx.lineWidth = 1.5 * devicePixelRatio;
      boundaries.forEach((line, k) => {
        ctx.strokeStyle = INK;
        ctx.setLineDash([[], [6, 4], [2, 3]][k % 3].map((d) => d * devicePixelRatio));
        ctx.beginPath();
        line.Re.forEach((Re, n) => ctx.lineTo(...at(Re, line.I_disc[n])));
        ctx.stroke();
      });
      ctx.setLineDash([]);
      ctx.font = `${12 * devicePixelRatio}px system-ui`;
      ctx.fillStyle = SOFT;
      ctx.textAlign = "center";
      for (const [text, Re, I] of [["steady", 40, 3e-3], ["periodic", 1500, 2e-3], ["chaotic", 3000, 0.02], ["tumbling", 3000, 0.15]])
        ctx.fillText(text, ...at(Re, I));
      for (const body of bodies) {
        const [x, y] = at(body.Re, body.I_disc);
        if (body.shares) {
          drawShares(ctx, body.shares, x, y, 6 * devicePixelRatio);
        } else {
          ctx.strokeStyle = ctx.fillStyle = INK;
          ctx.beginPath();
          ctx.arc(x, y, 5 * devicePixelRatio, 0, 2 * Math.PI);
          ctx.fill();
        }
      }
      ctx.restore();
    };
    const log = (range) => ({distr: 3, range: () => range});
    chart(part, {x: "Re", y: "I* (disc)", height: 420, legend: false, hooks: {draw: [paint]}, logs: true, xScale: log(xs), yScale: log(ys),
                 series: [{show: false}], says: "regimes of falling discs over Re and I*, with the body"},
          [xs, [null, null]]);
    const there = new Set();
    for (const body of bodies) (body.shares || []).forEach((share, k) => { if (share > 0) there.add(k); });
    if (there.size) key(part, page.patterns, there);
    if (bodies.length) {
      const patterns = [...there].sort((a, b) => a - b);
      const made = table(part, ["Re#", "I*, disc#", "I*, plate#", "I*, ellipse#", "regime of discs", "beyond the next line", "away in ln#",
                                ...(patterns.length ? ["falls#"] : []), ...patterns.map((k) => page.patterns[k] + ", %#")]);
      made.id = "bodies";
      for (const b of bodies.slice(0, 50)) {
        row(made, [{value: b.Re, digits: 4}, {value: b.I_disc, digits: 4}, {value: b.I_plate, digits: 4}, {value: b.I_ellipse, digits: 4},
                   b.measured ? b.regime : {text: `${b.regime}: a guess, beyond what was measured`, name: "doubt"}, b.beyond,
                   {value: b.distance, digits: 3}, ...(patterns.length ? [{value: b.falls}] : []),
                   ...patterns.map((k) => ({value: 100 * b.shares[k], digits: 3}))]);
      }
      if (bodies.length > 50) add(part, "p", `and ${bodies.length - 50} more in the picture`, "soft");
    }
    const lines = table(part, ["boundary", "dashes", "Re: I*"]);
    lines.id = "boundaries";
    boundaries.forEach((line, k) => row(lines, [line.name, ["none", "long", "short"][k % 3],
        {text: line.Re.map((Re, n) => `${shown(Re, 3)}: ${shown(line.I_disc[n], 2)}`).join(", "), name: "wrap"}]));
  }

  // Any two features of all falls.
  function scatter() {
    const {features, patterns, groups, of} = page.falls;
    const part = section("Features");
    const groupNames = isSweep ? page.box.releases.map((r) => r.name) : page.captures.map((c) => c.id);
    add(part, "p", (isSweep ? `Each mark is a fall${of > patterns.length ? `: ${patterns.length} of ${of}, drawn` : ""}.`
                            : "Each mark is a window of a capture.") + " Falls of which a feature is not known are left out.", "soft");
    const bar = add(part, "p", null, "choice");
    const number = (name) => features.findIndex((f) => f.name === name);
    const known = (k) => features[k].values.filter((v) => v !== null).length;
    const texts = features.map((f) => withUnit(f.name, f.unit));
    const first = known(number("tilt")) ? number("tilt") : number("sway");
    const second = known(number("tilt")) ? number("drift") : number("straightness");
    const xChoice = choice(bar, "across", texts, first), yChoice = choice(bar, "up", texts, second);
    const group = groupNames.length > 1 ? choice(bar, isSweep ? "release" : "capture", ["all", ...groupNames], 0) : null;
    xChoice.id = "across";
    yChoice.id = "up";
    const place = add(part, "div", null, "wide");
    place.id = "scatter";
    function redraw() {
      const [x, y] = [Number(xChoice.value), Number(yChoice.value)].map((k) => features[k]);
      const own = group ? Number(group.value) - 1 : -1;
      const falls = patterns.map((unused, n) => n)
          .filter((n) => x.values[n] !== null && y.values[n] !== null && (own < 0 || groups[n] === own));
      const xs = span(falls.map((n) => x.values[n])), ys = span(falls.map((n) => y.values[n]));
      place.textContent = "";
      add(place, "p", `${x.name}: ${x.meaning}. ${y.name}: ${y.meaning}.`, "soft");
      const paint = (u) => {
        u.ctx.save();
        const half = (falls.length > 500 ? 3 : 5) * devicePixelRatio;
        for (const n of falls) draw(u.ctx, patterns[n], u.valToPos(x.values[n], "x", true), u.valToPos(y.values[n], "y", true), half);
        u.ctx.restore();
      };
      chart(place, {x: withUnit(x.name, x.unit), y: withUnit(y.name, y.unit), height: 420, legend: false, hooks: {draw: [paint]},
                    xScale: {range: () => xs}, yScale: {range: () => ys}, series: [{show: false}]}, [xs, [null, null]]);
      key(place, page.patterns, new Set(falls.map((n) => patterns[n])));
      const made = table(place, ["pattern", "falls#", `${x.name}: 5 %#`, "median#", "95 %#", `${y.name}: 5 %#`, "median#", "95 %#"]);
      made.id = "feature-shares";
      page.patterns.forEach((name, pattern) => {
        const those = falls.filter((n) => patterns[n] === pattern);
        if (!those.length) return;
        const shares = [x, y].flatMap((feature) => {
          const sorted = those.map((n) => feature.values[n]).sort((a, b) => a - b);
          return [0.05, 0.5, 0.95].map((q) => ({value: sorted[Math.round(q * (sorted.length - 1))], digits: 4}));
        });
        row(made, [name, {value: those.length}, ...shares]).dataset.pattern = name;
      });
    }
    for (const select of [xChoice, yChoice, group]) if (select) select.addEventListener("change", redraw);
    redraw();
  }

  // Which pattern follows which: a matrix, rows from, columns to.
  function chain() {
    if (!page.chain) {
      if (isSweep) add(section("Which pattern follows which"), "p",
                       "Not known: the sweep keeps no trajectories (keep = \"trajectories\").", "soft").id = "no-chain";
      return;
    }
    const part = section("Which pattern follows which");
    const steps = page.chain.steps;
    if (!steps.length) {
      add(part, "p", "No fall changes its pattern.", "soft").id = "no-chain";
      return;
    }
    add(part, "p", `Changes along ${kit.counted(page.chain.falls, "fall")}: probability of the next pattern, its 95 % interval, and the ` +
        "count. A change that was not seen may still happen.", "soft");
    const there = [...new Set(steps.flatMap((s) => [s.from, s.to]))].sort((a, b) => a - b);
    const made = table(part, ["from", ...there.map((k) => page.patterns[k] + "#")]);
    made.id = "chain";
    made.className = "matrix";
    for (const from of there) {
      const line = add(made, "tr");
      named(line, from, page.patterns[from], "td").className = "text";
      for (const to of there) {
        const step = steps.find((s) => s.from === from && s.to === to);
        const cell = add(line, "td", step ? `${shown(step.probability, 2)} (${shown(step.interval[0], 2)} to ${shown(step.interval[1], 2)}), ${step.count}` : "", "step");
        if (!step) continue;
        cell.dataset.value = String(step.probability);
        cell.style.background = `linear-gradient(to right, color-mix(in srgb, ${FAINT} 40%, transparent) ${100 * step.probability}%, transparent 0)`;
      }
    }
  }

  function captures() {
    if (!page.captures) return;
    const made = table(section("Captures, window by window"), ["capture", "from [s]#", "to [s]#", "pattern", "margin#", "why"]);
    made.id = "captures";
    for (const capture of page.captures) {
      const id = capture.left_out ? `${capture.id} (${kit.counted(capture.left_out, "frame")} not seen)` : capture.id;
      for (const w of capture.windows)
        row(made, [id, {value: w.from, digits: 5}, {value: w.to, digits: 5}, page.patterns[w.pattern], {value: w.margin, digits: 3}, {text: w.why, name: "wrap"}]);
    }
  }

  summary();
  captures();
  diagram();
  drawPatternMap(page, report);
  scatter();
  chain();
  kit.countPainted();
})();
