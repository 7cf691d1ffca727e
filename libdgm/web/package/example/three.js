// SPDX-License-Identifier: MIT
// A map in three.js: hold the mouse on it and it gives way. Serve the folder, with a map as map.dgm and three beside it.
import * as THREE from "three";
import { load } from "libdgm";

const dgm = await load(), asset = dgm.open(await (await fetch("map.dgm")).arrayBuffer()), state = asset.state(0);
const kernel = dgm.kernel({ reach: 12, sigma: 30 }), dMax = 8 * state.meanStep;
const geometry = new THREE.BufferGeometry(), attribute = () => new THREE.BufferAttribute(new Float32Array(3 * state.sampleCount), 3);
geometry.setAttribute("position", attribute()).setAttribute("normal", attribute()).setIndex(new THREE.BufferAttribute(state.indices(), 1));
const upload = () => {
  const grid = state.rows * state.cols, ranges = state.changed();
  for (const [name, columns] of [["position", state.positions], ["normal", state.normals]]) {
    const { array } = geometry.attributes[name];
    for (const { first, columns: wide, rows } of ranges) {
      const end = first < grid ? first + (rows - 1) * state.cols + wide : first + wide;
      for (let s = first; s < end; ++s) for (let d = 0; d < 3; ++d) array[3 * s + d] = columns[d][s];
      geometry.attributes[name].addUpdateRange(3 * first, 3 * (end - first)), geometry.attributes[name].needsUpdate = true;
    }
  }
};
const scene = new THREE.Scene(), size = Math.hypot(...state.max.map((m, d) => m - state.min[d])), camera = new THREE.PerspectiveCamera(30, innerWidth / innerHeight, size / 100, 9 * size);
const renderer = new THREE.WebGLRenderer(), middle = new THREE.Vector3(...state.max.map((m, d) => (m + state.min[d]) / 2 - state.offset[d]));
scene.add(new THREE.Mesh(geometry, new THREE.MeshStandardMaterial({ color: 0xd8b8a8 })), new THREE.HemisphereLight(0xffffff, 0x445566, 3));
camera.up.set(0, 0, 1), camera.position.copy(middle).add(new THREE.Vector3(0, -2 * size, 0)), camera.lookAt(middle);
document.body.append(renderer.domElement), renderer.setSize(innerWidth, innerHeight);
let hit = null, depth = 0;
addEventListener("pointerdown", (e) => {
  const ray = new THREE.Raycaster();
  ray.setFromCamera(new THREE.Vector2(2 * e.clientX / innerWidth - 1, 1 - 2 * e.clientY / innerHeight), camera);
  hit = state.pick(ray.ray.origin.toArray(), ray.ray.direction.toArray()), depth = 0;
});
addEventListener("pointerup", () => (hit = null));
renderer.setAnimationLoop(() => {
  depth = Math.min(dMax, depth + dMax / 30);
  const at = hit ? hit.point.map((p, d) => p - depth * hit.normal[d]) : [0, 0, 0];
  state.tick(kernel, { dMax, dt: 1 / 60, relaxRate: 10 }, [{ kind: "poke", lifted: !hit, positions: at }]);
  upload(), renderer.render(scene, camera);
});
