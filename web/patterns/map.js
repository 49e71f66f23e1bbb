// Slices of the map of patterns: of a grid through any of its points, else through the middle of the box.
function drawPatternMap(page, report) {
  const {section, add, table, row, shown, withUnit, chart} = kit;
  const {COLOURS, draw, named, choice, key} = patternMarks;
  const box = page.box;
  if (!box) return;
  const part = section(report, "Map");
  const releases = box.releases;
  const isGrid = box.axes !== null;
  if (!releases[0].cells && !releases[0].slices) {
    add(part, "p", "So few points have no map.", "soft");
    return;
  }
  const names = box.names.map((name, k) => withUnit(name, box.units[k]));
  const free = isGrid ? names.map((name, k) => k).filter((k) => box.axes[k].length > 1)
                      : [...new Set(releases[0].slices.flatMap((s) => [s.x, s.y]))].filter((k) => k >= 0);
  if (!free.length) free.push(0);

  // Centres of the cells along an axis, and their borders.
  function centres(axis) {
    if (isGrid) return box.axes[axis];
    const width = (box.upper[axis] - box.lower[axis]) / box.raster;
    return Array.from({length: box.raster}, (unused, k) => box.lower[axis] + (k + 0.5) * width);
  }
  function borders(values) {
    if (values.length === 1) return [values[0] - 0.5, values[0] + 0.5];
    const inner = values.slice(1).map((value, k) => 0.5 * (values[k] + value));
    return [2 * values[0] - inner[0], ...inner, 2 * values.at(-1) - inner.at(-1)];
  }

  // The letter of a cell of the slice by x (columns) and y (rows; -1: one row). Held: numbers along the other axes.
  function letterAt(release, x, y, held, column, rowNumber) {
    if (isGrid) {
      let place = 0;
      box.axes.forEach((values, k) => {
        place = place * values.length + (k === x ? column : k === y ? rowNumber : held[k]);
      });
      return release.cells[place];
    }
    const slice = release.slices.find((s) => (s.x === x && s.y === y) || (s.x === y && s.y === x));
    const [c, r] = slice.x === x ? [column, rowNumber] : [rowNumber, column];
    return slice.map[r * box.raster + c];
  }
  const patternOf = (letter) => letter.toLowerCase().charCodeAt(0) - 97;
  const isSure = (letter) => letter !== letter.toLowerCase();

  add(part, "p", "Colour and shape: the pattern that most of the seven nearest falls have" +
      ` (pale where fewer than ${100 * page.sure} % of them do).` +
      (releases.length > 1 ? " Of all releases together a cell is parted by their shares: a body that is let go in several ways may fall in several." : "") +
      (isGrid ? "" : " Slices go through the middle of the box."), "soft");
  const bar = add(part, "p", null, "choice");
  const which = choice(bar, "release", [...releases.map((r) => r.name), ...(releases.length > 1 ? ["all, by their shares"] : [])],
                       releases.length > 1 ? releases.length : 0);
  which.id = "map-release";
  const xChoice = choice(bar, "across", free.map((k) => names[k]), 0);
  const yChoice = free.length > 1 ? choice(bar, "up", free.map((k) => names[k]), 1) : null;
  const others = add(part, "p", null, "choice");
  const place = add(part, "div", null, "wide");
  place.id = "map";

  function drawSlice(x, y, held) {
    const chosen = Number(which.value);
    const asked = chosen < releases.length ? [releases[chosen]] : releases;
    const xs = centres(x), ys = y < 0 ? [0] : centres(y);
    const xEdges = borders(xs), yEdges = borders(ys);
    const cells = ys.map((unused, r) => xs.map((also, c) => asked.map((release) => letterAt(release, x, y, held, c, r))));
    place.textContent = "";
    const paint = (u) => {
      const {ctx} = u;
      ctx.save();
      cells.forEach((line, r) => line.forEach((letters, c) => {
        const [left, right] = [u.valToPos(xEdges[c], "x", true), u.valToPos(xEdges[c + 1], "x", true)];
        const [bottom, top] = [u.valToPos(yEdges[r], "y", true), u.valToPos(yEdges[r + 1], "y", true)];
        const width = (right - left) / letters.length;
        // Equal patterns side by side, so that a cell shows shares.
        [...letters].sort((a, b) => patternOf(a) - patternOf(b)).forEach((letter, k) => {
          ctx.globalAlpha = isSure(letter) ? 1 : 0.35;
          ctx.fillStyle = COLOURS[patternOf(letter)];
          ctx.fillRect(left + k * width, top, Math.ceil(width), Math.ceil(bottom - top));
          const half = 0.22 * Math.min(width, bottom - top);
          ctx.globalAlpha = 1;
          if (half > 2) draw(ctx, patternOf(letter), left + (k + 0.5) * width, 0.5 * (top + bottom), Math.min(half, 7 * devicePixelRatio), "#ffffff");
        });
      }));
      ctx.restore();
    };
    const range = (edges) => () => [edges[0], edges.at(-1)];
    chart(place, {x: names[x], y: y < 0 ? "" : names[y], height: y < 0 ? 140 : 420, legend: false, hooks: {draw: [paint]},
                  xScale: {range: range(xEdges)}, yScale: {range: range(yEdges)}, series: [{show: false}],
                  says: `map of patterns over ${names[x]}${y < 0 ? "" : " and " + names[y]}`},
          [[xEdges[0], xEdges.at(-1)], [null, null]]);
    const letters = cells.flat(2);
    key(place, page.patterns, new Set(letters.map(patternOf)));
    const counts = table(place, ["pattern", "of the slice, %#", "of them sure, %#"]);
    counts.id = "slice";
    page.patterns.forEach((name, pattern) => {
      const own = letters.filter((letter) => patternOf(letter) === pattern);
      if (!own.length) return;
      const made = row(counts, [name, {value: 100 * own.length / letters.length, digits: 3},
                                {value: 100 * own.filter(isSure).length / own.length, digits: 3}]);
      made.dataset.pattern = name;
    });
  }

  function redraw() {
    const x = free[Number(xChoice.value)];
    const y = yChoice ? free[Number(yChoice.value)] : -1;
    if (x === y) {  // the other one moves on
      yChoice.value = (Number(xChoice.value) + 1) % free.length;
      redraw();
      return;
    }
    others.textContent = "";
    const held = names.map((unused, k) => isGrid ? Math.floor(box.axes[k].length / 2) : 0);
    if (isGrid) {
      for (const k of free.filter((axis) => axis !== x && axis !== y)) {
        const made = choice(others, names[k] + " at", box.axes[k].map((value) => shown(value, 4)), held[k]);
        made.addEventListener("change", () => { held[k] = Number(made.value); drawSlice(x, y, held); });
      }
    }
    drawSlice(x, y, held);
  }
  for (const select of [which, xChoice, yChoice]) if (select) select.addEventListener("change", redraw);
  redraw();

  const all = table(part, ["release", ...page.patterns.map((name) => name + "#"), "of those run called right by the others, %#"]);
  all.id = "releases";
  for (const release of releases)
    row(all, [release.name, ...release.counts.map((value) => ({value})), {value: 100 * release.left_one_out, digits: 4}]);
}
