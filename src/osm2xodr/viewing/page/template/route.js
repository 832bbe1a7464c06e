// Routes along lanes in the direction of traffic, and paths that a profile is drawn along.
const CHANGE = 0.01; // m that a change of lanes counts, so that none is made without need

/** A heap of [cost, value], the least first. */
class Heap {
  constructor() { this.items = []; }

  push(item) {
    const items = this.items;
    let k = items.push(item) - 1;
    while (k > 0) {
      const above = (k - 1) >> 1;
      if (items[above][0] <= item[0]) break;
      items[k] = items[above]; k = above;
    }
    items[k] = item;
  }

  pop() {
    const items = this.items, top = items[0], last = items.pop();
    if (!items.length) return top;
    let k = 0;
    for (;;) {
      let below = 2 * k + 1;
      if (below >= items.length) break;
      if (below + 1 < items.length && items[below + 1][0] < items[below][0]) below++;
      if (items[below][0] >= last[0]) break;
      items[k] = items[below]; k = below;
    }
    items[k] = last;
    return top;
  }
}

/** Lanes that cars drive on as a graph: a node is twice a lane, plus 1 against s. */
class LaneGraph {
  constructor(data) {
    this.data = data;
    const nodes = 2 * data.laneType.length;
    this.stepFirst = new Int32Array(nodes + 1);
    for (const node of data.stepStart) this.stepFirst[node + 1]++;
    for (let k = 0; k < nodes; k++) this.stepFirst[k + 1] += this.stepFirst[k];
    const next = this.stepFirst.slice();
    this.steps = new Int32Array(data.stepEnd.length);
    data.stepStart.forEach((node, k) => { this.steps[next[node]++] = data.stepEnd[k]; });
    this.laneStrip = new Int32Array(data.laneType.length);
    for (let strip = 0; strip < data.stripRoad.length; strip++) this.laneStrip.fill(strip, data.laneStart[strip], data.laneStart[strip + 1]);
  }

  ends(strip) {
    return [this.data.s[this.data.stationStart[strip]], this.data.s[this.data.stationStart[strip + 1] - 1]];
  }

  /** Return the nodes of a strip in a direction, 0 along s. */
  nodesOf(strip, direction) {
    const nodes = [];
    for (let lane = this.data.laneStart[strip]; lane < this.data.laneStart[strip + 1]; lane++) {
      if (this.data.laneTraffic[lane] & (direction + 1)) nodes.push(2 * lane + direction);
    }
    return nodes;
  }

  /**
   * Return the shortest way from a place to another, each a strip and s, as pieces {road, from, to} in order; null if
   * no lane leads there. One starts in either direction of traffic, and may change to any lane of the same direction.
   */
  route(a, b) {
    const data = this.data, cost = new Map(), moves = new Map(), done = new Set(), heap = new Heap();
    const reach = (node, value, move) => {
      if (value < (cost.get(node) ?? Infinity)) { cost.set(node, value); moves.set(node, move); heap.push([value, node]); }
    };
    let best = null, least = Infinity;
    for (const direction of [0, 1]) {
      const start = this.nodesOf(a.strip, direction), [low, high] = this.ends(a.strip);
      const ahead = direction ? a.s - b.s : b.s - a.s;
      if (start.length && a.strip === b.strip && ahead >= 0 && ahead < least) { least = ahead; best = -1; }
      for (const node of start) this.eachStep(node, (next) => reach(next, direction ? a.s - low : high - a.s, { from: -1, leaves: direction ? low : high }));
    }
    while (heap.items.length) {
      const [value, node] = heap.pop();
      if (value >= least) break;
      if (done.has(node)) continue;
      done.add(node);
      const strip = this.laneStrip[node >> 1], direction = node & 1, [low, high] = this.ends(strip);
      if (strip === b.strip) {
        const whole = value + (direction ? high - b.s : b.s - low);
        if (whole < least) { least = whole; best = node; }
      }
      for (const other of this.nodesOf(strip, direction)) if (other !== node) reach(other, value + CHANGE, { from: node, changes: true });
      this.eachStep(node, (next) => reach(next, value + high - low, { from: node }));
    }
    return best === null ? null : this.pieces(a, b, best, moves);
  }

  /** Return the pieces of a way that ends on a node, or that leads straight on if that is -1. */
  pieces(a, b, best, moves) {
    const pieces = [], nodes = [];
    const add = (strip, from, to) => {
      const road = this.data.stripRoad[strip], last = pieces[pieces.length - 1];
      if (last && last.road === road && Math.abs(last.to - from) < 0.02 && (to >= from) === (last.to >= last.from)) last.to = to;
      else pieces.push({ road, from, to });
    };
    // A change of lanes stays on the strip.
    for (let node = best; node !== -1; node = moves.get(node).from) if (!moves.get(node).changes) nodes.unshift(node);
    add(a.strip, a.s, nodes.length ? moves.get(nodes[0]).leaves : b.s);
    nodes.forEach((node, k) => {
      const strip = this.laneStrip[node >> 1], [low, high] = this.ends(strip), back = node & 1;
      add(strip, back ? high : low, k === nodes.length - 1 ? b.s : back ? low : high);
    });
    return pieces;
  }

  eachStep(node, visit) {
    for (let k = this.stepFirst[node]; k < this.stepFirst[node + 1]; k++) visit(this.steps[k]);
  }
}

/** Return the one piece that a whole road is. */
function wholeRoad(data, road) {
  const first = data.stationStart[data.roadStrip[road]], last = data.stationStart[data.roadStrip[road + 1]] - 1;
  return last > first ? [{ road, from: data.s[first], to: data.s[last] }] : [];
}

/** Return what a profile shows along a path: columns of values, and the distance at which each piece begins: that of a road is its s. */
function along(data, pieces, isRoute) {
  const out = { d: [], s: [], road: [], x: [], y: [], z: [], ground: [], grade: [], begins: [] };
  let distance = isRoute ? 0 : pieces[0].from;
  for (const { road, from, to } of pieces) {
    out.begins.push(distance);
    const low = Math.min(from, to), high = Math.max(from, to), sign = to >= from ? 1 : -1, rows = [];
    const first = data.stationStart[data.roadStrip[road]], last = data.stationStart[data.roadStrip[road + 1]] - 1;
    let passed = -Infinity;
    const add = (station, share, s) => { rows.push({ station, share }); passed = s; };
    for (let i = first; i <= last; i++) {
      const s = data.s[i], next = i < last ? data.s[i + 1] : s;
      if (s < low && low < next && low > passed) add(i, (low - s) / (next - s), low);
      // Each place once: where sections meet there are two stations.
      if (s >= low && s <= high && s > passed) add(i, 0, s);
      if (s < high && high < next && high > passed) add(i, (high - s) / (next - s), high);
    }
    if (sign < 0) rows.reverse();
    for (const row of rows) {
      const value = (array) => (row.share ? between(array, row) : array[row.station]), s = value(data.s);
      out.d.push(distance + Math.abs(s - from)); out.s.push(s); out.road.push(road);
      out.x.push(value(data.x)); out.y.push(value(data.y)); out.z.push(value(data.z));
      out.ground.push(value(data.ground)); out.grade.push(sign * value(data.grade));
    }
    distance += high - low;
  }
  out.length = distance - (out.begins[0] || 0);
  return out;
}
