"use strict";
// The draws of a posterior: what they say of each coefficient, and how pairs of them hang together. `kit` has the
// building blocks of all pages (web/shared/kit.js) and those of fit_page.js.
function drawPosterior(fit, kit) {
  const {add, section, table, row, chart, line, points, rules, span, shown, counted, withUnit, colours} = kit;
  const posterior = fit.posterior;
  if (!posterior) return;
  const part = section("Posterior");
  add(part, "p", `${counted(posterior.draws, "draw")} in ${counted(posterior.chains, "chain")} of all unknowns together, frames taken as ` +
      "independent: " + (posterior.settled ? "the chains agree." : "the chains are not settled, as the warning says."),
      posterior.settled ? "soft" : "bad");
  const coefficients = fit.coefficients.map((c, k) => ({...c, ...posterior.unknowns[k], name: c.name}));
  const made = table(part, ["", "median#", "95 % from#", "to#", "mean#", "deviation#", "R-hat#", "effective draws#"]);
  made.id = "posterior";
  for (const c of coefficients) {
    row(made, [withUnit(c.name, c.unit), {value: c.median}, {value: c.lower, digits: 5}, {value: c.upper, digits: 5}, {value: c.mean},
               {value: c.deviation, digits: 3}, {value: c.rhat, digits: 4}, {value: c.effective, digits: 3}]);
  }
  // Files of earlier versions have no draws.
  const all = posterior.coefficient_draws;
  if (!all || !all.length || !all[0].length) return;

  const mean = (values) => values.reduce((sum, v) => sum + v, 0) / values.length;
  const normal = (x, at, error) => Math.exp(-0.5 * ((x - at) / error) ** 2) / (error * Math.sqrt(2 * Math.PI));
  const translucent = colours.model + "40";

  add(part, "h3", "Marginals");
  add(part, "p", "Histograms of the draws, with median and 95 % interval, beside the normal curves of the naive standard error, which is of " +
      "the same noise, and of the one from clusters.", "soft");
  const marginals = add(part, "div", null, "charts");
  coefficients.forEach((c, k) => {
    const draws = all[k];
    const [low, high] = span(draws, 0.03);
    const bins = Math.max(8, Math.min(40, Math.round(Math.sqrt(draws.length))));
    const width = (high - low) / bins;
    const counts = new Array(bins).fill(0);
    for (const v of draws) ++counts[Math.min(bins - 1, Math.floor((v - low) / width))];
    // Several places in each bin, so that the curves are smooth.
    const fine = 6;
    const x = Array.from({length: bins * fine + 1}, (unused, i) => low + width * i / fine);
    const density = x.map((unused, i) => counts[Math.min(bins - 1, Math.floor(i / fine))] / (draws.length * width));
    const data = [x, density];
    const series = [line("draws", colours.model, {paths: uPlot.paths.stepped({align: 1}), fill: translucent})];
    for (const [label, error, dash] of [["naive", c.naive_standard_error, []], ["clusters", c.standard_error, [6, 4]]]) {
      if (!error) continue;
      data.push(x.map((v) => normal(v, c.value, error)));
      series.push(line(label, colours.measured, {dash}));
    }
    const box = add(marginals, "div", null, "marginal");
    box.dataset.name = c.name;
    add(box, "h3", `${c.name}: ${shown(c.median, 5)}, 95 % from ${shown(c.lower, 5)} to ${shown(c.upper, 5)}`);
    const ends = [c.lower, c.upper].map((at) => ({at, axis: "x", colour: colours.model, dash: [2, 3]}));
    chart(box, {x: withUnit(c.name, c.unit), y: "density", height: 220, series,
                hooks: rules([{at: c.median, axis: "x", colour: colours.model}, ...ends])}, data);
  });
  if (coefficients.length < 2) return;

  const means = all.map(mean);
  const product = (a, b) => mean(all[a].map((v, i) => (v - means[a]) * (all[b][i] - means[b])));
  const pairs = [];
  for (let a = 0; a < all.length; ++a) {
    for (let b = a + 1; b < all.length; ++b) {
      const size = Math.sqrt(product(a, a) * product(b, b));
      pairs.push({a, b, r: size > 0 ? product(a, b) / size : 0});
    }
  }
  pairs.sort((one, other) => Math.abs(other.r) - Math.abs(one.r));
  const most = 6, chosen = new Set();
  for (const {a, b} of pairs) for (const k of [a, b]) if (chosen.size < most) chosen.add(k);
  add(part, "h3", "Pairs");
  add(part, "p", `The draws of two coefficients (${all[0].length} of each), those that hang together most first` +
      (all.length > most ? `; of the ${all.length} coefficients, only the ${most} with the largest correlations.` : "."), "soft").id = "pairs";
  const scatters = add(part, "div", null, "charts");
  for (const {a, b, r} of pairs.filter((pair) => chosen.has(pair.a) && chosen.has(pair.b))) {
    const box = add(scatters, "div", null, "pair");
    add(box, "h3", `${coefficients[a].name} and ${coefficients[b].name}: correlation ${shown(r, 2)}`);
    // Charts want ascending places.
    const order = all[a].map((unused, i) => i).sort((i, j) => all[a][i] - all[a][j]);
    const dots = points("draws", colours.model);
    dots.points = {show: true, size: 3, fill: translucent, stroke: translucent};
    const [x, y] = [a, b].map((k) => withUnit(coefficients[k].name, coefficients[k].unit));
    chart(box, {x, y, height: 260, series: [dots]}, [order.map((i) => all[a][i]), order.map((i) => all[b][i])]);
  }
}
