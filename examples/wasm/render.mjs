// Scenes rendered by phalanx in WebAssembly, as portable float maps.
//
//   node examples/wasm/render.mjs MODULE.wasm WIDTH HEIGHT [--oracle] [-o FILE.pfm] SCENE...
//
// A SCENE is a scene file or standard:NAME. Prints the SHA-256 hash of each picture, and writes the last one to FILE.
import { createHash } from "node:crypto";
import { readFileSync, writeFileSync } from "node:fs";

const fail = (text) => {
  console.error(text);
  process.exit(1);
};

const read = (path) => {
  try {
    return readFileSync(path);
  } catch (error) {
    return fail(`${path}: ${error.message}`);
  }
};

const places = process.argv.slice(2).filter((option) => option !== "--oracle");
const oracle = process.argv.includes("--oracle");
const out = places.indexOf("-o");
const file = out < 0 ? undefined : places.splice(out, 2)[1];
const [path, width, height, ...scenes] = places;
if (scenes.length === 0) {
  fail("usage: node render.mjs MODULE.wasm WIDTH HEIGHT [--oracle] [-o FILE.pfm] SCENE...");
}

const { instance } = await WebAssembly.instantiate(read(path));
const phalanx = instance.exports;

// Each use creates a new view, because the memory moves when it grows.
const send = (buffer, bytes) => {
  const address = buffer(bytes.length);
  new Uint8Array(phalanx.memory.buffer, address, bytes.length).set(bytes);
};

for (const scene of scenes) {
  send(phalanx.name_buffer, new TextEncoder().encode(scene));
  if (!scene.startsWith("standard:")) {
    send(phalanx.file_buffer, read(scene));
  }
  const done = phalanx.render_pfm(Number(width), Number(height), oracle);
  const answer = new Uint8Array(phalanx.memory.buffer, phalanx.answer(), phalanx.answer_length());
  if (!done) {
    fail(`${scene}: ${new TextDecoder().decode(answer)}`);
  }
  if (file !== undefined) {
    writeFileSync(file, answer);
  }
  console.log(createHash("sha256").update(answer).digest("hex"));
}
