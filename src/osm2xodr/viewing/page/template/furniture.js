// Furniture on the map: objects, signs and lights as pictures of `render` show them; pins of findings.
const OVERHEAD = 3; // m: a strip higher than something by more than this is above it

/** Return what draws the furniture of a tile: by the strip before which it is drawn, and -1 after all strips. */
function furnitureIn(data, box, strips, look, pixel) {
  const found = new Map();
  if (pixel * data.info.drawing.furniture_from > 1) return found;
  const put = (x, y, z, draw) => {
    const at = strips.find((strip) => {
      const [west, south, east, north] = data.stripBox.subarray(4 * strip, 4 * strip + 4);
      return data.stripHeight[strip] > z + OVERHEAD && west <= x && x <= east && south <= y && y <= north;
    });
    const key = at === undefined ? -1 : at;
    if (!found.has(key)) found.set(key, []);
    found.get(key).push(draw);
  };
  if (look.layers.objects) {
    for (let k = 0; k < data.objectX.length; k++) {
      const b = data.objectBox;
      if (!(b[4 * k] <= box[2] && b[4 * k + 2] >= box[0] && b[4 * k + 1] <= box[3] && b[4 * k + 3] >= box[1])) continue;
      put(data.objectX[k], data.objectY[k], data.objectZ[k], (context) => drawObject(context, data, k, pixel));
    }
  }
  if (look.layers.signals) {
    const size = symbolSize(data, pixel);
    data.info.signals.forEach(([, x, y, z, , , , , face], k) => {
      if (inBox(box, x, y, size)) put(x, y, z ?? 0, (context) => drawSymbol(context, data.info.faces[face], x, y, size));
    });
  }
  return found;
}

/** Return the size of symbols, m. */
function symbolSize(data, pixel) {
  const rule = data.info.drawing;
  return Math.min(Math.max(rule.symbol, rule.smallest_symbol * pixel), rule.largest_symbol * pixel);
}

function drawObject(context, data, object, pixel) {
  for (let form = data.objectForm[object]; form < data.objectForm[object + 1]; form++) {
    const first = data.formStart[form], last = data.formStart[form + 1], colour = data.info.form_colours[data.formColour[form]];
    context.beginPath();
    if (data.formKind[form] === 1) {
      context.arc(data.formX[first], data.formY[first], Math.max(data.formSize[form], data.formLeast[form] * pixel), 0, 7);
    } else {
      for (let k = first; k < last; k++) context.lineTo(data.formX[k], data.formY[k]);
    }
    if (data.formKind[form] === 2) {
      context.setLineDash([]);
      context.lineWidth = Math.max(data.formSize[form], 0.5 * pixel); context.strokeStyle = colour; context.stroke();
    } else { context.fillStyle = colour; context.fill(); }
  }
}

/** Draw a face whose corners run to the right and down; with `down` -1 on a canvas whose y runs down. */
function drawSymbol(context, face, x, y, size, down = 1) {
  for (const [corners, colour] of face) {
    context.beginPath();
    for (let k = 0; k < corners.length; k += 2) context.lineTo(x + size * corners[k], y - down * size * corners[k + 1]);
    context.fillStyle = colour; context.fill();
  }
}

/** Findings are pins, with their tips at the place: nothing that stands on a road looks so. */
function drawFindings(context, data, box, look, pixel) {
  for (const finding of data.findingOrder) {
    const [severity, , , , , x, y] = data.info.findings[finding];
    if (x !== null && inBox(box, x, y, 20 * pixel)) drawPin(context, x, y, pixel, data.info.severities[severity]);
  }
}

function drawPin(context, x, y, pixel, colour, down = 1) {
  const at = (u, v) => [x + u * pixel, y + down * v * pixel];
  context.setLineDash([]);
  context.beginPath();
  context.moveTo(...at(0, 0));
  for (let k = 0; k <= 12; k++) { const turn = (-0.2 + (1.4 * k) / 12) * Math.PI; context.lineTo(...at(6 * Math.cos(turn), 12 + 6 * Math.sin(turn))); }
  context.closePath();
  context.fillStyle = colour; context.fill();
  context.lineWidth = 1.5 * pixel; context.strokeStyle = "#ffffff"; context.stroke();
  context.beginPath(); context.moveTo(...at(0, 15.5)); context.lineTo(...at(0, 11)); context.moveTo(...at(0, 9.4)); context.lineTo(...at(0, 8));
  context.lineWidth = 1.8 * pixel; context.stroke();
}
