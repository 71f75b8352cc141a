// node validate.mjs LOG...
//
// Reads logs with the MCAP library for TypeScript, which shares no code with closecall's, and says on standard output
// {LOG: {"topics": {TOPIC: messages}, "attachments": [name, ...], "metadata": [name, ...], "faults": [sentence, ...]}}.
// Every CRC is checked, and every message is decoded by the descriptor that its own channel carries.
//
// CLOSECALL_STUDIO_DIR names the folder that has the packages.
import { open, readFile } from "node:fs/promises";
import { createRequire } from "node:module";
import { join } from "node:path";

const require = createRequire(join(process.env.CLOSECALL_STUDIO_DIR, "package.json"));
const { McapIndexedReader, McapStreamReader } = require("@mcap/core");
const { FileHandleReadable } = require("@mcap/nodejs");
const { loadDecompressHandlers } = require("@mcap/support");
const protobuf = require("protobufjs");
const { FileDescriptorSet } = require("protobufjs/ext/descriptor");

const DATA_END = { opcode: 0x0f, bytes: 9 + 4 };

// The CRC-32 of zlib, as MCAP has it.
function crc32(bytes) {
  let crc = 0xffffffff;
  for (const byte of bytes) {
    crc ^= byte;
    for (let bit = 0; bit < 8; bit++) {
      crc = crc & 1 ? (crc >>> 1) ^ 0xedb88320 : crc >>> 1;
    }
  }
  return (crc ^ 0xffffffff) >>> 0;
}

// Returns, by channel, the type of its messages out of the file descriptors that the log itself carries.
function messageTypes(reader) {
  const types = new Map();
  for (const channel of reader.channelsById.values()) {
    const schema = reader.schemasById.get(channel.schemaId);
    const root = protobuf.Root.fromDescriptor(FileDescriptorSet.decode(schema.data)).resolveAll();
    types.set(channel.id, root.lookupType(schema.name));
  }
  return types;
}

// Returns the numbers of fields in a message, or inside it, that its type does not have.
function unknownFields(type, bytes) {
  const reader = protobuf.Reader.create(bytes);
  const unknown = [];
  while (reader.pos < reader.len) {
    const tag = reader.uint32();
    const field = type.fieldsById[tag >>> 3];
    if (field?.resolvedType instanceof protobuf.Type) {
      unknown.push(...unknownFields(field.resolvedType, reader.bytes()));
    } else {
      reader.skipType(tag & 7);
      unknown.push(...(field ? [] : [tag >>> 3]));
    }
  }
  return unknown;
}

async function validate(path) {
  const faults = [];
  const topics = {};
  const decompressHandlers = await loadDecompressHandlers();
  const handle = await open(path);
  const reader = await McapIndexedReader.Initialize({ readable: new FileHandleReadable(handle), decompressHandlers });
  const channels = Array.from(reader.channelsById.values());
  const types = messageTypes(reader);

  let last = 0n;
  for (const channel of channels) {
    topics[channel.topic] = 0;
    if (channel.messageEncoding !== "protobuf" || reader.schemasById.get(channel.schemaId).encoding !== "protobuf") {
      faults.push(`${channel.topic} is not protobuf`);
    }
  }
  for await (const message of reader.readMessages({ validateCrcs: true })) {
    const { topic } = reader.channelsById.get(message.channelId);
    topics[topic]++;
    const type = types.get(message.channelId);
    type.decode(message.data);
    const unknown = unknownFields(type, message.data);
    if (unknown.length > 0) {
      faults.push(`a message of ${topic} at ${message.logTime} has fields ${unknown} that its schema does not have`);
    }
    if (message.logTime < last) {
      faults.push(`${topic} goes back in time at ${message.logTime}`);
    }
    last = message.logTime;
  }
  for (const channel of channels) {
    const counted = reader.statistics.channelMessageCounts.get(channel.id) ?? 0n;
    if (topics[channel.topic] === 0 || BigInt(topics[channel.topic]) !== counted) {
      faults.push(`${channel.topic} has ${topics[channel.topic]} messages by its index, ${counted} by the statistics`);
    }
  }

  const attachments = [];
  for await (const attachment of reader.readAttachments({ validateCrcs: true })) {
    attachments.push(attachment.name);
  }
  const metadata = [];
  for await (const record of reader.readMetadata()) {
    metadata.push(record.name);
  }
  await handle.close();

  // Once more from front to back, without the index.
  const bytes = await readFile(path);
  const stream = new McapStreamReader({ decompressHandlers, validateCrcs: true });
  stream.append(bytes);
  let found = 0n;
  let dataEnd;
  let offset;
  for (let record; (record = stream.nextRecord()); ) {
    found += record.type === "Message" ? 1n : 0n;
    dataEnd = record.type === "DataEnd" ? record : dataEnd;
    offset = record.type === "Footer" ? record.summaryStart : offset;
  }
  if (found !== reader.statistics.messageCount) {
    faults.push(`${found} messages from front to back, ${reader.statistics.messageCount} by the statistics`);
  }
  const end = Number(offset) - DATA_END.bytes;
  if (bytes[end] !== DATA_END.opcode || crc32(bytes.subarray(0, end)) !== dataEnd.dataSectionCrc) {
    faults.push("the CRC of the data section is wrong");
  }
  return { topics, attachments, metadata, faults };
}

const said = {};
for (const path of process.argv.slice(2)) {
  said[path] = await validate(path);
}
process.stdout.write(JSON.stringify(said));
