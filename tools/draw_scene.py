"""Draw a scene of ``osm2xodr export --scene`` in perspective, with a sun that casts shadows.

Makes ``docs/images/scene.png`` (docs/scene.md has the command). Needs Chromium (``make browser``) and selenium (the
extra ``test``).

    osm2xodr export area.xodr --scene scene --dem dem.tif --osm area.osm
    python tools/draw_scene.py scene --eye=-120,40,30 --look=60,10,0 -o scene.png
"""

from __future__ import annotations

import argparse
import base64
import functools
import json
import shutil
import tempfile
import threading
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

from selenium import webdriver
from selenium.webdriver.chrome.service import Service

VENDOR = Path(__file__).parents[1] / "src/osm2xodr/viewing/page/vendor"
FLAGS = ("--headless", "--no-sandbox", "--disable-dev-shm-usage", "--use-angle=swiftshader")
PATIENCE = 300.0  # For drawing in software, s

# Colours of glTF are linear; so are those of lights. All else are choices.
PAGE = """<!doctype html><meta charset="utf-8"><script type="module">
import * as THREE from "./three.module.js";
const view = await (await fetch("view.json")).json();
const world = new THREE.Scene();
const sky = new THREE.Color(view.sky);
world.background = sky;
world.fog = new THREE.Fog(sky, view.clear, view.far);

const solids = [];
for (const name of view.tiles) {
  const data = await (await fetch(name)).arrayBuffer();
  const size = new DataView(data).getUint32(12, true);
  const gltf = JSON.parse(new TextDecoder().decode(new Uint8Array(data, 20, size)));
  const array = (at) => {
    const entry = gltf.accessors[at], view = gltf.bufferViews[entry.bufferView];
    const width = { SCALAR: 1, VEC2: 2, VEC3: 3 }[entry.type];
    const kind = entry.componentType === 5126 ? Float32Array : Uint32Array;
    return new THREE.BufferAttribute(new kind(data, 28 + size + view.byteOffset, entry.count * width), width);
  };
  const top = gltf.nodes[gltf.scenes[gltf.scene].nodes[0]];
  for (const child of top.children) {
    const node = gltf.nodes[child], part = gltf.meshes[node.mesh].primitives[0];
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", array(part.attributes.POSITION));
    geometry.setAttribute("normal", array(part.attributes.NORMAL));
    geometry.setIndex(array(part.indices));
    const { pbrMetallicRoughness: look } = gltf.materials[part.material];
    const [red, green, blue] = look.baseColorFactor;
    const paint = node.name.startsWith("Road_Marking");
    const material = new THREE.MeshStandardMaterial({
      color: new THREE.Color(red, green, blue), roughness: look.roughnessFactor, metalness: look.metallicFactor,
      side: THREE.DoubleSide, shadowSide: THREE.DoubleSide,
      polygonOffset: paint, polygonOffsetFactor: -1, polygonOffsetUnits: -2,
    });
    const mesh = new THREE.Mesh(geometry, material);
    mesh.position.fromArray(top.translation);
    mesh.castShadow = !paint;
    mesh.receiveShadow = true;
    world.add(mesh);
    if (/^(Terrain|Road_|Bridge_Deck)/.test(node.name)) solids.push(mesh);
  }
}
world.updateMatrixWorld(true);

// x, y and the height above what lies there, as x, y, z of glTF.
const stand = ([x, y, above]) => {
  const down = new THREE.Raycaster(new THREE.Vector3(x, 1e4, -y), new THREE.Vector3(0, -1, 0));
  const hits = down.intersectObjects(solids);
  return new THREE.Vector3(x, above + (hits.length ? hits[0].point.y : 0), -y);
};
const eye = stand(view.eye), target = stand(view.look);
const [width, height] = view.size;
const camera = new THREE.PerspectiveCamera(view.fov, width / height, 0.3, 2 * view.far);
camera.position.copy(eye);
camera.lookAt(target);

const [azimuth, elevation] = view.sun.map((angle) => (angle * Math.PI) / 180);
const toSun = new THREE.Vector3(
  Math.sin(azimuth) * Math.cos(elevation), Math.sin(elevation), -Math.cos(azimuth) * Math.cos(elevation));
world.add(new THREE.HemisphereLight(0xcfe0f5, 0x8a8a70, 1.5));
const reach = view.shadow;
const ahead = new THREE.Vector3().subVectors(target, eye).setY(0).normalize();
const sun = new THREE.DirectionalLight(0xfff0d8, 3.2);
sun.target.position.copy(eye).addScaledVector(ahead, 0.9 * reach);
sun.position.copy(sun.target.position).addScaledVector(toSun, 4 * reach);
sun.castShadow = true;
sun.shadow.mapSize.set(8192, 8192);
Object.assign(sun.shadow.camera, { left: -reach, right: reach, top: reach, bottom: -reach, near: 1, far: 8 * reach });
sun.shadow.normalBias = 0.15;
sun.shadow.bias = -0.0002;
sun.shadow.radius = 2;
world.add(sun, sun.target);

const renderer = new THREE.WebGLRenderer({
  antialias: true, logarithmicDepthBuffer: true, preserveDrawingBuffer: true });
renderer.setSize(2 * width, 2 * height);
renderer.shadowMap.enabled = true;
renderer.shadowMap.type = THREE.PCFSoftShadowMap;
renderer.toneMapping = THREE.NoToneMapping;
renderer.render(world, camera);
const small = document.createElement("canvas");
[small.width, small.height] = [width, height];
const flat = small.getContext("2d");
flat.imageSmoothingQuality = "high";
flat.drawImage(renderer.domElement, 0, 0, width, height);
flat.font = "12px sans-serif";
flat.textAlign = "right";
flat.fillStyle = "rgba(0, 0, 0, 0.45)";
const wide = flat.measureText(view.credit).width;
flat.fillRect(width - wide - 14, height - 21, wide + 14, 21);
flat.fillStyle = "#fff";
flat.fillText(view.credit, width - 7, height - 6);
window.picture = small.toDataURL("image/png");
</script>"""


class Quiet(SimpleHTTPRequestHandler):
    """Serves files without a word."""

    def log_message(self, format: str, *args: object) -> None:
        """Say nothing."""


def numbers(text: str) -> list[float]:
    """Return numbers with commas between them."""
    return [float(word) for word in text.split(",")]


def draw(folder: Path) -> bytes:
    """Return the picture (PNG) that the page in a folder draws."""
    server = ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Quiet, directory=str(folder)))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    options = webdriver.ChromeOptions()
    options.binary_location = shutil.which("chromium") or shutil.which("chromium-browser") or ""
    for flag in (*FLAGS, "--enable-unsafe-swiftshader", f"--user-data-dir={folder / 'profile'}"):
        options.add_argument(flag)
    driver = webdriver.Chrome(options=options, service=Service(shutil.which("chromedriver")))
    try:
        driver.set_page_load_timeout(PATIENCE)
        driver.set_script_timeout(PATIENCE)
        driver.get(f"http://127.0.0.1:{server.server_port}/index.html")
        wait = "const done = arguments[0]; const look = () => window.picture ? done(window.picture)"
        address = driver.execute_async_script(f"{wait} : setTimeout(look, 200); look();")
    finally:
        driver.quit()
        server.shutdown()
    return base64.b64decode(str(address).partition(",")[2])


def main() -> None:
    """Draw a scene."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", type=Path)
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--eye", type=numbers, required=True, help="x, y, and the height above what lies there, m")
    parser.add_argument("--look", type=numbers, required=True, help="likewise: the middle of the picture")
    parser.add_argument("--fov", type=float, default=45.0, help="from bottom to top, degrees")
    parser.add_argument("--size", type=numbers, default=[1280.0, 720.0], help="width and height, pixels")
    parser.add_argument("--sun", type=numbers, default=[235.0, 38.0], help="azimuth from north, elevation, degrees")
    parser.add_argument("--shadow", type=float, default=350.0, help="half the width of where there are shadows, m")
    parser.add_argument("--clear", type=float, default=500.0, help="where haze begins, m")
    parser.add_argument("--far", type=float, default=4000.0, help="where nothing is seen beyond, m")
    parser.add_argument("--credit", default="© OpenStreetMap contributors · SRTM", help="whom the data are owed")
    options = parser.parse_args()
    view = {key: value for key, value in vars(options).items() if key not in {"scene", "output"}}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for path in (*VENDOR.glob("three.*.js"), *options.scene.glob("*.glb")):
            shutil.copy(path, folder / path.name.replace("core", "core.min"))
        view |= {"tiles": sorted(path.name for path in options.scene.glob("*.glb")), "sky": "#c9dcec"}
        (folder / "view.json").write_text(json.dumps(view), encoding="utf-8")
        (folder / "index.html").write_text(PAGE, encoding="utf-8")
        options.output.write_bytes(draw(folder))


if __name__ == "__main__":
    main()
