// Marks, paint, objects, signs and lights in 3D: simple bodies, each layer one mesh.
const LIFT = 0.04; // m of paint above the road
const HEIGHTS = { tree: 6, streetLamp: 7, pole: 4, vegetation: 1.2, building: 6, barrier: 1, railing: 1, soundBarrier: 3, trafficIsland: 0.15, gantry: 6 };
const SIGN_POLE = 0.04; // m, half its width
const STREET_LAMP = 0.25; // m, radius of its head

// Colours are given in sRGB; three.js computes with linear light.
const LINEAR = Uint8Array.from({ length: 256 }, (_, k) => Math.round(255 * (k / 255) ** 2.2));

/** Collects triangles with colours. */
class Body {
  constructor(base) {
    this.base = base;
    this.faces = 0;
    this.places = new Float32Array(9 * 1024);
    this.colours = new Uint8Array(9 * 1024);
  }

  triangle(a, b, c, colour) {
    let at = 9 * this.faces++;
    if (at === this.places.length) {
      const grown = [new Float32Array(2 * at), new Uint8Array(2 * at)];
      grown[0].set(this.places); grown[1].set(this.colours);
      [this.places, this.colours] = grown;
    }
    for (let corner = 0; corner < 3; corner++, at += 3) {
      const place = corner === 0 ? a : corner === 1 ? b : c;
      this.places[at] = place[0]; this.places[at + 1] = place[1]; this.places[at + 2] = place[2] - this.base;
      for (let k = 0; k < 3; k++) this.colours[at + k] = LINEAR[colour[k]];
    }
  }

  quad(a, b, c, d, colour) { this.triangle(a, b, c, colour); this.triangle(a, c, d, colour); }

  /** A wall between two closed lines of one size, and its lid. */
  prism(corners, low, high, colour, three) {
    const shade = colour.map((value) => Math.round(0.82 * value));
    corners.forEach(([x, y], k) => {
      const [u, v] = corners[(k + 1) % corners.length];
      this.quad([x, y, low], [u, v, low], [u, v, high], [x, y, high], shade);
    });
    this.flat(corners.map(([x, y]) => [x, y, high]), colour, three);
  }

  /** An area with corners in space. */
  flat(corners, colour, three) {
    const points = corners.map(([x, y]) => new three.Vector2(x, y));
    for (const face of three.ShapeUtils.triangulateShape(points, [])) this.triangle(...face.map((k) => corners[k]), colour);
  }

  cone(x, y, low, high, radius, top, colour, sides = 7) {
    const ring = (r, z) => Array.from({ length: sides }, (_, k) => [x + r * Math.cos((2 * Math.PI * k) / sides), y + r * Math.sin((2 * Math.PI * k) / sides), z]);
    const below = ring(radius, low), above = ring(top, high);
    below.forEach((corner, k) => {
      const next = (k + 1) % sides, shade = colour.map((value) => Math.round(value * (0.8 + (0.2 * k) / sides)));
      this.quad(corner, below[next], above[next], above[k], shade);
    });
    for (let k = 1; top > 0 && k + 1 < sides; k++) this.triangle(above[0], above[k], above[k + 1], colour);
  }

  /** Return the mesh; paint lies nearer than the road below it, and shows its colours as they are. */
  mesh(three, { lifted = false, lit = true } = {}) {
    const geometry = new three.BufferGeometry();
    geometry.setAttribute("position", new three.BufferAttribute(this.places.slice(0, 9 * this.faces), 3));
    geometry.setAttribute("color", new three.BufferAttribute(this.colours.slice(0, 9 * this.faces), 3, true));
    if (lit) geometry.computeVertexNormals();
    const nearer = lifted ? { polygonOffset: true, polygonOffsetFactor: -2, polygonOffsetUnits: -20 } : {};
    return new three.Mesh(geometry, new three[lit ? "MeshLambertMaterial" : "MeshBasicMaterial"]({ vertexColors: true, side: three.DoubleSide, ...nearer }));
  }
}

/** Return the height of the surface at a place: of the highest lane not far from a height, or that height. */
function surfaceAt(data, x, y, near) {
  let best = -Infinity;
  for (const strip of stripsIn(data, x, y, x, y)) {
    const found = nearestOn(data, strip, x, y);
    if (!found || found.distance > 0.05) continue;
    const z = between(data.z, found) + found.t * Math.sin(data.roll[found.station]);
    if (Math.abs(z - near) < 2 && z > best) best = z;
  }
  return Number.isFinite(best) ? best : near;
}

/** Lane marks as ribbons. */
function markBody(data, base) {
  const body = new Body(base), rule = data.info.drawing, half = rule.mark_width / 2;
  for (let strip = 0; strip < data.stripRoad.length; strip++) {
    const first = data.stationStart[strip], rows = Array.from({ length: data.stationStart[strip + 1] - first }, (_, k) => first + k);
    const start = data.markStart[strip], last = data.markStart[strip + 1] - 1;
    for (let k = start; k <= last; k++) {
      for (const [aside, broken, colour] of data.info.marks[data.mark[k]]) {
        const inward = half * ((k === start) - (k === last)), shade = rgbOf(colour);
        const left = besideBorder(data, strip, rows, k - start, aside + inward - half), right = besideBorder(data, strip, rows, k - start, aside + inward + half);
        ribbon(body, left, right, broken ? rule : null, shade);
      }
    }
  }
  return body;
}

/** A strip between two lines, whole or in dashes. */
function ribbon(body, left, right, dashes, colour) {
  const mix = (line, k, share) => {
    const a = line[k], b = line[k + 1];
    return [a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1]), a[2] + share * (b[2] - a[2]) + LIFT];
  };
  const period = dashes ? dashes.dash + dashes.gap : 0;
  let distance = 0;
  for (let k = 0; k + 1 < left.length; k++) {
    const length = Math.hypot(left[k + 1][0] - left[k][0], left[k + 1][1] - left[k][1]);
    if (!(length > 0 && Number.isFinite(length + left[k][2] + left[k + 1][2]))) continue;
    const solid = !dashes || length > 1e5;
    for (let n = solid ? 0 : Math.floor(distance / period); solid ? n === 0 : n * period < distance + length; n++) {
      const from = solid ? 0 : Math.max(0, n * period - distance) / length, to = solid ? 1 : Math.min(length, n * period + dashes.dash - distance) / length;
      if (to > from) body.quad(mix(left, k, from), mix(right, k, from), mix(right, k, to), mix(left, k, to), colour);
    }
    distance += length;
  }
}

/** Paint on the road, and bodies that stand beside it. */
function objectBodies(data, base, three) {
  const paint = new Body(base), solid = new Body(base);
  for (let k = 0; k < data.objectX.length; k++) {
    const type = data.info.object_types[k], ground = Number.isFinite(data.objectZ[k]) ? data.objectZ[k] : base;
    const low = ground + (data.objectFoot[k] || 0), own = data.objectHeight[k];
    const height = own >= 0 ? own : HEIGHTS[type] || 0;
    for (let form = data.objectForm[k]; form < data.objectForm[k + 1]; form++) {
      const colour = rgbOf(data.info.form_colours[data.formColour[form]]), corners = [];
      for (let i = data.formStart[form]; i < data.formStart[form + 1]; i++) corners.push([data.formX[i], data.formY[i]]);
      const draped = () => corners.map(([x, y]) => [x, y, surfaceAt(data, x, y, ground) + LIFT]);
      if (data.formKind[form] === 1) standing(solid, type, ...corners[0], low, height || 0.5, data.formSize[form], colour);
      else if (data.formKind[form] === 2) {
        const line = draped(), half = data.formSize[form] / 2, side = (sign) => line.map(([x, y, z], i) => {
          const a = line[Math.max(0, i - 1)], b = line[Math.min(line.length - 1, i + 1)], length = Math.hypot(b[0] - a[0], b[1] - a[1]) || 1;
          return [x + (sign * half * (b[1] - a[1])) / length, y - (sign * half * (b[0] - a[0])) / length, z - LIFT];
        });
        ribbon(paint, side(-1), side(1), null, colour);
      } else if (height > 0.05) solid.prism(corners, low, low + height, colour, three);
      else paint.flat(draped(), colour, three);
    }
  }
  return [paint, solid];
}

/** A tree, a lamp or a pole. */
function standing(body, type, x, y, low, height, radius, colour) {
  if (type === "tree") {
    body.cone(x, y, low, low + 0.35 * height, 0.12, 0.12, [110, 84, 60], 5);
    body.cone(x, y, low + 0.25 * height, low + 0.65 * height, 0.55 * radius, radius, colour);
    body.cone(x, y, low + 0.65 * height, low + height, radius, 0, colour);
  } else {
    body.cone(x, y, low, low + height, Math.min(radius, 0.1), Math.min(radius, 0.06), type === "streetLamp" ? [90, 96, 102] : colour, 5);
    if (type === "streetLamp") body.cone(x, y, low + height - 0.2, low + height, STREET_LAMP, STREET_LAMP, colour, 6);
  }
}

/** Faces on poles; also the signal of each triangle. */
function signalBody(data, base, three) {
  const body = new Body(base), owner = [];
  data.info.signals.forEach(([, x, y, z, heading, foot, tall, , face], k) => {
    const ground = z ?? base, turn = heading ?? 0, symbol = data.info.faces[face];
    const across = [-Math.sin(turn), Math.cos(turn)], ahead = [Math.cos(turn), Math.sin(turn)];
    let half = 0.1;
    for (const [corners] of symbol) corners.forEach((value, i) => { if (i % 2) half = Math.max(half, Math.abs(value)); });
    const size = tall > 0.1 && tall < 5 ? tall / (2 * half) : data.info.drawing.symbol / 2;
    // The foot of a signal is its lower edge; unstated, it hangs 2.2 m above the road.
    const middle = ground + (foot > 0.3 ? foot : 2.2) + size * half;
    const square = [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([u, v]) => [x + SIGN_POLE * u - 0.06 * ahead[0], y + SIGN_POLE * v - 0.06 * ahead[1]]);
    body.prism(square, ground, middle + size * half, [110, 116, 122], three);
    symbol.forEach(([corners, colour], layer) => {
      const points = [], flat = [], out = 0.02 * (layer + 1);
      for (let i = 0; i < corners.length; i += 2) {
        // Seen from the front, right is the face's own left.
        points.push([x + size * corners[i] * across[0] + out * ahead[0], y + size * corners[i] * across[1] + out * ahead[1], middle - size * corners[i + 1]]);
        flat.push(new three.Vector2(corners[i], corners[i + 1]));
      }
      for (const triangle of three.ShapeUtils.triangulateShape(flat, [])) {
        body.triangle(...triangle.map((i) => points[i]), rgbOf(colour));
        // The back is a plate.
        if (!layer) body.triangle(...triangle.map((i) => [points[i][0] - out * ahead[0], points[i][1] - out * ahead[1], points[i][2]]), [128, 134, 140]);
      }
    });
    while (owner.length < body.faces) owner.push(k);
  });
  return { body, owner };
}
