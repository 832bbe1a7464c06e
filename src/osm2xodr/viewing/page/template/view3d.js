// Roads in three dimensions, by three.js, which is unpacked when this view is first opened.

async function loadThree() {
  const parts = JSON.parse(new TextDecoder().decode(await inflated("three-data")));
  const address = (text) => URL.createObjectURL(new Blob([text], { type: "text/javascript" }));
  const core = address(parts.core);
  const three = address(parts.module.replaceAll("./three.core.min.js", core));
  const controls = address(parts.controls.replace(/from 'three'/g, `from '${three}'`));
  return { THREE: await import(three), ...(await import(controls)) };
}

class RoadScene {
  constructor(data, actions, library) {
    const { THREE, OrbitControls } = library;
    this.data = data;
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
    this.scene.add(new THREE.HemisphereLight(0xffffff, 0x8a8f86, 2.2));
    const sun = new THREE.DirectionalLight(0xffffff, 1.6);
    sun.position.set(-1, 1, 2);
    this.scene.add(sun);
    this.world = new THREE.Group();
    this.scene.add(this.world);
    this.base = this.lowest();
    this.addRoads();
    this.addLines();
    this.addTerrain();
    new ResizeObserver(() => this.resize()).observe($("scene"));
    $("exaggeration").addEventListener("input", () => this.exaggerate());
    $("ground").addEventListener("change", () => { this.terrain.visible = $("ground").checked; this.draw(); });
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
    const places = new Float32Array(3 * at.nx * at.ny), index = [];
    const low = this.base, ground = this.cutGround(at);
    for (let j = 0; j < at.ny; j++) for (let i = 0; i < at.nx; i++) {
      const k = j * at.nx + i, z = ground[k];
      places.set([at.x + i * at.dx, at.y + j * at.dy, (Number.isFinite(z) ? z : low) - low], 3 * k);
      if (i + 1 < at.nx && j + 1 < at.ny) {
        const others = [k, k + 1, k + at.nx, k + at.nx + 1];
        if (others.every((m) => Number.isFinite(this.data.terrain[m]))) index.push(k, k + 1, k + at.nx, k + 1, k + at.nx + 1, k + at.nx);
      }
    }
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(places, 3));
    geometry.setIndex(index);
    geometry.computeVertexNormals();
    // Behind the roads where both have one height, and slightly translucent, so that tunnels can be seen.
    this.terrain = new Mesh(geometry, new MeshLambertMaterial({ side: DoubleSide, transparent: true, opacity: 0.72, polygonOffset: true, polygonOffsetFactor: 2, polygonOffsetUnits: 40 }));
    this.terrain.renderOrder = 2;
    this.world.add(this.terrain);
    $("ground-label").hidden = false;
  }

  /** Lower the points of the grid beside roads below these: the grid is too coarse for the bed of a road. */
  cutGround(at) {
    const data = this.data, ground = Float32Array.from(data.terrain);
    for (let i = 0; i < data.x.length; i++) {
      if (!(Math.abs(data.z[i] - data.ground[i]) < 12)) continue;
      const column = Math.floor((data.x[i] - at.x) / at.dx), row = Math.floor((data.y[i] - at.y) / at.dy);
      for (const k of [row * at.nx + column, row * at.nx + column + 1, (row + 1) * at.nx + column, (row + 1) * at.nx + column + 1]) {
        if (ground[k] > data.z[i] - 0.7) ground[k] = data.z[i] - 0.7;
      }
    }
    return ground;
  }

  show(look) {
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
    this.scene.background = new this.THREE.Color(look.ground);
    if (this.terrain) this.terrain.material.color.set(look.dark ? "#4a5347" : "#b9c2ab");
    this.draw();
  }

  exaggerate() {
    const factor = Number($("exaggeration").value);
    $("exaggeration-out").textContent = String(factor);
    this.world.scale.z = factor;
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
    this.camera.near = metres / 400; this.camera.far = metres * 40 + 3e4;
    this.camera.updateProjectionMatrix();
    this.controls.update();
    this.draw();
  }

  select(road) {
    if (this.pick) { this.world.remove(this.pick); this.pick.geometry.dispose(); this.pick = null; }
    if (road < 0) { this.draw(); return; }
    const data = this.data, points = [[], []];
    for (let strip = data.roadStrip[road]; strip < data.roadStrip[road + 1]; strip++) {
      const borders = data.laneStart[strip + 1] - data.laneStart[strip] + 1;
      for (let row = data.borderStart[strip]; row < data.borderStart[strip + 1]; row += borders) {
        [row, row + borders - 1].forEach((k, side) => points[side].push(new this.THREE.Vector3(data.bx[k], data.by[k], data.bz[k] - this.base + 0.3)));
      }
    }
    const geometry = new this.THREE.BufferGeometry().setFromPoints(points[0].concat(points[1].reverse(), points[0].slice(0, 1)));
    this.pick = new this.THREE.Line(geometry, new this.THREE.LineBasicMaterial({ color: 0xd6007f, depthTest: false }));
    this.pick.renderOrder = 3;
    this.world.add(this.pick);
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
      const hit = ray.intersectObject(this.roads)[0];
      if (hit) this.actions.openRoad(this.data.stripRoad[this.stripOf(hit.faceIndex)]);
    });
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
    requestAnimationFrame(() => { this.waiting = false; this.renderer.render(this.scene, this.camera); });
  }
}
