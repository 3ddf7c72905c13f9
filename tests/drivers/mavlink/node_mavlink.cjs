// SPDX-License-Identifier: BSD-2-Clause
// The other side of node_mavlink_test.py: node-mavlink, found through NODE_PATH.
//
// node node_mavlink.cjs read     reads lines of JSON with a frame in `hex`, prints what node-mavlink makes of each
// node node_mavlink.cjs write    prints frames made by node-mavlink, with the fields that we should find in them
// node node_mavlink.cjs listen   prints the UDP port it has opened, then what arrives there, until standard input ends
'use strict'

const dgram = require('dgram')
const readline = require('readline')
const { PassThrough } = require('stream')
const {
  MavLinkPacketParser, MavLinkPacketSplitter, MavLinkProtocolV2, common, minimal,
} = require('node-mavlink')

const REGISTRY = { ...minimal.REGISTRY, ...common.REGISTRY }
const KEY = Buffer.concat([Buffer.from('deadbeef', 'hex'), Buffer.alloc(28)])
const SIGNED_AT_MS = 1750000000123

const plain = (key, value) => (typeof value === 'bigint' ? value.toString() : value)
const print = (object) => process.stdout.write(JSON.stringify(object, plain) + '\n')

function describe(packet) {
  const clazz = REGISTRY[packet.header.msgid]
  const fields = {}
  for (const field of clazz.FIELDS) {
    fields[field.name] = packet.protocol.data(packet.payload, clazz)[field.name]
  }
  let signature = 'none'
  if (packet.signature) {
    signature = packet.signature.matches(KEY) ? 'right' : 'wrong'
  }
  return {
    id: packet.header.msgid,
    magic: clazz.MAGIC_NUMBER,
    payloadLength: clazz.PAYLOAD_LENGTH,
    system: packet.header.sysid,
    component: packet.header.compid,
    sequence: packet.header.seq,
    signature,
    fields,
  }
}

// A way for bytes into node-mavlink's own parser: frames with a wrong checksum do not come out of it.
function makeReader(use) {
  const input = new PassThrough()
  input.pipe(new MavLinkPacketSplitter()).pipe(new MavLinkPacketParser()).on('data', use)
  return input
}

function read() {
  const input = makeReader((packet) => print(describe(packet)))
  readline.createInterface({ input: process.stdin })
    .on('line', (line) => input.write(Buffer.from(JSON.parse(line).hex, 'hex')))
    .on('close', () => input.end())
}

function fill(message, fields) {
  return Object.assign(message, fields)
}

// A reading in every message that has one, and the same in the body's axes: x forward, y left, z up.
function inertial() {
  const floats = { xacc: 0.5, yacc: -0.25, zacc: -9.75, xgyro: 0.125, ygyro: 0.5, zgyro: -2.5 }
  const integers = { xacc: 51, yacc: -25, zacc: -1002, xgyro: 125, ygyro: 500, zgyro: -2500, temperature: 3125 }
  const scaled = { timeUs: '7654321000', force: [51, 25, 1002].map((x) => x * 9.80665e-3), rate: [0.125, -0.5, 2.5],
    id: 0, complete: true }
  return [
    [fill(new common.HighresImu(), { ...floats, timeUsec: 7654321987n, fieldsUpdated: 0x3f, id: 2 }),
      { timeUs: '7654321987', force: [0.5, 0.25, 9.75], rate: [0.125, -0.5, 2.5], id: 2, complete: true }],
    [fill(new common.HighresImu(), { ...floats, timeUsec: 1n, fieldsUpdated: 0x1f, id: 0 }),
      { timeUs: '1', force: [0.5, 0.25, 9.75], rate: [0.125, -0.5, 2.5], id: 0, complete: false }],
    [fill(new common.RawImu(), { ...integers, timeUsec: 7654321987n, id: 1 }),
      { ...scaled, timeUs: '7654321987', id: 1 }],
    [fill(new common.ScaledImu(), { ...integers, timeBootMs: 7654321 }), scaled],
    [fill(new common.ScaledImu2(), { ...integers, timeBootMs: 7654321 }), scaled],
    [fill(new common.ScaledImu3(), { ...integers, timeBootMs: 7654321 }), scaled],
  ]
}

function write() {
  const protocol = new MavLinkProtocolV2(1, 1)
  const signing = new MavLinkProtocolV2(1, 1, MavLinkProtocolV2.IFLAG_SIGNED)
  const heartbeat = { customMode: 65536, type: 2, autopilot: 12, baseMode: 0x81, systemStatus: 4 }
  const command = { command: 31011, _param1: -12.5, _param4: 7.25, targetSystem: 1, targetComponent: 197 }
  const expectedCommand = { command: 31011, param1: -12.5, param4: 7.25, targetSystem: 1, targetComponent: 197 }
  const timesync = { tc1: 0n, ts1: -1234567890123456789n, targetSystem: 1, targetComponent: 197 }
  const messages = [
    [fill(new minimal.Heartbeat(), heartbeat), heartbeat],
    [fill(new common.TimeSync(), timesync), timesync],
    [fill(new common.TimeSync(), { tc1: 5n, ts1: 0n }), { tc1: 5n, ts1: 0n, targetSystem: 0, targetComponent: 0 }],
    [fill(new common.CommandLong(), command), expectedCommand],
    [fill(new common.CommandInt(), { ...command, param1: -12.5, param4: 7.25 }), expectedCommand],
    [fill(new common.Attitude(), { roll: 1, pitch: 2, yaw: 3 }), null],
    [fill(new common.CommandAck(), { command: 511, result: 2, targetSystem: 1, targetComponent: 197 }),
      { command: 511, result: 2, targetSystem: 1, targetComponent: 197 }],
    ...inertial(),
    [fill(new common.DistanceSensor(), { timeBootMs: 7654321, minDistance: 20, maxDistance: 1200, currentDistance: 153,
      type: 0, id: 3, orientation: 25, covariance: 4, horizontalFov: 0.5, verticalFov: 0.25, quaternion: [1, 0, 0, 0],
      signalQuality: 80 }),
      { timeMs: 7654321, minCm: 20, maxCm: 1200, distanceCm: 153, id: 3, orientation: 25, quality: 80, isOfGround: true }],
    [fill(new minimal.Heartbeat(), heartbeat), heartbeat, 'ok'],
    [fill(new common.CommandLong(), command), expectedCommand, 'ok'],
  ]
  messages.forEach(([message, fields, signature], index) => {
    const sequence = (index < 5 ? 252 : 254) + index  // two are lost on the way
    let frame = (signature ? signing : protocol).serialize(message, sequence % 256)
    if (signature) {
      frame = signing.sign(frame, 3, KEY, SIGNED_AT_MS + index)
    }
    print({
      id: message.constructor.MSG_ID,
      sequence: sequence % 256,
      signature: signature || 'none',
      hex: frame.toString('hex'),
      fields,
    })
  })
}

function listen() {
  const socket = dgram.createSocket('udp4')
  const input = makeReader((packet) => print(describe(packet)))
  socket.on('message', (datagram) => input.write(datagram))
  socket.bind(0, '127.0.0.1', () => process.stdout.write(`${socket.address().port}\n`))
  process.stdin.on('data', () => setTimeout(() => { socket.close(); input.end(); process.stdin.destroy() }, 300))
}

const modes = { read, write, listen }
modes[process.argv[2]]()
