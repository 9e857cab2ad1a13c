// node open_recording.mjs RECORDING PICTURE: opens a recording in Foxglove Studio in a real browser and decodes its video there.
// Exit 1 when Studio misses a topic, reports a problem, or a picture does not decode. PICTURE gets what Studio shows.
import { createReadStream, statSync } from "node:fs";
import { open, readFile } from "node:fs/promises";
import { createServer } from "node:http";
import path from "node:path";
import { fileURLToPath } from "node:url";
import { McapIndexedReader } from "@mcap/core";
import { FileHandleReadable } from "@mcap/nodejs";
import { loadDecompressHandlers, protobufFromBinaryDescriptor } from "@mcap/support";
import { chromium } from "playwright-core";

const here = path.dirname(fileURLToPath(import.meta.url));
const [recording, picture] = process.argv.slice(2);
const TYPES = { ".js": "text/javascript", ".html": "text/html", ".wasm": "application/wasm" };
const PATIENCE_MS = 60_000;
const SLIDER_PX = 56; // from below
const DRAWN_PX = 500; // dark ones, of a trajectory and people

/** Topics with their counts, and the pictures of each camera, as Foxglove's own reader sees them. */
async function read(file) {
  const handle = await open(file);
  const reader = await McapIndexedReader.Initialize({
    readable: new FileHandleReadable(handle),
    decompressHandlers: await loadDecompressHandlers(),
  });
  const channels = new Map();
  const pictures = new Map();
  for (const channel of reader.channelsById.values()) {
    const schema = reader.schemasById.get(channel.schemaId);
    channels.set(channel.topic, { name: schema.name, decode: decoderOf(channel, schema), count: 0 });
  }
  for await (const message of reader.readMessages()) {
    const topic = reader.channelsById.get(message.channelId).topic;
    const channel = channels.get(topic);
    const value = channel.decode(message.data); // throws where a message does not fit its schema
    channel.count += 1;
    if (channel.name === "foxglove.CompressedVideo") pictures.set(topic, [...(pictures.get(topic) ?? []), value.data]);
  }
  await handle.close();
  return { channels, pictures };
}

function decoderOf(channel, schema) {
  if (channel.messageEncoding === "json") return (data) => JSON.parse(new TextDecoder().decode(data));
  const type = protobufFromBinaryDescriptor(schema.data).lookupType(schema.name);
  return (data) => type.decode(data);
}

/** Length, 1 for a picture that can be decoded alone (an IDR slice is inside), the picture. */
function packed(frames) {
  return Buffer.concat(frames.map((frame) => {
    const head = Buffer.alloc(5);
    head.writeUInt32BE(frame.length);
    head[4] = hasIdr(frame) ? 1 : 0;
    return Buffer.concat([head, frame]);
  }));
}

function hasIdr(frame) {
  for (let at = 0; at + 3 < frame.length; at += 1)
    if (frame[at] === 0 && frame[at + 1] === 0 && frame[at + 2] === 1 && (frame[at + 3] & 31) === 5) return true;
  return false;
}

function serve(pictures) {
  return createServer((request, response) => {
    const name = decodeURIComponent(new URL(request.url, "http://local").pathname);
    if (pictures.has(name.slice("/pictures/".length))) return void response.end(packed(pictures.get(name.slice("/pictures/".length))));
    sendFile(fileOf(name), request, response);
  });
}

function fileOf(name) {
  if (name === "/drive.mcap") return recording;
  if (name.startsWith("/modules/")) return path.join(here, "node_modules", name.slice("/modules/".length));
  return path.join(here, "site", name === "/" ? "index.html" : name);
}

function sendFile(file, request, response) {
  const size = statSync(file, { throwIfNoEntry: false })?.size;
  if (size === undefined) return void response.writeHead(404).end();
  const range = /bytes=(\d+)-(\d*)/.exec(request.headers.range ?? "");
  const first = Number(range?.[1] ?? 0);
  const last = Math.min(range?.[2] ? Number(range[2]) : size - 1, size - 1);
  response.writeHead(range ? 206 : 200, {
    "Content-Type": TYPES[path.extname(file)] ?? "application/octet-stream",
    "Accept-Ranges": "bytes",
    "Content-Length": last - first + 1,
    ...(range && { "Content-Range": `bytes ${first}-${last}/${size}` }),
  });
  if (request.method === "HEAD") return void response.end();
  createReadStream(file, { start: first, end: last }).pipe(response);
}

/** What Studio says of the recording: the text of its topic list, and of its list of problems. */
async function openInStudio(page, site) {
  await page.goto(`${site}/?ds=remote-file&ds.url=${encodeURIComponent(`${site}/drive.mcap`)}`);
  await page.getByText("CURRENT SOURCE", { exact: false }).waitFor({ timeout: PATIENCE_MS });
  await page.getByText([...channels.keys()][0], { exact: true }).first().waitFor({ timeout: PATIENCE_MS });
  const topics = await page.evaluate(() => document.body.innerText);
  await page.getByText("Problems", { exact: true }).click();
  await page.getByText("No problems found").waitFor({ timeout: 5_000 }).catch(() => {});
  return { topics, problems: await page.evaluate(() => document.body.innerText) };
}

/** Our layout, as a user imports it, an eighth into the drive; whether Studio draws the planner's scene there. */
async function showsScene(page) {
  await page.setViewportSize({ width: 1500, height: 1000 });
  await page.getByTitle("Layouts", { exact: true }).first().click();
  await page.getByTitle("Import layout").first().click();
  await page.getByText("gateway_status.mode").first().waitFor({ timeout: PATIENCE_MS });
  await page.mouse.click(1500 / 8, 1000 - SLIDER_PX);
  const boxes = await Promise.all((await page.locator("canvas").all()).map((canvas) => canvas.boundingBox()));
  const clip = boxes.sort((one, other) => other.height - one.height)[0]; // the 3D panel's
  const until = Date.now() + PATIENCE_MS;
  let dark = 0;
  while (dark < DRAWN_PX && Date.now() < until)
    dark = await page.evaluate((png) => darkPixels(png), (await page.screenshot({ clip })).toString("base64"));
  await page.screenshot({ path: picture });
  return dark >= DRAWN_PX;
}

const { channels, pictures } = await read(recording);
const server = serve(pictures);
await new Promise((done) => server.listen(0, "127.0.0.1", done));
const site = `http://127.0.0.1:${server.address().port}`;
const browser = await chromium.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", args: ["--no-sandbox"] });
const page = await browser.newPage({ viewport: { width: 1500, height: 3000 } });
const layout = await readFile(path.join(here, "../../config/foxglove_layout.json"), "utf8");
await page.addInitScript((text) => {
  window.showOpenFilePicker = async () => [{ getFile: async () => new File([text], "remote-operation.json") }];
}, layout);
const said = await openInStudio(page, site);
const wrong = [...channels.keys()].filter((topic) => !said.topics.includes(topic)).map((topic) => `Studio does not list ${topic}`);
if (!said.problems.includes("No problems found")) wrong.push("Studio reports problems");
await page.addScriptTag({ url: `${site}/pictures.js` });
if (channels.has("planner_scene") && !(await showsScene(page))) wrong.push("Studio does not draw the planner's scene");
for (const [topic, frames] of pictures) {
  const seen = await page.evaluate((address) => decodePictures(address), `${site}/pictures/${topic}`);
  console.log(`${topic}: ${seen.decoded} of ${frames.length} pictures decoded, ${seen.width} x ${seen.height} ${seen.error}`);
  if (seen.decoded !== frames.length) wrong.push(`${topic}: ${frames.length - seen.decoded} pictures do not decode`);
}
await browser.close();
server.close();
const messages = [...channels.values()].reduce((sum, channel) => sum + channel.count, 0);
console.log(`${channels.size} topics, ${messages} messages read by their schemas; shown in ${picture}`);
wrong.forEach((line) => console.error(line));
process.exit(wrong.length ? 1 : 0);
