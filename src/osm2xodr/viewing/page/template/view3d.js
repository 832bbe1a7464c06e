// Roads in three dimensions, by three.js, which is unpacked when this view is first opened.

async function loadThree() {
  const parts = JSON.parse(new TextDecoder().decode(await inflated("three-data")));
  const address = (text) => URL.createObjectURL(new Blob([text], { type: "text/javascript" }));
  const core = address(parts.core);
  const three = address(parts.module.replaceAll("./three.core.min.js", core));
  const controls = address(parts.controls.replace(/from 'three'/g, `from '${three}'`));
  return { THREE: await import(three), ...(await import(controls)) };
}

const DETAILS_TO = 3000; // m: from farther away marks and furniture are too small to be seen
const SIGN_FOOT = 2.2, SIGN_HALF = 0.5; // m: where signs hang if the file does not say, and half their size

class RoadScene {
  constructor(data, actions, library) {
    const { THREE, OrbitControls } = library;
    this.data = data;
    this.details = [];
    this.actions = actions;
    this.THREE = THREE;
    this.renderer = new THREE.WebGLRenderer({ canvas: $("canvas"), antialias: true, preserveDrawingBuffer: true });
    this.scene = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(45, 1, 1, 1e6);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, $("canvas"));
    this.controls.maxPolarAngle = 0.495 * Math.PI;
    this.controls.zoomToCursor = true;
    this.controls.listenToKeyEvents($("canvas"));
    this.controls.addEventListener("change", () => this.draw());
    this.light = new Daylight(THREE, this.scene, this.renderer, data.bodyFace.length / 3);
    this.world = new THREE.Group();
    this.scene.add(this.world);
    this.base = this.lowest();
    this.addRoads();
    this.addLines();
    this.addBodies();
    this.addFindings();
    new ResizeObserver(() => this.resize()).observe($("scene"));
    $("exaggeration").addEventListener("input", () => this.exaggerate());
    this.listenForClicks();
    this.exaggerate();
    this.resize();
  }

  lowest() {
    let low = Infinity;
    for (const z of this.data.z) if (z < low) low = z;
    return Number.isFinite(low) ? low : 0;
  }

  /** Two rows of corners per lane, so that each lane has its own colour. */
  addRoads() {
    const data = this.data, strips = data.stripRoad.length;
    let corners = 0, triangles = 0;
    for (let strip = 0; strip < strips; strip++) {
      const stations = data.stationStart[strip + 1] - data.stationStart[strip], lanes = data.laneStart[strip + 1] - data.laneStart[strip];
      corners += 2 * stations * lanes;
      triangles += 2 * Math.max(0, stations - 1) * lanes;
    }
    const places = new Float32Array(3 * corners), index = new Uint32Array(3 * triangles);
    this.faceStrip = new Int32Array(strips + 1);
    let corner = 0, face = 0;
    for (let strip = 0; strip < strips; strip++) {
      const first = data.stationStart[strip], last = data.stationStart[strip + 1];
      const borders = data.laneStart[strip + 1] - data.laneStart[strip] + 1;
      for (let lane = 0; lane < borders - 1; lane++) {
        for (let i = first; i < last; i++) {
          const at = data.borderStart[strip] + (i - first) * borders + lane;
          for (const k of [at, at + 1]) {
            places[3 * corner] = data.bx[k]; places[3 * corner + 1] = data.by[k]; places[3 * corner + 2] = data.bz[k] - this.base;
            corner++;
          }
          if (i + 1 < last) {
            // Counter-clockwise as seen from above.
            index.set([corner - 2, corner - 1, corner, corner, corner - 1, corner + 1], 3 * face);
            face += 2;
          }
        }
      }
      this.faceStrip[strip + 1] = face;
    }
    const { BufferGeometry, BufferAttribute, Mesh, MeshLambertMaterial, DoubleSide } = this.THREE;
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(places, 3));
    geometry.setAttribute("color", new BufferAttribute(new Uint8Array(3 * corners), 3, true));
    geometry.setIndex(new BufferAttribute(index, 1));
    geometry.computeVertexNormals();
    this.roads = new Mesh(geometry, new MeshLambertMaterial({ vertexColors: true, side: DoubleSide }));
    this.world.add(this.roads);
  }

  /** A line along every road, so that roads can be seen where they are thinner than a pixel. */
  addLines() {
    const data = this.data, places = new Float32Array(3 * data.x.length), index = [];
    for (let strip = 0; strip < data.stripRoad.length; strip++) {
      const borders = data.laneStart[strip + 1] - data.laneStart[strip] + 1;
      for (let i = data.stationStart[strip]; i < data.stationStart[strip + 1]; i++) {
        const row = data.borderStart[strip] + (i - data.stationStart[strip]) * borders, last = row + borders - 1;
        places.set([(data.bx[row] + data.bx[last]) / 2, (data.by[row] + data.by[last]) / 2, (data.bz[row] + data.bz[last]) / 2 - this.base + 0.1], 3 * i);
        if (i + 1 < data.stationStart[strip + 1]) index.push(i, i + 1);
      }
    }
    const { BufferGeometry, BufferAttribute, LineSegments, LineBasicMaterial } = this.THREE;
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(places, 3));
    geometry.setAttribute("color", new BufferAttribute(new Uint8Array(places.length), 3, true));
    geometry.setIndex(index);
    this.lines = new LineSegments(geometry, new LineBasicMaterial({ vertexColors: true }));
    this.world.add(this.lines);
  }

  addTerrain() {
    const at = this.data.info.terrain;
    if (!at) return;
    const { BufferGeometry, BufferAttribute, Mesh, MeshLambertMaterial, DoubleSide } = this.THREE;
    const { places, index } = groundMesh(this.data);
    for (let k = 2; k < places.length; k += 3) places[k] -= this.base;
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(places, 3));
    geometry.setIndex(index);
    geometry.computeVertexNormals();
    // Behind the roads where both have one height, and slightly translucent, so that tunnels can be seen.
    this.terrain = new Mesh(geometry, new MeshLambertMaterial({ side: DoubleSide, transparent: true, opacity: 0.72, polygonOffset: true, polygonOffsetFactor: 2, polygonOffsetUnits: 40 }));
    this.terrain.renderOrder = 2;
    this.world.add(this.terrain);
  }

  /** The scene of the page, or else its lanes above the grid of the ground. */
  addBodies() {
    this.bodies = bodyMeshes(this.data, this.base, this.THREE);
    if (!this.hasBodies()) { this.addTerrain(); return; }
    for (const group of Object.values(this.bodies)) this.world.add(group);
    $("exaggeration").value = "1";
  }

  hasBodies() { return this.data.info.bodies.length > 0; }

  /** Points of a size in pixels, over everything: what is found, and what is marked. */
  points(places, colours, size) {
    const three = this.THREE, geometry = new three.BufferGeometry();
    geometry.setAttribute("position", new three.BufferAttribute(Float32Array.from(places), 3));
    geometry.setAttribute("color", new three.BufferAttribute(Float32Array.from(colours), 3));
    const points = new three.Points(geometry, new three.PointsMaterial({ size, sizeAttenuation: false, vertexColors: true, depthTest: false, transparent: true }));
    points.renderOrder = 4;
    this.world.add(points);
    return points;
  }

  addFindings() {
    const places = [], colours = [], { findings, severities } = this.data.info;
    for (const [severity, , , , , x, y] of findings) {
      if (x === null) continue;
      const found = nearest(this.data, x, y, 30), z = found ? between(this.data.z, found) : this.base;
      places.push(x, y, (Number.isFinite(z) ? z : this.base) - this.base + 1.5);
      const colour = new this.THREE.Color(severities[severity]);
      colours.push(colour.r, colour.g, colour.b);
    }
    this.findings = this.points(places, colours, 11);
  }

  /** Mark signals: the first one is the one that was chosen. */
  highlight(signals) {
    if (this.spots) { this.world.remove(this.spots); this.spots.geometry.dispose(); this.spots = null; }
    const places = [], colours = [];
    signals.forEach((k, rank) => {
      const [, x, y, z, , foot] = this.data.info.signals[k], colour = new this.THREE.Color(rank ? "#00b7c7" : "#d6007f");
      places.push(x, y, (z ?? this.base) - this.base + (foot > 0.3 ? foot : SIGN_FOOT) + 1.6);
      colours.push(colour.r, colour.g, colour.b);
    });
    if (places.length) this.spots = this.points(places, colours, 13);
    this.draw();
  }

  show(look) {
    const built = look.built && this.hasBodies(), [west, south, east, north] = this.data.info.bounds;
    if (!built) this.paintLanes(look);
    this.light.show(built, look.ground, Math.max(2000, east - west, north - south));
    dress(this.bodies, built, look.dark);
    const { layers } = look;
    for (const [mesh, shown] of [[this.roads, layers.roads && !built], [this.lines, layers.roads && !built], [this.findings, layers.findings], [this.terrain, layers.ground]]) {
      if (mesh) mesh.visible = Boolean(shown);
    }
    for (const [layer, group] of Object.entries(this.bodies)) group.visible = Boolean(layers[layer]) && (layer !== "roads" || built);
    this.details = ["marks", "objects", "signals"].map((layer) => this.bodies[layer]).filter((group) => group?.visible);
    if (this.terrain) this.terrain.material.color.set(look.dark ? "#4a5347" : "#b9c2ab");
    this.draw();
  }

  /** Give lanes the colours of a mode. */
  paintLanes(look) {
    const data = this.data, colours = this.roads.geometry.getAttribute("color"), array = colours.array;
    const cache = new Map();
    const number = (colour) => {
      if (!cache.has(colour)) cache.set(colour, colour.startsWith("#") ? rgbOf(colour) : colour.match(/\d+/g).map(Number));
      return cache.get(colour);
    };
    // Colours are given in sRGB; three.js computes with linear light.
    const linear = Float32Array.from({ length: 256 }, (_, k) => 255 * (k / 255) ** 2.2);
    const lines = this.lines.geometry.getAttribute("color");
    let corner = 0;
    for (let strip = 0; strip < data.stripRoad.length; strip++) {
      const main = mainLane(data, strip);
      for (let i = data.stationStart[strip]; i < data.stationStart[strip + 1]; i++) {
        const colour = number(look.colour.lane ? look.colour.lane(strip, main) : look.colour.station(i));
        for (let k = 0; k < 3; k++) lines.array[3 * i + k] = linear[colour[k]];
      }
      for (let lane = data.laneStart[strip]; lane < data.laneStart[strip + 1]; lane++) {
        for (let i = data.stationStart[strip]; i < data.stationStart[strip + 1]; i++) {
          const [r, g, b] = number(look.colour.lane ? look.colour.lane(strip, lane) : look.colour.station(i));
          for (let k = 0; k < 2; k++, corner++) { array[3 * corner] = linear[r]; array[3 * corner + 1] = linear[g]; array[3 * corner + 2] = linear[b]; }
        }
      }
    }
    colours.needsUpdate = lines.needsUpdate = true;
  }

  exaggerate() {
    const factor = Number($("exaggeration").value);
    $("exaggeration-out").textContent = String(factor);
    this.world.scale.z = factor;
    this.light.lit = null;
    this.draw();
  }

  resize() {
    const box = $("scene");
    if (!box.clientWidth || !box.clientHeight) return;
    this.renderer.setPixelRatio(Math.min(2, window.devicePixelRatio || 1));
    this.renderer.setSize(box.clientWidth, box.clientHeight, false);
    this.camera.aspect = box.clientWidth / box.clientHeight;
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  /** Look at a place from the south, so that a number of metres is in view. */
  look(x, y, metres) {
    const found = nearest(this.data, x, y, metres);
    const z = (found ? between(this.data.z, found) - this.base : 0) * this.world.scale.z;
    this.controls.target.set(x, y, z);
    this.camera.position.set(x - 0.25 * metres, y - 0.75 * metres, z + 0.62 * metres);
    this.controls.update();
    this.draw();
  }

  /** Mark the pieces of a path, or nothing. */
  select(pieces) {
    if (this.pick) { this.world.remove(this.pick); this.pick.geometry.dispose(); this.pick = null; }
    const places = [];
    for (const side of [0, 1]) {
      const lines = pieces.map((piece) => edgeOf(this.data, piece, side));
      for (const line of lines) for (let k = 0; k + 1 < line.length; k++) places.push(...line[k], ...line[k + 1]);
    }
    for (let k = 2; k < places.length; k += 3) places[k] += 0.3 - this.base;
    if (places.length) {
      const geometry = new this.THREE.BufferGeometry();
      geometry.setAttribute("position", new this.THREE.BufferAttribute(Float32Array.from(places), 3));
      this.pick = new this.THREE.LineSegments(geometry, new this.THREE.LineBasicMaterial({ color: 0xd6007f, depthTest: false, transparent: true }));
      this.pick.renderOrder = 3;
      this.world.add(this.pick);
    }
    this.draw();
  }

  listenForClicks() {
    let down = null;
    $("canvas").addEventListener("pointerdown", (event) => { down = [event.clientX, event.clientY]; });
    $("canvas").addEventListener("pointerup", (event) => {
      if (!down || Math.hypot(event.clientX - down[0], event.clientY - down[1]) > 4) return;
      const box = $("canvas").getBoundingClientRect();
      const at = new this.THREE.Vector2((2 * (event.clientX - box.left)) / box.width - 1, 1 - (2 * (event.clientY - box.top)) / box.height);
      const ray = new this.THREE.Raycaster();
      ray.setFromCamera(at, this.camera);
      // What hides a road hides it from clicks as well; lanes are there to be found although surfaces are seen.
      const hidden = [this.bodies.buildings, this.bodies.ground].filter((group) => group?.visible && !group.children[0].material.transparent);
      const before = ray.intersectObjects(hidden)[0]?.distance ?? Infinity;
      const shown = this.roads.visible || this.bodies.roads?.visible, found = shown ? ray.intersectObject(this.roads)[0] : undefined;
      const hit = found && found.distance < before + 1 ? found : undefined, sign = this.signalAt(ray, Math.min(before, hit?.distance ?? Infinity) + 1);
      if (sign >= 0) this.actions.openSignal(sign);
      else if (hit && !this.actions.routeClick(hit.point.x, hit.point.y, event.shiftKey)) this.actions.openRoad(this.data.stripRoad[this.stripOf(hit.faceIndex)]);
    });
  }

  /** Return the nearest signal that a ray meets before a distance; -1 for none. */
  signalAt(ray, before) {
    let best = -1, least = before;
    if (!this.bodies.signals?.visible) return best;
    this.data.info.signals.forEach(([, x, y, z, , foot], k) => {
      const place = new this.THREE.Vector3(x, y, ((z ?? this.base) - this.base + (foot > 0.3 ? foot : SIGN_FOOT) + SIGN_HALF) * this.world.scale.z);
      const distance = place.distanceTo(this.camera.position);
      if (distance < least && ray.ray.distanceToPoint(place) < Math.max(SIGN_HALF, 0.006 * distance)) { best = k; least = distance; }
    });
    return best;
  }

  stripOf(face) {
    let low = 0, high = this.faceStrip.length - 1;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (this.faceStrip[middle] <= face) low = middle; else high = middle;
    }
    return low;
  }

  draw() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      const near = this.camera.position.distanceTo(this.controls.target) < DETAILS_TO;
      for (const group of this.details) group.visible = near;
      const away = this.camera.position.distanceTo(this.controls.target);
      this.camera.near = Math.max(0.2, away / 300); this.camera.far = 40 * away + 3e4;
      this.camera.updateProjectionMatrix();
      this.light.follow(this.camera, this.controls.target);
      this.renderer.render(this.scene, this.camera);
    });
  }
}
