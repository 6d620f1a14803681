// A viewer with Foxglove's own client of its protocol, and its readers of messages of ROS 2.
//
// Usage: node viewer.mjs ADDRESS SECONDS, in a folder with the packages. Subscribes to every channel, decodes every message, and
// prints for each channel its schema, the number of messages and the last one, as JSON.

import { createRequire } from "node:module";

const load = createRequire(`${process.cwd()}/`);
const { FoxgloveClient } = load("@foxglove/ws-protocol");
const { MessageReader } = load("@foxglove/rosmsg2-serialization");
const { parse } = load("@foxglove/rosmsg");
const { WebSocket } = load("ws");

const [address, seconds] = process.argv.slice(2);
const client = new FoxgloveClient({
  ws: new WebSocket(`ws://${address}/`, [FoxgloveClient.SUPPORTED_SUBPROTOCOL]),
});
const seen = {};
const readers = new Map();
const said = [];
let info = null;
let times = 0;

client.on("error", (error) => { throw error; });
client.on("serverInfo", (message) => { info = message; });
client.on("status", (message) => said.push(message.message));
client.on("time", () => times++);
client.on("advertise", (channels) => {
  for (const channel of channels) {
    const decode = channel.encoding === "cdr"
      ? ((reader) => (data) => reader.readMessage(data))(new MessageReader(parse(channel.schema, { ros2: true })))
      : (data) => JSON.parse(new TextDecoder().decode(data));
    const entry = { schema: channel.schemaName, count: 0, last: null };
    seen[channel.topic] = entry;
    readers.set(client.subscribe(channel.id), { entry, decode });
  }
});
client.on("message", ({ subscriptionId, data }) => {
  const { entry, decode } = readers.get(subscriptionId);
  entry.count++;
  entry.last = decode(data);
});

setTimeout(() => {
  const plain = (_, value) => ArrayBuffer.isView(value) ? [...value].slice(0, 8)
    : typeof value === "bigint" ? Number(value) : value;
  // a pipe takes a long text in parts, after which the process may end
  process.stdout.write(JSON.stringify({ info, channels: seen, times, said }, plain), () => process.exit(0));
}, Number(seconds) * 1000);
