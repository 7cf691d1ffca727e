// SPDX-License-Identifier: GPL-3.0-or-later
// Under Node with the package three: opens EXR pictures by EXRLoader and GLB files by GLTFLoader.
//
//   node three_files.mjs FILE...      one line of JSON a file: {"file", "error"} or what was read; exit code 3 on errors
import { readFileSync } from "node:fs";

globalThis.self = globalThis;
// Pictures inside a GLB need a browser; that they are handed over is all that can be seen here.
globalThis.createImageBitmap = async (blob) => ({ width: 1, height: 1, bytes: blob.size, close() {} });

const { EXRLoader } = await import("three/examples/jsm/loaders/EXRLoader.js");
const { GLTFLoader } = await import("three/examples/jsm/loaders/GLTFLoader.js");
const { FloatType } = await import("three");

function bytes_of(file) {
    const buffer = readFileSync(file);
    return buffer.buffer.slice(buffer.byteOffset, buffer.byteOffset + buffer.byteLength);
}

function exr(file) {
    const loader = new EXRLoader();
    loader.setDataType(FloatType);
    const image = loader.parse(bytes_of(file));
    let sum = 0;
    for (const value of image.data) sum += Number.isFinite(value) ? value : 0;
    // Three's rows go up, as in OpenGL: the first pixel of the last row is the file's first.
    const first = (image.height - 1) * image.width * (image.data.length / (image.width * image.height));
    return { width: image.width, height: image.height, first: [...image.data.slice(first, first + 3)], sum };
}

async function glb(file) {
    const gltf = await new GLTFLoader().parseAsync(bytes_of(file), "");
    let meshes = 0, vertices = 0;
    gltf.scene.traverse((node) => {
        if (!node.isMesh) return;
        ++meshes;
        vertices += node.geometry.attributes.position.count;
    });
    return { meshes, vertices };
}

let failed = false;
for (const file of process.argv.slice(2)) {
    try {
        console.log(JSON.stringify({ file, ...(file.endsWith(".exr") ? exr(file) : await glb(file)) }));
    } catch (error) {
        failed = true;
        console.log(JSON.stringify({ file, error: error.message }));
    }
}
process.exit(failed ? 3 : 0);
