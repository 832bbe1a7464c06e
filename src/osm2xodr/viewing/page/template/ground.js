// The ground in 3D: the grid of the elevation model, finer beside roads, and below every lane that is not in a tunnel.
const BED = 0.25; // m that the ground lies below lanes at least
const FINEST = 1.5; // m, of the finer grid
const MOST_CELLS = 160000; // of the finer grid
const COVER = 12; // m: deeper lanes are in a tunnel if the file names none

/** Return corners (x, y, z, m) and triangles of the ground. */
function groundMesh(data) {
  const at = data.info.terrain, tiles = lanePieces(data, Math.min(at.dx, at.dy));
  const near = new Set();
  for (const [west, south, east, north] of tiles) {
    eachCell(at, west, south, east, north, at.dx, at.dy, (i, j) => {
      for (const di of [-1, 0, 1]) for (const dj of [-1, 0, 1]) near.add(j + dj + ":" + (i + di));
    }, at.nx - 1, at.ny - 1);
  }
  const most = Math.ceil(Math.min(at.dx, at.dy) / FINEST);
  const parts = Math.max(1, Math.min(most, Math.floor(Math.sqrt(MOST_CELLS / Math.max(1, near.size)))));
  const lowest = lowered(data, at, parts), columns = (at.nx - 1) * parts + 1;
  const places = [], index = [], numbers = new Map();
  const height = (i, j) => data.terrain[j * at.nx + i];
  const corner = (u, v) => {
    const key = v * columns + u;
    if (!numbers.has(key)) {
      numbers.set(key, places.length / 3);
      const i = Math.min(at.nx - 2, Math.floor(u / parts)), j = Math.min(at.ny - 2, Math.floor(v / parts)), a = u / parts - i, b = v / parts - j;
      const z = (1 - b) * ((1 - a) * height(i, j) + a * height(i + 1, j)) + b * ((1 - a) * height(i, j + 1) + a * height(i + 1, j + 1));
      places.push(at.x + (u / parts) * at.dx, at.y + (v / parts) * at.dy, Math.min(z, lowest.get(key) ?? Infinity));
    }
    return numbers.get(key);
  };
  for (let j = 0; j + 1 < at.ny; j++) for (let i = 0; i + 1 < at.nx; i++) {
    if (![height(i, j), height(i + 1, j), height(i, j + 1), height(i + 1, j + 1)].every(Number.isFinite)) continue;
    // Cells beside those that were lowered are as fine as these, so that no gap opens between them.
    const step = near.has(j + ":" + i) ? 1 : parts;
    for (let v = j * parts; v < (j + 1) * parts; v += step) for (let u = i * parts; u < (i + 1) * parts; u += step) {
      const a = corner(u, v), b = corner(u + step, v), c = corner(u, v + step), d = corner(u + step, v + step);
      index.push(a, b, c, b, d, c);
    }
  }
  return { places: Float32Array.from(places), index };
}

/** Return how high the corners of the finer grid may be beside lanes, by corner. */
function lowered(data, at, parts) {
  const lowest = new Map(), columns = (at.nx - 1) * parts + 1, dx = at.dx / parts, dy = at.dy / parts;
  for (const [west, south, east, north, z] of lanePieces(data, Math.min(dx, dy))) {
    eachCell(at, west, south, east, north, dx, dy, (i, j) => {
      for (const key of [j * columns + i, j * columns + i + 1, (j + 1) * columns + i, (j + 1) * columns + i + 1]) {
        if (!(lowest.get(key) <= z - BED)) lowest.set(key, z - BED);
      }
    }, columns - 1, (at.ny - 1) * parts);
  }
  return lowest;
}

function eachCell(at, west, south, east, north, dx, dy, visit, columns, rows) {
  const clip = (value, most) => Math.max(0, Math.min(most - 1, Math.floor(value)));
  if (east < at.x || north < at.y || west > at.x + columns * dx || south > at.y + rows * dy) return;
  for (let j = clip((south - at.y) / dy, rows); j <= clip((north - at.y) / dy, rows); j++) {
    for (let i = clip((west - at.x) / dx, columns); i <= clip((east - at.x) / dx, columns); i++) visit(i, j);
  }
}

/** Cut what lies open to the sky of the roads into pieces of a size, m: west, south, east, north, lowest z of each. */
function* lanePieces(data, size) {
  for (let strip = 0; strip < data.stripRoad.length; strip++) {
    const borders = data.laneStart[strip + 1] - data.laneStart[strip] + 1;
    if (borders < 2) continue;
    for (let i = data.stationStart[strip]; i + 1 < data.stationStart[strip + 1]; i++) {
      if (isCovered(data, strip, i) && isCovered(data, strip, i + 1)) continue;
      const row = data.borderStart[strip] + (i - data.stationStart[strip]) * borders;
      const corners = [row, row + borders - 1, row + borders, row + 2 * borders - 1].map((k) => [data.bx[k], data.by[k], data.bz[k]]);
      if (!corners.flat().every(Number.isFinite)) continue;
      const [a, b, c, d] = corners;
      const long = Math.min(1000, Math.ceil(Math.max(Math.hypot(c[0] - a[0], c[1] - a[1]), Math.hypot(d[0] - b[0], d[1] - b[1])) / size)) || 1;
      const wide = Math.min(1000, Math.ceil(Math.max(Math.hypot(b[0] - a[0], b[1] - a[1]), Math.hypot(d[0] - c[0], d[1] - c[1])) / size)) || 1;
      const point = (u, v) => [0, 1, 2].map((k) => (1 - u) * ((1 - v) * a[k] + v * b[k]) + u * ((1 - v) * c[k] + v * d[k]));
      for (let u = 0; u < long; u++) for (let v = 0; v < wide; v++) {
        const four = [point(u / long, v / wide), point((u + 1) / long, v / wide), point(u / long, (v + 1) / wide), point((u + 1) / long, (v + 1) / wide)];
        const of = (k) => four.map((place) => place[k]);
        yield [Math.min(...of(0)), Math.min(...of(1)), Math.max(...of(0)), Math.max(...of(1)), Math.min(...of(2))];
      }
    }
  }
}

/** Whether a station lies in a tunnel: as named, or deep below the ground if none is named. */
function isCovered(data, strip, station) {
  const road = data.stripRoad[strip], s = data.s[station], { structures } = data.info;
  if (!Number.isFinite(data.z[station])) return true;
  if (data.namesTunnels) return (structures[road] || []).some(([kind, from, to]) => kind === "tunnel" && s >= from - 0.01 && s <= to + 0.01);
  return data.z[station] < data.ground[station] - COVER;
}
