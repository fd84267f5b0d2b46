// SPDX-License-Identifier: Apache-2.0
// Reads an MCAP recording with the format's own library and Foxglove's decoder of ROS 2 messages; prints what it
// found as one JSON object: per topic the type, the number of messages, and the first and last of them.
// usage: node read_mcap.mjs FILE
import {readFileSync} from 'node:fs';

import {parse} from '@foxglove/rosmsg';
import {MessageReader} from '@foxglove/rosmsg2-serialization';
import {McapStreamReader} from '@mcap/core';

const stream = new McapStreamReader();
stream.append(readFileSync(process.argv[2]));
const schemas = new Map(), channels = new Map(), topics = {};
let header, previous = -1n, ordered = true;
for (let record; (record = stream.nextRecord());) {
  if (record.type === 'Header') header = {profile: record.profile, library: record.library};
  if (record.type === 'Schema') schemas.set(record.id, record);
  if (record.type === 'Channel') {
    const schema = schemas.get(record.schemaId);
    const definition = parse(new TextDecoder().decode(schema.data), {ros2: true});
    channels.set(record.id, {topic: record.topic, reader: new MessageReader(definition)});
    topics[record.topic] = {type: schema.name, count: 0};
  }
  if (record.type === 'Message') {
    const {topic, reader} = channels.get(record.channelId);
    const message = reader.readMessage(record.data);
    ordered &&= record.logTime >= previous;
    previous = record.logTime;
    const entry = topics[topic];
    ++entry.count;
    entry.first ??= message;
    entry.last = message;
    entry.last_time = Number(record.logTime) / 1e9;
  }
}
const plain = (key, value) => ArrayBuffer.isView(value) ? Array.from(value) : typeof value === 'bigint' ? Number(value) : value;
console.log(JSON.stringify({header, ordered, done: stream.done(), topics}, plain));
