// A scene rendered by phalanx in WebAssembly, as a portable float map.
//
//   node examples/wasm/render.mjs MODULE.wasm SCENE WIDTH HEIGHT [--oracle] [-o FILE.pfm]
//
// SCENE is a scene file or standard:NAME. Prints the SHA-256 hash of the picture, and writes it to FILE.
import { createHash } from "node:crypto";
import { readFileSync, writeFileSync } from "node:fs";

const fail = (text) => {
  console.error(text);
  process.exit(1);
};

const options = process.argv.slice(2);
const oracle = options.includes("--oracle");
const places = options.filter((option) => option !== "--oracle");
const out = places.indexOf("-o");
const file = out < 0 ? undefined : places.splice(out, 2)[1];
const [path, scene, width, height] = places;
if (height === undefined) {
  fail("usage: node render.mjs MODULE.wasm SCENE WIDTH HEIGHT [--oracle] [-o FILE.pfm]");
}

const { instance } = await WebAssembly.instantiate(readFileSync(path));
const phalanx = instance.exports;

// A view is made anew for each use: the memory moves when it grows.
const send = (buffer, bytes) => {
  const address = buffer(bytes.length);
  new Uint8Array(phalanx.memory.buffer, address, bytes.length).set(bytes);
};

send(phalanx.name_buffer, new TextEncoder().encode(scene));
if (!scene.startsWith("standard:")) {
  send(phalanx.file_buffer, readFileSync(scene));
}
const done = phalanx.render_pfm(Number(width), Number(height), oracle);
const answer = new Uint8Array(phalanx.memory.buffer, phalanx.answer(), phalanx.answer_length());
if (!done) {
  fail(new TextDecoder().decode(answer));
}
if (file !== undefined) {
  writeFileSync(file, answer);
}
console.log(createHash("sha256").update(answer).digest("hex"));
