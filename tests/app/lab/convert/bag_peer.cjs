// SPDX-License-Identifier: BSD-2-Clause
// The other side of bag_peer_test.py: bags whose messages are serialized by Foxglove's packages, found through
// NODE_PATH.
//
// node bag_peer.cjs ros2 LOG.json FILE.mcap          CDR in MCAP, chunks compressed by zstd
// node bag_peer.cjs ros1 LOG.json FILE.bag METHOD    METHOD: none, lz4 or bz2
// node bag_peer.cjs cdr LOG.json                     prints the messages in CDR as JSON
// node bag_peer.cjs read FILE.bag                    what @foxglove/rosbag finds in a bag of ours, as JSON
// LOG.json is a list of {topic, type, time, message}; bytes are in hex.
'use strict'

const fs = require('fs')
const { spawnSync } = require('child_process')
const { McapWriter } = require('@mcap/core')
const { parse } = require('@foxglove/rosmsg')
const ros1 = require('@foxglove/rosmsg-serialization')
const ros2 = require('@foxglove/rosmsg2-serialization')

const VECTOR = 'MSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n'
const POINT = VECTOR.replace('Vector3', 'Point')
const QUATERNION = 'MSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n'
const POSE = `MSG: geometry_msgs/Pose\nPoint position\nQuaternion orientation\n===\n${POINT}===\n${QUATERNION}`
const HEADERS = {
  1: 'MSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n',
  2: 'MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n===\n' +
    'MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n',
}
// As ROS has them, without comments.
const DEFINITIONS = {
  'sensor_msgs/Image':
    'std_msgs/Header header\nuint32 height\nuint32 width\nstring encoding\nuint8 is_bigendian\nuint32 step\nuint8[] data\n',
  'sensor_msgs/CompressedImage': 'std_msgs/Header header\nstring format\nuint8[] data\n',
  'sensor_msgs/Imu':
    'std_msgs/Header header\ngeometry_msgs/Quaternion orientation\nfloat64[9] orientation_covariance\n' +
    'geometry_msgs/Vector3 angular_velocity\nfloat64[9] angular_velocity_covariance\n' +
    'geometry_msgs/Vector3 linear_acceleration\nfloat64[9] linear_acceleration_covariance\n' +
    `===\n${QUATERNION}===\n${VECTOR}`,
  'geometry_msgs/PoseStamped': `std_msgs/Header header\ngeometry_msgs/Pose pose\n===\n${POSE}`,
  'geometry_msgs/TransformStamped':
    'std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n===\n' +
    `MSG: geometry_msgs/Transform\nVector3 translation\nQuaternion rotation\n===\n${VECTOR}===\n${QUATERNION}`,
  'nav_msgs/Odometry':
    'std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/PoseWithCovariance pose\n' +
    'geometry_msgs/TwistWithCovariance twist\n===\n' +
    `MSG: geometry_msgs/PoseWithCovariance\nPose pose\nfloat64[36] covariance\n===\n${POSE}===\n` +
    'MSG: geometry_msgs/TwistWithCovariance\nTwist twist\nfloat64[36] covariance\n===\n' +
    `MSG: geometry_msgs/Twist\nVector3 linear\nVector3 angular\n===\n${VECTOR}`,
  'std_msgs/String': 'string data\n',
}

const definition = (type, version) => {
  const text = DEFINITIONS[type]
  return text.includes('Header') ? `${text}===\n${HEADERS[version]}` : text
}

/// Bytes in hex become bytes; the header becomes that of the version.
function revive(message, version) {
  const out = { ...message }
  if (typeof out.bytes === 'string') {
    out.data = Uint8Array.from(Buffer.from(out.bytes, 'hex'))
    delete out.bytes
  }
  if (out.header) {
    const { sec, nsec } = out.header
    const stamp = version === 1 ? { sec, nsec } : { sec, nanosec: nsec }
    out.header = { seq: 7, stamp, frame_id: 'a frame' }
  }
  return out
}

function serializers(entries, version) {
  const made = new Map()
  for (const { type } of entries) {
    if (!made.has(type)) {
      const parsed = parse(definition(type, version), { ros2: version === 2 })
      made.set(type, version === 1 ? new ros1.MessageWriter(parsed) : new ros2.MessageWriter(parsed))
    }
  }
  return (entry) => made.get(entry.type).writeMessage(revive(entry.message, version))
}

async function writeRos2(entries, file) {
  const zstd = require('@foxglove/wasm-zstd')
  await zstd.isLoaded
  const serialize = serializers(entries, 2)
  const pieces = []
  let size = 0n
  const writer = new McapWriter({
    writable: {
      position: () => size,
      write: async (bytes) => {
        pieces.push(Buffer.from(bytes))
        size += BigInt(bytes.length)
      },
    },
    chunkSize: 20000,
    compressChunk: (data) => ({ compression: 'zstd', compressedData: zstd.compress(data, 3) }),
  })
  await writer.start({ profile: 'ros2', library: 'bag_peer' })
  const channels = new Map()
  for (const entry of entries) {
    if (!channels.has(entry.topic)) {
      const schemaId = await writer.registerSchema({
        name: entry.type.replace('/', '/msg/'), encoding: 'ros2msg', data: Buffer.from(definition(entry.type, 2)),
      })
      channels.set(entry.topic, await writer.registerChannel({
        topic: entry.topic, messageEncoding: 'cdr', schemaId, metadata: new Map(),
      }))
    }
    const time = BigInt(entry.time)
    await writer.addMessage({
      channelId: channels.get(entry.topic), sequence: 0, logTime: time, publishTime: time, data: serialize(entry),
    })
  }
  await writer.end()
  fs.writeFileSync(file, Buffer.concat(pieces))
}

function writeCdr(entries) {
  const serialize = serializers(entries, 2)
  process.stdout.write(JSON.stringify(entries.map((entry) => ({
    topic: entry.topic, type: entry.type, time: entry.time, hex: Buffer.from(serialize(entry)).toString('hex'),
  }))))
}

const u32 = (value) => {
  const bytes = Buffer.alloc(4)
  bytes.writeUInt32LE(value)
  return bytes
}
const counted = (bytes) => Buffer.concat([u32(bytes.length), bytes])
const field = (name, value) => counted(Buffer.concat([Buffer.from(`${name}=`), value]))
const record = (fields, data) => Buffer.concat([
  counted(Buffer.concat(Object.entries(fields).map(([name, value]) => field(name, value)))), counted(data),
])
const op = (code) => Buffer.from([code])
const stampOf = (time) => {
  const ns = BigInt(time)
  return Buffer.concat([u32(Number(ns / 1000000000n)), u32(Number(ns % 1000000000n))])
}

function compressed(method, bytes) {
  if (method === 'bz2') {
    return spawnSync('bzip2', ['-c'], { input: bytes, maxBuffer: 1 << 28 }).stdout
  }
  if (method === 'lz4') {  // a frame with its block stored
    return Buffer.concat([Buffer.from('04224d18607073', 'hex'), u32((bytes.length | 0x80000000) >>> 0), bytes, u32(0)])
  }
  return bytes
}

/// Bag format 2.0 as wiki.ros.org/Bags/Format/2.0 has it: header, chunks with an index behind each, connections and
/// chunk infos at the end.
function writeRos1(entries, file, method) {
  const serialize = serializers(entries, 1)
  const connections = new Map()
  for (const { topic, type } of entries) {
    if (!connections.has(topic)) {
      const info = Buffer.concat([
        field('topic', Buffer.from(topic)), field('type', Buffer.from(type)), field('md5sum', Buffer.from('*')),
        field('message_definition', Buffer.from(definition(type, 1))),
      ])
      const id = connections.size
      connections.set(topic, { id, record: record({ op: op(7), conn: u32(id), topic: Buffer.from(topic) }, info) })
    }
  }
  const parts = [Buffer.from('#ROSBAG V2.0\n')]
  let at = parts[0].length + 4096
  const infos = []
  for (let begin = 0; begin < entries.length; begin += 40) {
    const inside = []
    const index = new Map()
    let offset = 0
    const add = (bytes) => {
      inside.push(bytes)
      offset += bytes.length
    }
    const group = entries.slice(begin, begin + 40)
    for (const entry of group) {
      const { id, record: known } = connections.get(entry.topic)
      if (!index.has(id)) {
        index.set(id, [])
        add(known)
      }
      index.get(id).push(Buffer.concat([stampOf(entry.time), u32(offset)]))
      add(record({ op: op(2), conn: u32(id), time: stampOf(entry.time) }, Buffer.from(serialize(entry))))
    }
    const bytes = Buffer.concat(inside)
    const out = [record({ op: op(5), compression: Buffer.from(method), size: u32(bytes.length) },
      compressed(method, bytes))]
    for (const [id, places] of index) {
      out.push(record({ op: op(4), ver: u32(1), conn: u32(id), count: u32(places.length) }, Buffer.concat(places)))
    }
    const counts = Buffer.concat([...index].map(([id, places]) => Buffer.concat([u32(id), u32(places.length)])))
    const times = group.map((entry) => BigInt(entry.time)).sort((a, b) => (a < b ? -1 : 1))
    const position = Buffer.alloc(8)
    position.writeBigUInt64LE(BigInt(at))
    infos.push(record({
      op: op(6), ver: u32(1), chunk_pos: position, start_time: stampOf(times[0]),
      end_time: stampOf(times[times.length - 1]), count: u32(index.size),
    }, counts))
    parts.push(...out)
    at += out.reduce((sum, part) => sum + part.length, 0)
  }
  const position = Buffer.alloc(8)
  position.writeBigUInt64LE(BigInt(at))
  const head = { op: op(3), index_pos: position, conn_count: u32(connections.size), chunk_count: u32(infos.length) }
  const padding = 4096 - record(head, Buffer.alloc(0)).length
  parts.splice(1, 0, record(head, Buffer.alloc(padding, ' ')))
  fs.writeFileSync(file, Buffer.concat([...parts, ...[...connections.values()].map((c) => c.record), ...infos]))
}

async function readRos1(file) {
  const { Bag } = require('@foxglove/rosbag')
  const { FileReader } = require('@foxglove/rosbag/node')
  const { loadDecompressHandlers } = require('@mcap/support')
  const handlers = await loadDecompressHandlers()
  const bag = new Bag(new FileReader(file), {
    decompress: {
      bz2: (data, size) => handlers.bz2(data, BigInt(size)), lz4: (data, size) => handlers.lz4(data, BigInt(size)),
    },
  })
  await bag.open()
  const counts = {}
  for await (const { topic } of bag.messageIterator()) {
    counts[topic] = (counts[topic] ?? 0) + 1
  }
  process.stdout.write(JSON.stringify(counts))
}

const [mode, from, to, method] = process.argv.slice(2)
const entries = mode === 'read' ? [] : JSON.parse(fs.readFileSync(from, 'utf8'))
Promise.resolve().then(() => {
  switch (mode) {
    case 'ros2': return writeRos2(entries, to)
    case 'cdr': return writeCdr(entries)
    case 'ros1': return writeRos1(entries, to, method)
    default: return readRos1(from)
  }
}).catch((error) => {
  console.error(error)
  process.exit(1)
})
