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
