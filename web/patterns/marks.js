// A colour and a shape for every pattern: either alone tells them apart.
const patternMarks = (() => {
  const GLYPHS = ["●", "■", "▲", "✕", "◆", "✚", "▼", "○"];
  const style = getComputedStyle(document.documentElement);
  const COLOURS = GLYPHS.map((glyph, k) => style.getPropertyValue(`--p${k}`).trim());

  // Corners about the origin, in half widths; of strokes that are open, pairs of ends.
  const SHAPES = [
    null,
    {corners: [[-0.85, -0.85], [0.85, -0.85], [0.85, 0.85], [-0.85, 0.85]]},
    {corners: [[0, -1], [0.95, 0.8], [-0.95, 0.8]]},
    {strokes: [[-0.8, -0.8, 0.8, 0.8], [-0.8, 0.8, 0.8, -0.8]]},
    {corners: [[0, -1.1], [0.9, 0], [0, 1.1], [-0.9, 0]]},
    {strokes: [[-1, 0, 1, 0], [0, -1, 0, 1]]},
    {corners: [[0, 1], [0.95, -0.8], [-0.95, -0.8]]},
    null,
  ];

  // On a canvas; half: half the width, in its pixels. Ink: another colour than the pattern's own.
  function draw(ctx, pattern, x, y, half, ink) {
    const shape = SHAPES[pattern];
    ctx.fillStyle = ctx.strokeStyle = ink || COLOURS[pattern];
    ctx.lineWidth = Math.max(1, 0.45 * half);
    ctx.beginPath();
    if (!shape) {
      ctx.arc(x, y, 0.9 * half, 0, 2 * Math.PI);
    } else if (shape.corners) {
      for (const [dx, dy] of shape.corners) ctx.lineTo(x + half * dx, y + half * dy);
      ctx.closePath();
    } else {
      for (const [ax, ay, bx, by] of shape.strokes) {
        ctx.moveTo(x + half * ax, y + half * ay);
        ctx.lineTo(x + half * bx, y + half * by);
      }
    }
    if (pattern === 7 || (shape && shape.strokes)) ctx.stroke();
    else ctx.fill();
  }

  // A pie of shares, its parts in the order of patterns from the top on; with one part its mark.
  function drawShares(ctx, shares, x, y, radius) {
    const only = shares.findIndex((share) => share === 1);
    if (only >= 0) {
      draw(ctx, only, x, y, radius);
      return;
    }
    let from = -0.5 * Math.PI;
    shares.forEach((share, pattern) => {
      if (!(share > 0)) return;
      const to = from + 2 * Math.PI * share;
      ctx.fillStyle = COLOURS[pattern];
      ctx.beginPath();
      ctx.moveTo(x, y);
      ctx.arc(x, y, radius, from, to);
      ctx.fill();
      from = to;
    });
  }

  // The name of a pattern behind its glyph.
  function named(parent, pattern, name, tag = "span") {
    const made = kit.add(parent, tag);
    kit.add(made, "span", GLYPHS[pattern] + " ").style.color = COLOURS[pattern];
    made.append(name);
    return made;
  }

  // What the marks mean, of those that are there.
  function key(parent, names, there) {
    const line = kit.add(parent, "p", null, "key");
    names.forEach((name, pattern) => { if (there.has(pattern)) named(line, pattern, name); });
    return line;
  }

  // A choice among texts, with its label in front.
  function choice(parent, label, texts, chosen) {
    const made = kit.add(kit.add(parent, "label", label + " "), "select");
    texts.forEach((text, k) => { kit.add(made, "option", text).value = k; });
    made.value = chosen;
    return made;
  }

  return {COLOURS, draw, drawShares, named, key, choice};
})();
