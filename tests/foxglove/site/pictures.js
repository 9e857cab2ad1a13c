// Decodes pictures with the browser's own H.264 decoder, the way viewers show foxglove.CompressedVideo: Annex B, one frame a message.
async function decodePictures(address) {
  const bytes = new Uint8Array(await (await fetch(address)).arrayBuffer());
  const view = new DataView(bytes.buffer);
  const seen = { decoded: 0, width: 0, height: 0, error: "" };
  const decoder = new VideoDecoder({
    output: (frame) => {
      seen.decoded += 1;
      [seen.width, seen.height] = [frame.displayWidth, frame.displayHeight];
      frame.close();
    },
    error: (error) => { seen.error ||= String(error); },
  });
  decoder.configure({ codec: "avc1.640028", optimizeForLatency: true });
  for (let at = 0, number = 0; at < bytes.length && !seen.error; number += 1) {
    const [size, key] = [view.getUint32(at), bytes[at + 4] === 1];
    const data = bytes.subarray(at + 5, at + 5 + size);
    if (number > 0 || key) decoder.decode(new EncodedVideoChunk({ type: key ? "key" : "delta", timestamp: number, data }));
    while (decoder.decodeQueueSize > 30) await new Promise((done) => setTimeout(done, 1));
    at += 5 + size;
  }
  if (!seen.error) await decoder.flush();
  return seen;
}

const DARK = 240; // sum of the three colours: our own dark grey is 170, the grid 600

/** How many pixels of a PNG (base64) are dark. */
async function darkPixels(png) {
  const image = await createImageBitmap(await (await fetch(`data:image/png;base64,${png}`)).blob());
  const context = new OffscreenCanvas(image.width, image.height).getContext("2d");
  context.drawImage(image, 0, 0);
  const { data } = context.getImageData(0, 0, image.width, image.height);
  let dark = 0;
  for (let at = 0; at < data.length; at += 4) dark += data[at] + data[at + 1] + data[at + 2] < DARK ? 1 : 0;
  return dark;
}
