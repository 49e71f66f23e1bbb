"use strict";
// What all pages are made of: elements, tables, charts by uPlot. Texts of files only ever become text nodes.
const kit = (() => {
  // Whatever fails is shown on the page, in an element with the id "errors".
  function complain(message) {
    const errors = document.getElementById("errors");
    errors.hidden = false;
    errors.textContent += message + "\n";
  }
  window.addEventListener("error", (event) => complain(event.message));

  // Elements ----------------------------------------------------------------------------------------------
  function element(tag, text, name) {
    const made = document.createElement(tag);
    if (text !== undefined && text !== null) made.textContent = text;
    if (name) made.className = name;
    return made;
  }
  function add(parent, tag, text, name) {
    return parent.appendChild(element(tag, text, name));
  }
  function section(parent, title) {
    const made = add(parent, "section");
    add(made, "h2", title);
    return made;
  }
  function shown(value, digits = 6) {
    return value === null || value === undefined ? "–" : String(Number(value.toPrecision(digits)));
  }
  // A value to the decimal of its error's second digit, as in the text of the report.
  function rounded(value, error, digits = 4) {
    if (!(error > 0) || !isFinite(error) || value === null || value === undefined) return shown(value, digits);
    const first = value === 0 ? -300 : Math.floor(Math.log10(Math.abs(value)));
    const power = Math.max(Math.floor(Math.log10(Number(error.toPrecision(2))) + 1e-9) - 1, first - 5), scale = 10 ** Math.max(power, 0);
    if (Math.abs(value) < 1e6 && power > -7) return (power > 0 ? Math.round(value / scale) * scale : value).toFixed(Math.max(-power, 0));
    return value.toExponential(Math.max(0, first - power));
  }
  // Of numbers that are far below one.
  function small(value, digits = 3) {
    return value !== null && value !== 0 && Math.abs(value) < 0.01 ? value.toExponential(digits - 1) : shown(value, digits);
  }
  function counted(number, noun) {
    return `${number} ${noun}${number === 1 ? "" : "s"}`;
  }
  function withUnit(name, unit) {
    return unit && unit !== "1" ? `${name} [${unit}]` : name;
  }
  // A cell is a text, or {value, digits} or {value, error} for a number, or {text, name} for a text with a class.
  function row(table, cells, tag = "td") {
    const made = add(table, "tr");
    for (const cell of cells) {
      const isNumber = cell !== null && typeof cell === "object" && "value" in cell;
      const isStyled = cell !== null && typeof cell === "object" && "text" in cell;
      const td = add(made, tag, isNumber ? ("error" in cell ? rounded(cell.value, cell.error) : shown(cell.value, cell.digits)) : isStyled ? cell.text : cell,
                     isNumber ? "" : "text " + ((isStyled && cell.name) || ""));
      if (isNumber && cell.value !== null && cell.value !== undefined) td.dataset.value = String(cell.value);
    }
    return made;
  }
  // Headers that end in "#" are of numbers.
  function table(parent, headers) {
    const made = add(add(parent, "div", null, "scroll"), "table");
    const head = add(made, "tr");
    for (const header of headers) {
      const isNumber = header.endsWith("#");
      const text = isNumber ? header.slice(0, -1) : header;
      add(head, text ? "th" : "td", text, isNumber ? "" : "text");
    }
    return made;
  }

  // Charts ------------------------------------------------------------------------------------------------
  // The colours of web/shared/style.css, light or dark as the reader has it.
  function colours() {
    const style = getComputedStyle(document.documentElement);
    const names = ["ink", "soft", "line", "good", "bad", "paper", "raised", "measured", "model", "second", "threshold", "faint", "grid"];
    return Object.fromEntries(names.map((name) => [name, style.getPropertyValue("--" + name).trim()]));
  }
  function width(parent) {
    return Math.max(260, Math.min(parent.clientWidth || 640, 1040));
  }
  // Options: x and y, labels; height; series; hooks; xScale, yScale; whole, for numbers that count; logs, for axes of powers of ten; bands;
  // legend; says, what a picture is to who cannot see it.
  function chart(parent, options, data) {
    const {ink, grid, line: tick} = colours();
    const powers = {values: (u, splits) => splits.map((v) => v !== null && Number.isInteger(Math.round(1e9 * Math.log10(v)) / 1e9) ? shown(v) : "")};
    const axis = (label) => ({label, labelSize: 20, font: "12px system-ui", labelFont: "12px system-ui", stroke: ink,
                              grid: {stroke: grid}, ticks: {stroke: tick}, ...(options.logs ? powers : {})});
    const plot = new uPlot({
      width: width(parent), height: options.height || 240, hooks: options.hooks || {}, bands: options.bands || [],
      legend: {show: options.legend !== false},
      scales: {x: {time: false, ...(options.xScale || {})}, y: options.yScale || {}},
      axes: [{...axis(options.x), size: 36, ...(options.whole ? {incrs: [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000]} : {})}, {...axis(options.y), size: 68}],
      series: [{label: options.x, value: (u, v) => shown(v, 5)}, ...options.series],
      cursor: {drag: {x: true, y: true, uni: 20}},
    }, data, parent);
    const canvas = plot.root.querySelector("canvas");
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", options.says || `${options.y} over ${options.x}`);
    return plot;
  }
  const nothing = () => null;
  const points = (label, colour) => ({label, stroke: colour, paths: nothing, value: (u, v) => shown(v, 5),
                                      points: {show: true, size: 5, fill: colour, stroke: colour}});
  const line = (label, colour, more = {}) => ({label, stroke: colour, width: 1.75, points: {show: false},
                                               value: (u, v) => shown(v, 5), ...more});
  // Lines across a chart at values of x or y: [{at, axis, colour, dash}]. `at` may be a function.
  function rules(list) {
    return {draw: [(u) => {
      const {ctx, bbox} = u;
      ctx.save();
      for (const rule of list) {
        const place = u.valToPos(typeof rule.at === "function" ? rule.at() : rule.at, rule.axis, true);
        ctx.strokeStyle = rule.colour;
        ctx.lineWidth = devicePixelRatio;
        ctx.setLineDash((rule.dash || []).map((d) => d * devicePixelRatio));
        ctx.beginPath();
        if (rule.axis === "x" && place >= bbox.left && place <= bbox.left + bbox.width) {
          ctx.moveTo(place, bbox.top);
          ctx.lineTo(place, bbox.top + bbox.height);
        } else if (rule.axis === "y" && place >= bbox.top && place <= bbox.top + bbox.height) {
          ctx.moveTo(bbox.left, place);
          ctx.lineTo(bbox.left + bbox.width, place);
        }
        ctx.stroke();
      }
      ctx.restore();
    }]};
  }
  function span(values, room = 0.05) {
    // In a loop: a function takes no more than some 100,000 arguments.
    let low = Infinity, high = -Infinity;
    for (const v of values) {
      if (v === null || Number.isNaN(v)) continue;
      low = Math.min(low, v);
      high = Math.max(high, v);
    }
    if (!(high > low)) {
      const middle = Number.isFinite(low) ? low : 0;
      [low, high] = [middle - 0.5, middle + 0.5];
    }
    return [low - room * (high - low), high + room * (high - low)];
  }

  // Tests of pages open them with "#check": how many charts and drawings have something on them, in data-painted.
  function countPainted() {
    if (!/^#check\b/.test(location.hash)) return;
    // A timer and no frame: a browser without a screen may never ask for one.
    setTimeout(() => {
      const painted = [...document.querySelectorAll("canvas")].filter((canvas) => canvas.getContext("2d")
          .getImageData(0, 0, canvas.width, canvas.height).data.some((value) => value !== 0));
      document.documentElement.dataset.painted = String(painted.length);
    }, 200);
  }

  return {complain, element, add, section, shown, rounded, small, counted, withUnit, row, table, colours, width, chart, points, line, rules, span,
          countPainted};
})();
