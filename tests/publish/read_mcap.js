// Reads an MCAP file with npm packages: counts messages per topic and summarises the last cloud.
const fs = require('fs');
const { McapIndexedReader } = require('@mcap/core');
const { decompress } = require('fzstd');
const { parse } = require('@foxglove/rosmsg');
const { MessageReader } = require('@foxglove/rosmsg2-serialization');

async function main(path) {
  const bytes = fs.readFileSync(path);
  const readable = {
    size: async () => BigInt(bytes.length),
    read: async (offset, size) => bytes.subarray(Number(offset), Number(offset + size)),
  };
  const reader = await McapIndexedReader.Initialize({
    readable,
    decompressHandlers: { zstd: (buffer, size) => decompress(buffer, new Uint8Array(Number(size))) },
  });
  const counts = {}, readers = {};
  let points, last = 0n;
  for await (const message of reader.readMessages({ validateCrcs: true })) {
    const channel = reader.channelsById.get(message.channelId);
    const schema = reader.schemasById.get(channel.schemaId);
    const text = new TextDecoder().decode(schema.data);
    readers[channel.topic] ??= new MessageReader(parse(text, { ros2: true }));
    const told = readers[channel.topic].readMessage(message.data);
    counts[channel.topic] = (counts[channel.topic] ?? 0) + 1;
    if (message.logTime < last) throw Error('out of order');
    last = message.logTime;
    if (channel.topic === '/points') points = told;
    if (channel.topic === '/camera_info' && told.k[0] !== told.p[0]) throw Error('camera_info');
    if (channel.topic === '/statistics') JSON.parse(told.data);
    if (/^.(image|frames)/.test(channel.topic) && told.data.length !== told.step * told.height) throw Error('image');
  }
  const attachments = {};
  for await (const { name, data } of reader.readAttachments()) {
    attachments[name] = new TextDecoder().decode(data).includes(':');
  }
  const view = new DataView(points.data.buffer, points.data.byteOffset, points.data.byteLength);
  const sum = [0, 0, 0];
  let valid = 0;
  for (let at = 0; at < points.data.length; at += points.point_step) {
    const point = points.fields.slice(0, 3).map(field => view.getFloat32(at + field.offset, true));
    if (Number.isNaN(point[2])) continue;
    ++valid;
    point.forEach((value, axis) => { sum[axis] += value; });
  }
  console.log(JSON.stringify({
    counts, attachments,
    points: { width: points.width, height: points.height, valid, mean: sum.map(s => s / valid) },
  }));
}
main(process.argv[2]).catch(error => { console.error(error); process.exit(1); });
