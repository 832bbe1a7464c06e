// Draws tiles of the map on canvases: ground, roads with lanes and marks, furniture, names.
const TILE = 512;
const EDGES_TO = 1 / 1.5; // m per pixel up to which carriageways have edges

/** Return place and scale of a tile. */
function viewOf(coords, scale, ratio) {
  return { scale: scale * ratio, ratio, west: (coords.x * TILE) / scale, north: (-coords.y * TILE) / scale, metres: TILE / scale };
}

function drawTile(context, data, view, look) {
  const margin = 28 / (view.scale / view.ratio);
  const box = [view.west - margin, view.north - view.metres - margin, view.west + view.metres + margin, view.north + margin];
  context.setTransform(view.scale, 0, 0, -view.scale, -view.west * view.scale, view.north * view.scale);
  const layers = look.layers;
  if (look.hill && layers.ground) drawHill(context, data, look.hill);
  const strips = stripsIn(data, ...box);
  const pixel = view.ratio / view.scale; // m of one CSS pixel
  const furniture = furnitureIn(data, box, strips, look, pixel);
  if (pixel > 3) {
    if (layers.roads) {
      drawLines(context, data, strips, look, pixel);
      for (const strip of strips) drawUnmeasured(context, data, strip, pixel);
    }
  } else {
    for (const strip of strips) {
      for (const draw of furniture.get(strip) || []) draw(context);
      if (layers.roads || layers.marks) drawStrip(context, data, strip, look, pixel);
    }
  }
  for (const draw of furniture.get(-1) || []) draw(context);
  if (layers.junctions) drawJunctions(context, data, box, look, pixel);
  if (layers.names) drawNames(context, data, box, look, view);
  if (layers.findings) drawFindings(context, data, box, look, pixel);
}

function drawHill(context, data, hill) {
  const at = data.info.terrain;
  context.save();
  context.imageSmoothingEnabled = true;
  context.translate(at.x - at.dx / 2, at.y + (at.ny - 0.5) * at.dy);
  context.scale(at.dx, -at.dy);
  context.drawImage(hill, 0, 0);
  context.restore();
}

/** At small scales: one line per road, all of one colour at once. */
function drawLines(context, data, strips, look, pixel) {
  const paths = new Map();
  const pathOf = (colour) => {
    if (!paths.has(colour)) paths.set(colour, new Path2D());
    return paths.get(colour);
  };
  for (const strip of strips) {
    const first = data.stationStart[strip], last = data.stationStart[strip + 1] - 1;
    if (last <= first) continue;
    const fixed = look.colour.lane ? look.colour.lane(strip, mainLane(data, strip)) : null;
    let colour = fixed || look.colour.station(first), path = pathOf(colour);
    let x = data.x[first], y = data.y[first];
    path.moveTo(x, y);
    for (let i = first + 1; i <= last; i++) {
      if (i < last && Math.abs(data.x[i] - x) + Math.abs(data.y[i] - y) < pixel) continue;
      const next = fixed || look.colour.station(i);
      if (next !== colour) { path = pathOf(next); path.moveTo(x, y); colour = next; }
      x = data.x[i]; y = data.y[i];
      path.lineTo(x, y);
    }
  }
  context.lineCap = "round"; context.lineJoin = "round";
  context.lineWidth = Math.max(1.4 * pixel, 8);
  for (const [colour, path] of paths) { context.strokeStyle = colour; context.stroke(path); }
}

/** Return the lane whose colour a strip has at small scales: the widest kind, a driving lane if there is one. */
function mainLane(data, strip) {
  for (let lane = data.laneStart[strip]; lane < data.laneStart[strip + 1]; lane++) {
    if (data.info.lane_types[data.laneType[lane]] === "driving") return lane;
  }
  return data.laneStart[strip];
}

function drawStrip(context, data, strip, look, pixel) {
  const lanes = data.laneStart[strip + 1] - data.laneStart[strip];
  if (!lanes) return;
  const rows = rowsOf(data, strip, pixel);
  context.lineJoin = "bevel"; context.setLineDash([]);
  context.lineWidth = 0.6 * pixel;
  if (!look.layers.roads) {
    // Marks alone.
  } else if (look.colour.lane) {
    let left = 0;
    for (let lane = 1; lane <= lanes; lane++) {
      const colour = look.colour.lane(strip, data.laneStart[strip] + left);
      if (lane < lanes && look.colour.lane(strip, data.laneStart[strip] + lane) === colour) continue;
      fillBand(context, data, strip, rows, 0, rows.length - 1, left, lane, colour);
      left = lane;
    }
  } else {
    let from = 0;
    const colourAt = (k) => look.colour.station(Math.floor((rows[k] + rows[k + 1]) / 2));
    for (let k = 1; k < rows.length; k++) {
      if (k < rows.length - 1 && colourAt(k) === colourAt(from)) continue;
      fillBand(context, data, strip, rows, from, k, 0, lanes, colourAt(from));
      from = k;
    }
  }
  if (look.layers.roads && pixel < EDGES_TO && data.roadJunction[data.stripRoad[strip]] < 0) drawEdges(context, data, strip, rows, lanes, look, pixel);
  if (look.layers.marks && pixel * data.info.drawing.marks_from <= 1) drawMarks(context, data, strip, rows, pixel);
  if (look.layers.roads) drawUnmeasured(context, data, strip, pixel);
}

/** Strokes across the road where no elevation model measured its height. */
function drawUnmeasured(context, data, strip, pixel) {
  const stretches = data.info.unmeasured[data.stripRoad[strip]];
  if (!stretches) return;
  const borders = data.laneStart[strip + 1] - data.laneStart[strip] + 1, base = data.borderStart[strip] - data.stationStart[strip] * borders;
  const last = data.stationStart[strip + 1] - 1, apart = Math.max(4, 9 * pixel);
  let i = data.stationStart[strip];
  context.beginPath();
  for (let s = apart * (Math.floor(data.s[i] / apart) + 0.5); s <= data.s[last]; s += apart) {
    if (s < data.s[i] || !stretches.some(([from, to]) => s >= from && s <= to)) continue;
    while (i < last - 1 && data.s[i + 1] < s) i++;
    const share = (s - data.s[i]) / ((data.s[i + 1] - data.s[i]) || 1);
    const at = (values, border) => values[base + i * borders + border] * (1 - share) + values[base + (i + 1) * borders + border] * share;
    const x = (at(data.bx, 0) + at(data.bx, borders - 1)) / 2, y = (at(data.by, 0) + at(data.by, borders - 1)) / 2;
    let dx = (at(data.bx, 0) - at(data.bx, borders - 1)) / 2, dy = (at(data.by, 0) - at(data.by, borders - 1)) / 2;
    const size = Math.hypot(dx, dy) || 1e-9, wide = Math.max(1, (4 * pixel) / size);
    dx *= wide; dy *= wide;
    context.moveTo(x + dx + 0.7 * dy, y + dy - 0.7 * dx);
    context.lineTo(x - dx - 0.7 * dy, y - dy + 0.7 * dx);
  }
  context.setLineDash([]); context.lineWidth = 1.5 * pixel; context.strokeStyle = "#f0323c"; context.stroke();
}

/** Return the stations of a strip that are corners at this scale. */
function rowsOf(data, strip, pixel) {
  const first = data.stationStart[strip], last = data.stationStart[strip + 1] - 1;
  if (pixel < 0.2) return Array.from({ length: last - first + 1 }, (_, k) => first + k);
  const rows = [first];
  for (let i = first + 1; i < last; i++) {
    const before = rows[rows.length - 1];
    if (Math.abs(data.x[i] - data.x[before]) + Math.abs(data.y[i] - data.y[before]) > 2 * pixel) rows.push(i);
  }
  if (last > first) rows.push(last);
  return rows;
}

function fillBand(context, data, strip, rows, from, to, left, right, colour) {
  const borders = data.laneStart[strip + 1] - data.laneStart[strip] + 1;
  const base = data.borderStart[strip] - data.stationStart[strip] * borders;
  context.beginPath();
  for (let k = from; k <= to; k++) context.lineTo(data.bx[base + rows[k] * borders + left], data.by[base + rows[k] * borders + left]);
  for (let k = to; k >= from; k--) context.lineTo(data.bx[base + rows[k] * borders + right], data.by[base + rows[k] * borders + right]);
  context.closePath();
  context.fillStyle = colour; context.strokeStyle = colour;
  context.fill(); context.stroke();
}

function traceBorder(context, data, strip, rows, border) {
  const borders = data.laneStart[strip + 1] - data.laneStart[strip] + 1;
  const base = data.borderStart[strip] - data.stationStart[strip] * borders + border;
  context.beginPath();
  for (const i of rows) context.lineTo(data.bx[base + i * borders], data.by[base + i * borders]);
}

function drawEdges(context, data, strip, rows, lanes, look, pixel) {
  context.lineWidth = 0.5 * pixel; context.strokeStyle = look.edge;
  for (const border of [0, lanes]) { traceBorder(context, data, strip, rows, border); context.stroke(); }
}

/** Road marks: widths and dashes in metres, but never too thin to be seen. */
function drawMarks(context, data, strip, rows, pixel) {
  const first = data.markStart[strip], last = data.markStart[strip + 1] - 1, rule = data.info.drawing;
  context.lineWidth = Math.max(rule.mark_width, 0.5 * pixel);
  for (let k = first; k <= last; k++) {
    // Those on the outermost borders are moved inwards, or they could not be seen on the paper.
    const inward = 0.5 * context.lineWidth * ((k === first) - (k === last));
    for (const [aside, broken, colour] of data.info.marks[data.mark[k]]) {
      context.strokeStyle = colour;
      context.setLineDash(broken ? [rule.dash, rule.gap] : []);
      context.beginPath();
      for (const [x, y] of besideBorder(data, strip, rows, k - first, aside + inward)) context.lineTo(x, y);
      context.stroke();
    }
  }
  context.setLineDash([]);
}

/** Return places (x, y, z) at a distance to the right of a border. */
function besideBorder(data, strip, rows, border, aside) {
  const borders = data.laneStart[strip + 1] - data.laneStart[strip] + 1;
  const base = data.borderStart[strip] - data.stationStart[strip] * borders + border;
  const at = (k) => base + rows[Math.max(0, Math.min(rows.length - 1, k))] * borders;
  return rows.map((_, k) => {
    const here = at(k), before = at(k - 1), after = at(k + 1);
    const dx = data.bx[after] - data.bx[before], dy = data.by[after] - data.by[before], length = Math.hypot(dx, dy) || 1;
    return [data.bx[here] + (aside * dy) / length, data.by[here] - (aside * dx) / length, data.bz[here]];
  });
}

/** A ring in the middle of each junction. */
function drawJunctions(context, data, box, look, pixel) {
  if (pixel > 0.8 || pixel < 0.06) return;
  const { x, y } = data.info.junctions;
  context.lineWidth = 1.4 * pixel; context.strokeStyle = look.ink; context.fillStyle = look.halo;
  for (let k = 0; k < x.length; k++) {
    if (x[k] === null || !inBox(box, x[k], y[k], 8 * pixel)) continue;
    context.beginPath(); context.arc(x[k], y[k], 3.2 * pixel, 0, 7); context.fill(); context.stroke();
  }
}

function inBox(box, x, y, margin) {
  return x >= box[0] - margin && x <= box[2] + margin && y >= box[1] - margin && y <= box[3] + margin;
}

/** Names along the roads: placed once per zoom for the whole map, so that tiles agree. */
function drawNames(context, data, box, look, view) {
  const scale = view.scale / view.ratio;
  if (scale < 0.4) return;
  context.save();
  context.setTransform(view.ratio, 0, 0, view.ratio, 0, 0);
  context.font = "600 11px system-ui, sans-serif"; context.textAlign = "center"; context.textBaseline = "middle";
  context.lineJoin = "round"; context.lineWidth = 3; context.strokeStyle = look.halo; context.fillStyle = look.ink;
  for (const label of namesAt(data, scale)) {
    if (!inBox(box, label.x, label.y, 90 / scale)) continue;
    context.save();
    context.translate((label.x - view.west) * scale, (view.north - label.y) * scale);
    context.rotate(label.angle);
    context.strokeText(label.text, 0, 0); context.fillText(label.text, 0, 0);
    context.restore();
  }
  context.restore();
}

const nameCache = new Map();

function namesAt(data, scale) {
  if (nameCache.has(scale)) return nameCache.get(scale);
  const taken = new Map(), used = new Map(), out = [];
  for (const road of data.namedRoads) {
    const text = data.info.road.name[road].slice(0, 60), width = 6.4 * text.length;
    if (data.roadLength[road] * scale < 0.9 * width) continue;
    const middle = middleOf(data, road);
    const px = middle.x * scale, py = middle.y * scale;
    const near = used.get(text) || [];
    if (near.some(([a, b]) => Math.hypot(a - px, b - py) < 420)) continue;
    const cells = new Set();
    for (let k = -width / 2; k <= width / 2; k += 12) {
      cells.add(Math.round((px + k * Math.cos(middle.angle)) / 16) + ":" + Math.round((py + k * Math.sin(middle.angle)) / 16));
    }
    if (Array.from(cells).some((key) => taken.has(key))) continue;
    for (const key of cells) {
      const [a, b] = key.split(":").map(Number);
      for (const i of [-1, 0, 1]) for (const j of [-1, 0, 1]) taken.set(a + i + ":" + (b + j), true);
    }
    near.push([px, py]); used.set(text, near);
    let angle = -middle.angle;
    if (Math.cos(angle) < 0) angle += Math.PI;
    out.push({ text, x: middle.x, y: middle.y, angle });
  }
  nameCache.set(scale, out);
  return out;
}

/** Return the middle of a road, and its heading there. */
function middleOf(data, road) {
  const first = data.stationStart[data.roadStrip[road]], last = data.stationStart[data.roadStrip[road + 1]] - 1;
  const half = (data.s[first] + data.s[last]) / 2;
  let i = first;
  while (i < last - 1 && data.s[i + 1] <= half) i++;
  const gap = data.s[i + 1] - data.s[i], share = gap > 0 ? (half - data.s[i]) / gap : 0;
  return {
    x: data.x[i] + share * ((data.x[i + 1] ?? data.x[i]) - data.x[i]),
    y: data.y[i] + share * ((data.y[i + 1] ?? data.y[i]) - data.y[i]), angle: data.heading[i],
  };
}

/** Shade the ground of the elevation model, lit from the north-west. */
function hillOf(data, dark) {
  const at = data.info.terrain;
  if (!at) return null;
  const canvas = el("canvas", { width: at.nx, height: at.ny });
  const context = canvas.getContext("2d"), image = context.createImageData(at.nx, at.ny);
  const fade = Math.max(2, 0.06 * Math.max(at.nx, at.ny));
  const z = (i, j) => data.terrain[Math.max(0, Math.min(at.ny - 1, j)) * at.nx + Math.max(0, Math.min(at.nx - 1, i))];
  for (let j = 0; j < at.ny; j++) {
    for (let i = 0; i < at.nx; i++) {
      const east = (z(i + 1, j) - z(i - 1, j)) / (2 * at.dx), north = (z(i, j + 1) - z(i, j - 1)) / (2 * at.dy);
      const light = (0.7 + 0.5 * (east - north)) / Math.sqrt(1 + east * east + north * north);
      const k = 4 * ((at.ny - 1 - j) * at.nx + i);
      if (!Number.isFinite(light)) continue;
      const tone = dark ? 18 + 26 * light : 190 + 62 * Math.min(1, light);
      image.data.set([tone, tone + (dark ? 3 : 1), tone + (dark ? 6 : -3), 255 * Math.min(1, (1 + Math.min(i, j, at.nx - 1 - i, at.ny - 1 - j)) / fade)], k);
    }
  }
  context.putImageData(image, 0, 0);
  return canvas;
}
