"use strict";
// Draws the report of a fit from the JSON in the page. Texts of files only ever become text nodes.
(() => {
  const {add, row, table, shown, rounded, counted, withUnit, chart, points, line, rules, span} = kit;
  const {measured: MEASURED, model: MODEL, threshold: THRESHOLD, faint: FAINT} = kit.colours();

  const fit = JSON.parse(document.getElementById("fit").textContent);
  const report = document.getElementById("report");
  const section = (title) => kit.section(report, title);

  // Sections ----------------------------------------------------------------------------------------------
  function summary() {
    const name = fit.status === "converged" ? "good" : "bad";
    const lead = add(report, "p", fit.message, "lead " + name);
    lead.id = "status";
    lead.dataset.status = fit.status;
    const cost = fit.cost === null ? "" : `, cost ${shown(fit.cost)}`;
    add(report, "p", `By ${fit.source}, ${fit.loss} loss, ${counted(fit.captures.length, "capture")} in ` +
        `${counted(fit.clusters, "cluster")}, ${counted(fit.residual_count, "value")}${cost}; ` +
        `${counted(fit.iterations, "iteration")}, ${shown(fit.seconds, 3)} s.`, "soft");
  }

  function coefficients() {
    if (!fit.coefficients.length) return;
    const part = section("Coefficients");
    const made = table(part, ["", "value#", "unit", "std. error#", "naive#", "box", "what may be said"]);
    made.id = "coefficients";
    for (const c of fit.coefficients) {
      const profile = fit.profiles.find((p) => p.name === c.name);
      const sure = c.determined && !c.at_bound && (!profile || profile.shape === "identified");
      const coefficientRow = row(made, [c.name, {value: c.value, error: c.standard_error}, c.unit === "1" ? "" : c.unit, {value: c.standard_error, digits: 2},
                              {value: c.naive_standard_error, digits: 2}, `${shown(c.lower, 4)} to ${shown(c.upper, 4)}`, {text: c.verdict, name: "wrap " + (sure ? "good" : "bad")}]);
      coefficientRow.dataset.name = c.name;
      if (!c.determined) coefficientRow.children[1].className = "soft";
    }
    add(part, "p", "Standard errors come from the scatter between clusters of captures; naive ones take all frames as " +
        "independent. An interval comes from a profile: everything else was fitted again with the coefficient held.", "soft");
    const claims = fit.identifiability ? fit.identifiability.phrases : [];
    if (claims.length) {
      add(part, "h3", "The captures determine");
      const list = add(part, "ul", null, "claims");
      for (const phrase of claims) add(list, "li", phrase);
    }
    if (fit.whiteness) {
      add(part, "h3", "Residuals");
      add(part, "p", fit.whiteness.sentence).id = "whiteness";
    }
    if (fit.noise.length) {
      add(part, "h3", "Noise");
      const levels = table(part, ["of", "standard deviation#", "+-#", "unit", "degrees of freedom#", ""]);
      levels.id = "noise";
      for (const n of fit.noise) {
        row(levels, [n.outputs.join(", "), {value: n.value, error: n.standard_error}, {value: n.standard_error, digits: 2}, n.unit === "1" ? "" : n.unit,
                     {value: n.degrees_of_freedom, digits: 4}, n.estimated ? "estimated" : "assumed"]);
      }
      add(part, "p", `Estimated together with the fit, in ${counted(fit.noise_rounds, "round")}.`, "soft");
    }
    if (fit.integration_shift !== null) {
      add(part, "p", "Steps of half the length would move no coefficient by more than " +
          `${shown(fit.integration_shift, 2)} standard errors.`, fit.integration_shift > 0.1 ? "bad" : "soft").id = "integration-shift";
    }
  }

  function warnings() {
    if (!fit.warnings.length) return;
    const list = add(section("Warnings"), "ul", null, "warnings");
    for (const sentence of new Set(fit.warnings)) add(list, "li", sentence);
  }

  function pathChart(parent, capture, lengths) {
    const names = lengths.map((r) => r.output);
    const [a, b] = names.map((name) => capture.outputs[name]);
    const xs = span(a.measured.concat(a.model)), ys = span(b.measured.concat(b.model));
    const draw = (u) => {
      const place = (k, of) => [u.valToPos(a[of][k], "x", true), u.valToPos(b[of][k], "y", true)];
      const {ctx} = u;
      ctx.save();
      ctx.fillStyle = MEASURED;
      for (let k = 0; k < a.measured.length; ++k) {
        if (a.measured[k] === null || b.measured[k] === null) continue;
        const [x, y] = place(k, "measured");
        ctx.beginPath();
        ctx.arc(x, y, 2.5 * devicePixelRatio, 0, 2 * Math.PI);
        ctx.fill();
      }
      ctx.strokeStyle = MODEL;
      ctx.lineWidth = 1.75 * devicePixelRatio;
      ctx.beginPath();
      for (let k = 0; k < a.model.length; ++k) ctx.lineTo(...place(k, "model"));
      ctx.stroke();
      ctx.restore();
    };
    add(parent, "h3", `path: ${names[1]} over ${names[0]}`);
    const [x, y] = lengths.map((r) => withUnit(r.output, r.unit));
    chart(parent, {x, y, height: 340, hooks: {draw: [draw]},
                   xScale: {range: () => xs}, yScale: {range: () => ys}, series: [{show: false}]},
          [xs, [null, null]]);
  }

  function drawCapture(parent, capture) {
    parent.textContent = "";
    const own = capture.nuisances.map((n) => `${n.name} = ${rounded(n.value, n.standard_error)}` +
        (n.standard_error === null ? "" : ` ± ${shown(n.standard_error, 2)}`) + (n.unit === "1" ? "" : " " + n.unit) + (n.at_bound ? " (at a bound)" : ""));
    const labels = Object.entries(capture.labels).map(([key, value]) => `${key} ${value}`);
    add(parent, "p", [`${capture.frames} frames`, ...labels, ...own].join(", "), "soft");
    for (const r of capture.residuals) {
      if (!(r.output in capture.outputs)) {  // the attitude as a whole
        add(parent, "p", `${r.output}: rms of residuals ${shown(r.rms, 3)} ${r.unit}`);
        continue;
      }
      const {measured, model} = capture.outputs[r.output];
      const label = withUnit(r.output, r.unit);
      add(parent, "h3", `${r.output}: rms of residuals ${shown(r.rms, 3)}${r.unit === "1" ? "" : " " + r.unit}`);
      const overlay = add(parent, "div", null, "wide overlay");
      chart(overlay, {x: "t [s]", y: label, series: [points("measured", MEASURED), line("model", MODEL)]},
            [capture.times, measured, model]);
      const rest = measured.map((value, k) => value === null || model[k] === null ? null : value - model[k]);
      const below = add(parent, "div", null, "wide residuals");
      chart(below, {x: "t [s]", y: "residual", height: 190, series: [points("measured − model", MEASURED)],
                    hooks: rules([{at: 0, axis: "y", colour: FAINT}])}, [capture.times, rest]);
    }
    const lengths = capture.residuals.filter((r) => r.unit === "m" && r.output in capture.outputs);
    if (lengths.length > 1) pathChart(add(parent, "div", null, "wide path"), capture, [lengths[0], lengths[lengths.length - 1]]);
  }

  function captures() {
    if (!fit.captures.length) return;
    const part = section("Captures and model");
    const bar = add(part, "p");
    const select = add(bar, "select");
    select.id = "capture";
    select.setAttribute("aria-label", "Capture");
    fit.captures.forEach((capture, k) => { add(select, "option", capture.id).value = k; });
    const back = add(bar, "button", "previous"), next = add(bar, "button", "next");
    const place = add(part, "div");
    place.id = "chosen";

    const list = section("All captures");
    const outputs = fit.captures[0].residuals;
    const whiteness = fit.whiteness ? fit.whiteness.series : [];
    const made = table(list, ["capture", "file", "cluster#", "frames#",
                              ...outputs.map((r) => withUnit("rms " + r.output, r.unit) + "#"), "largest lag-1 correlation#"]);
    made.id = "captures";
    const rows = fit.captures.map((capture, k) => {
      const lag = whiteness.filter((s) => s.capture === capture.id && s.p_value !== null).map((s) => s.lag1);
      const captureRow = row(made, [capture.id, capture.file, {value: capture.cluster}, {value: capture.frames},
                              ...capture.residuals.map((r) => ({value: r.rms, digits: 3})),
                              {value: lag.length ? lag.reduce((most, l) => Math.max(most, l)) : null, digits: 2}]);
      captureRow.classList.add("pick");
      captureRow.addEventListener("click", () => { choose(k); part.scrollIntoView(); });
      return captureRow;
    });
    function choose(k) {
      const chosen = (k + fit.captures.length) % fit.captures.length;
      select.value = chosen;
      rows.forEach((each, other) => each.classList.toggle("chosen", other === chosen));
      drawCapture(place, fit.captures[chosen]);
    }
    select.addEventListener("change", () => choose(Number(select.value)));
    back.addEventListener("click", () => choose(Number(select.value) - 1));
    next.addEventListener("click", () => choose(Number(select.value) + 1));
    choose(0);
  }

  function profiles() {
    if (!fit.profiles.length) return;
    const part = section("Profiles");
    add(part, "p", "How much the cost rises, in units of twice the log-likelihood, when a coefficient is held and " +
        "everything else is fitted again. The interval is where it stays below the dashed threshold.", "soft");
    const grid = add(part, "div", null, "charts");
    for (const p of fit.profiles) {
      const {unit, determined} = fit.coefficients.find((c) => c.name === p.name) || {unit: "1", determined: true};
      const deviance = (cost) => 2 * (cost - p.best_cost) / p.dispersion;
      const limit = deviance(p.threshold);
      const rise = p.costs.map(deviance);
      const lowest = Math.min(0, ...rise);
      const box = add(grid, "div", null, "profile");
      box.dataset.name = p.name;
      box.dataset.shape = p.shape;
      add(box, "h3", `${p.name}: ${determined ? p.shape : "not determined"}`);
      add(box, "p", determined ? p.verdict : "where the curve rises, others have met the ends of their boxes",
          determined && p.shape === "identified" ? "good" : "bad");
      const ends = p.interval.filter((v) => v !== null).map((at) => ({at, axis: "x", colour: MODEL, dash: [2, 3]}));
      const top = Math.min(Math.max(1.2 * limit, ...rise), 3 * limit);
      chart(box, {x: withUnit(p.name, unit), y: "deviance", height: 220, yScale: {range: () => [lowest, top]},
                  hooks: rules([{at: limit, axis: "y", colour: THRESHOLD, dash: [6, 4]},
                                {at: p.best, axis: "x", colour: FAINT}, ...ends]),
                  series: [line("deviance", MODEL, {points: {show: true, size: 5, fill: MODEL}})]}, [p.values, rise]);
    }
  }

  function starts() {
    const part = section("Starts");
    if (fit.global_search) {
      const g = fit.global_search;
      add(part, "p", `search of the box by ${g.method}: ${g.evaluations} points, least cost ${shown(g.cost, 6)} with segments not joined`);
    }
    add(part, "p", `${fit.starts_at_best} of ${fit.starts.length} starts of the fit reached the best cost`).id = "starts-at-best";
    const costs = fit.starts.map((s) => s.cost).filter((c) => c !== null);
    if (costs.length > 5) {
      costs.sort((a, b) => a - b);
      chart(add(part, "div", null, "wide"), {x: "start, best first", y: "cost", height: 160, whole: true,
            series: [points("cost", MODEL)]}, [costs.map((c, k) => k + 1), costs]);
    }
    const names = fit.coefficients.map((c) => c.name);
    const made = table(part, ["status", "cost#", "iterations#", ...names.map((name) => name + "#"), "best"]);
    for (const s of fit.starts.slice(0, 50)) {
      row(made, [{text: s.status, name: s.status === "failed" ? "bad" : ""}, {value: s.cost}, {value: s.iterations},
                 ...names.map((name, k) => ({value: s.coefficients[k], digits: 5})), s.reached_best ? "yes" : ""]);
    }
    if (fit.starts.length > 50) add(part, "p", `and ${fit.starts.length - 50} more, in the JSON`, "soft");
  }

  function notes() {
    // Windows of one capture have its notes.
    const noted = new Map(fit.captures.filter((c) => c.notes.length).map((c) => [c.id.replace(/ from [^ ]+ s$/, ""), c.notes]));
    if (!noted.size) return;
    const made = table(section("What reading and cleaning did"), ["capture", ""]);
    for (const [id, sentences] of noted) row(made, [id, sentences.join("; ")]);
  }

  function predictions() {
    if (!fit.predictions.length) return;
    const made = table(section("Predictions on what was left out"),
                       ["of", "by", "median#", "rms#", "largest#", "captures#", "values#", "capture"]);
    const files = new Map();  // of each id: captures of several files may share one
    for (const p of fit.capture_predictions) files.set(p.capture, (files.get(p.capture) ?? new Set()).add(p.file));
    const nameOf = (p) => files.get(p.capture)?.size > 1 ? `${p.capture} (${p.file})` : p.capture ?? "all";
    for (const p of [...fit.predictions, ...fit.capture_predictions]) {
      const by = p.best ? {text: `${p.predictor}, the best`, name: "best"} : p.predictor;
      row(made, [withUnit(p.quantity, p.unit), by, {value: p.median, digits: 4}, {value: p.rms, digits: 4},
                 {value: p.largest, digits: 4}, {value: p.captures}, {value: p.count}, nameOf(p)]);
    }
  }

  function held() {
    const fixed = Object.entries(fit.fixed);
    if (!fixed.length) return;
    const made = table(section("Held"), ["", "value (SI)#"]);
    for (const [name, value] of fixed) row(made, [name, {value}]);
  }

  function posterior() {
    drawPosterior(fit, {add, section, table, row, chart, line, points, rules, span, shown, counted, withUnit,
                        colours: {model: MODEL, measured: MEASURED}});
  }

  for (const part of [summary, coefficients, warnings, captures, profiles, posterior, predictions, starts, notes, held]) part();

  kit.countPainted();
})();
