// Reads an MCAP file by its index with @mcap/core, which checks every CRC, and prints what it saw as JSON.
import { McapIndexedReader } from "@mcap/core";
import { open } from "node:fs/promises";

const file = await open(process.argv[2], "r");
const readable = {
  async size() {
    return BigInt((await file.stat()).size);
  },
  async read(offset, length) {
    const buffer = new Uint8Array(Number(length));
    await file.read(buffer, 0, buffer.length, Number(offset));
    return buffer;
  },
};
// Viewers know plain types only, and of an object the properties that its schema lists.
function requireReadable(schema, place) {
  if (schema.oneOf) return;
  if (typeof schema.type !== "string") throw new Error(`${place}: type ${JSON.stringify(schema.type)}`);
  if (schema.type === "array") return requireReadable(schema.items, place + "[]");
  if (schema.type !== "object") return;
  for (const [name, property] of Object.entries(schema.properties)) requireReadable(property, `${place}.${name}`);
}
const reader = await McapIndexedReader.Initialize({ readable });
const counts = {};
let points = 0;
const auViewTimes = []; // s
let viewsDue = 0, dueAt = 0n; // of the AUs as they were written: on a grid of 60 a second, begun anew after a gap
const period = 1000000000n / 60n;
for await (const message of reader.readMessages()) {
  const channel = reader.channelsById.get(message.channelId);
  counts[channel.topic] = (counts[channel.topic] ?? 0) + 1;
  if (channel.topic === "/face/au" && message.logTime >= dueAt) {
    dueAt = message.logTime - dueAt < period ? dueAt + period : message.logTime + period;
    ++viewsDue;
  }
  if (channel.messageEncoding !== "json") continue;
  const view = JSON.parse(new TextDecoder().decode(message.data));
  const schema = reader.schemasById.get(channel.schemaId);
  const described = JSON.parse(new TextDecoder().decode(schema.data));
  requireReadable(described, schema.name);
  if (schema.name === "foxglove.PointCloud") {
    points = Math.max(points, Buffer.from(view.data, "base64").length / view.point_stride);
  } else if (Object.keys(view.au).length > 0) {
    for (const name of Object.keys(view.au))
      if (!(name in described.properties.au.properties)) throw new Error(`${schema.name} does not list ${name}`);
    auViewTimes.push(Number(message.logTime) * 1e-9);
  }
}
let viewsPerSecond = 0; // the most in any second
for (let first = 0, last = 0; last < auViewTimes.length; ++last) {
  while (auViewTimes[last] - auViewTimes[first] >= 1) ++first;
  viewsPerSecond = Math.max(viewsPerSecond, last - first + 1);
}
const metadata = [];
for await (const record of reader.readMetadata()) metadata.push(record.name);
await file.close();
console.log(JSON.stringify({ counts, au_views: auViewTimes.length, views_per_second: viewsPerSecond, views_due: viewsDue, points, metadata: [...new Set(metadata)].sort() }));
