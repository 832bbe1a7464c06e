// The scene in 3D, as `export --scene` makes it: meshes of one layer and one material, with the colours of a clear day.
const SMOOTH = new Set(["ground", "roads"]); // layers whose triangles show no edges
const LIFTED = new Set(["marks"]); // layers that lie on others, and are drawn before them
const EARTH = [0.3, 0.22, 0.12]; // linear colour of steep ground
const STEEP = [0.86, 0.6]; // cosine of the slopes from which on, and up to which, ground turns to earth
const SHADOW = 2048; // pixels of a side of the shadows' map: a second at most where no graphics card draws it
const SHADOWS_TO = 2e6; // triangles: scenes of more have no shadows
const PALE = "#dcdad4"; // what stands beside roads where these have the colours of data

/** Return the meshes of a page's scene by layer. */
function bodyMeshes(data, base, three) {
  const layers = {};
  let vertex = 0, corner = 0;
  for (const [layer, material, colour, roughness, vertices, faces] of data.info.bodies) {
    const places = new Float32Array(3 * vertices);
    for (let k = 0; k < vertices; k++, vertex++) places.set([data.bodyX[vertex], data.bodyY[vertex], data.bodyZ[vertex] - base], 3 * k);
    const geometry = new three.BufferGeometry();
    geometry.setAttribute("position", new three.BufferAttribute(places, 3));
    geometry.setIndex(new three.BufferAttribute(Uint32Array.from(data.bodyFace.subarray(corner, corner + 3 * faces)), 1));
    corner += 3 * faces;
    if (SMOOTH.has(layer)) geometry.computeVertexNormals();
    const natural = layer === "ground" && material === "grass";
    if (natural) geometry.setAttribute("color", new three.BufferAttribute(groundColours(geometry, colour, three), 3));
    const lift = LIFTED.has(layer) || material.startsWith("marking") ? -2 : 0;
    const look = {
      color: natural ? "#ffffff" : colour, vertexColors: natural, side: three.DoubleSide, shadowSide: three.DoubleSide, flatShading: !SMOOTH.has(layer),
      polygonOffset: lift !== 0, polygonOffsetFactor: lift, polygonOffsetUnits: 10 * lift,
    };
    const mesh = new three.Mesh(geometry, roughness < 0.4 ? new three.MeshPhongMaterial({ ...look, shininess: 60, specular: "#8899a6" }) : new three.MeshLambertMaterial(look));
    mesh.castShadow = lift === 0;
    mesh.receiveShadow = true;
    mesh.userData = { material, natural, colour };
    (layers[layer] ??= new three.Group()).add(mesh);
  }
  return layers;
}

/** Return linear colours of ground: grass that varies a little from place to place, earth where it is steep. */
function groundColours(geometry, colour, three) {
  const place = geometry.getAttribute("position").array, normal = geometry.getAttribute("normal").array, out = new Float32Array(place.length);
  const grass = new three.Color(colour).toArray();
  for (let k = 0; k < place.length; k += 3) {
    const x = place[k], y = place[k + 1], up = Math.abs(normal[k + 2]);
    const dry = 0.5 + 0.5 * patches(x / 70, y / 70), shade = 1 + 0.09 * patches(x / 23 + 40, y / 23) + 0.05 * patches(x / 7, y / 7 + 40);
    const share = Math.min(1, Math.max(0, (STEEP[0] - up) / (STEEP[0] - STEEP[1])));
    for (let c = 0; c < 3; c++) {
      const green = grass[c] * (1 + dry * [0.28, 0.1, 0.02][c]);
      out[k + c] = shade * (green + share * (EARTH[c] - green));
    }
  }
  return out;
}

/** Smooth noise, -1 to 1. */
function patches(x, y) {
  const i = Math.floor(x), j = Math.floor(y), u = x - i, v = y - j, a = u * u * (3 - 2 * u), b = v * v * (3 - 2 * v);
  const at = (m, n) => { const s = Math.sin(127.1 * m + 311.7 * n) * 43758.5453; return 2 * (s - Math.floor(s)) - 1; };
  return (1 - b) * ((1 - a) * at(i, j) + a * at(i + 1, j)) + b * ((1 - a) * at(i, j + 1) + a * at(i + 1, j + 1));
}

/** Give meshes their own colours, or pale ones beside roads that show data. */
function dress(layers, built, dark) {
  for (const [layer, group] of Object.entries(layers)) {
    for (const mesh of group.children) {
      const { natural, colour, material } = mesh.userData, pale = !built && ["ground", "buildings", "structures"].includes(layer) && material !== "water";
      mesh.material.vertexColors = natural && !pale;
      mesh.material.color.set(pale ? (layer === "ground" ? (dark ? "#4a5347" : "#b9c2ab") : dark ? "#6b6f74" : PALE) : natural ? "#ffffff" : colour);
      // Tunnels can be seen through the ground below data.
      mesh.material.transparent = pale && layer === "ground";
      mesh.material.opacity = mesh.material.transparent ? 0.8 : 1;
      mesh.renderOrder = mesh.material.transparent ? 2 : 0;
      mesh.material.needsUpdate = true;
    }
  }
}

/** The light of a clear afternoon: sky, haze, and a sun that casts shadows around what is looked at. */
class Daylight {
  constructor(three, scene, renderer, triangles) {
    this.three = three; this.scene = scene; this.renderer = renderer; this.shadows = triangles <= SHADOWS_TO;
    this.sky = new three.HemisphereLight(0xffffff, 0x8a8f86, 2.2);
    this.sky.position.set(-0.4, 0.45, 0.8); // Not quite from above: sides in the shade differ.
    this.sun = new three.DirectionalLight(0xffffff, 1.6);
    this.sun.shadow.mapSize.set(SHADOW, SHADOW);
    this.sun.shadow.bias = -0.0004;
    this.dome = this.makeDome();
    this.haze = new three.Fog("#dde7ee", 1, 2);
    scene.add(this.sky, this.sun, this.sun.target, this.dome);
    renderer.shadowMap.type = three.PCFShadowMap;
    renderer.shadowMap.autoUpdate = false;
    this.lit = null;
  }

  makeDome() {
    const three = this.three, geometry = new three.SphereGeometry(1, 24, 24).rotateX(Math.PI / 2), place = geometry.getAttribute("position");
    const stops = [[-1, "#c9d3d6"], [-0.02, "#dde7ee"], [0.04, "#dde7ee"], [0.25, "#b4d0ea"], [1, "#6d9fd2"]], colours = [];
    for (let k = 0; k < place.count; k++) {
      const z = place.getZ(k), above = stops.findIndex(([at]) => at >= z), [b, high] = stops[Math.max(1, above)], [a, low] = stops[Math.max(1, above) - 1];
      new three.Color(low).lerp(new three.Color(high), (z - a) / (b - a)).toArray(colours, 3 * k);
    }
    geometry.setAttribute("color", new three.BufferAttribute(new Float32Array(colours), 3));
    const dome = new three.Mesh(geometry, new three.MeshBasicMaterial({ vertexColors: true, side: three.BackSide, fog: false, depthWrite: false, depthTest: false }));
    dome.renderOrder = -10;
    dome.frustumCulled = false;
    return dome;
  }

  /** Change between the light of a day and one without shadows, for colours that can be compared. */
  show(built, background, extent) {
    this.built = built;
    this.dome.visible = built;
    this.sun.castShadow = this.renderer.shadowMap.enabled = built && this.shadows;
    this.scene.background = built ? null : new this.three.Color(background);
    this.scene.fog = built ? this.haze : null;
    this.haze.near = 1.5 * extent; this.haze.far = 7 * extent;
    this.sky.color.set(built ? "#d3e3f6" : "#ffffff"); this.sky.groundColor.set(built ? "#b3a893" : "#8a8f86");
    this.sky.intensity = built ? 1.35 : 1.8;
    this.sun.color.set(built ? "#fff0d8" : "#ffffff"); this.sun.intensity = built ? 2.9 : 1.6;
    this.lit = null;
    if (!built) { this.sun.target.position.set(0, 0, 0); this.sun.position.set(-1, 1, 2); }
  }

  /** Move sky and shadows with the camera; shadows stay while it moves little. */
  follow(camera, target) {
    if (!this.built) return;
    const far = 0.9 * camera.far, distance = camera.position.distanceTo(target), reach = Math.min(2500, Math.max(60, 1.1 * distance));
    this.dome.position.copy(camera.position);
    this.dome.scale.setScalar(far);
    if (this.lit && this.lit.at.distanceTo(target) < 0.25 * this.lit.reach && reach < 1.3 * this.lit.reach && reach > 0.6 * this.lit.reach) return;
    this.lit = { at: target.clone(), reach };
    const sun = this.sun, box = sun.shadow.camera, turn = (248 * Math.PI) / 180, height = (38 * Math.PI) / 180;
    const direction = new this.three.Vector3(Math.sin(turn) * Math.cos(height), Math.cos(turn) * Math.cos(height), Math.sin(height));
    sun.target.position.copy(target);
    sun.position.copy(target).addScaledVector(direction, 4 * reach + 1500);
    Object.assign(box, { left: -reach, right: reach, top: reach, bottom: -reach, near: 1, far: 8 * reach + 3000 });
    box.updateProjectionMatrix();
    sun.shadow.normalBias = reach / 1000;
    this.renderer.shadowMap.needsUpdate = true;
  }
}
