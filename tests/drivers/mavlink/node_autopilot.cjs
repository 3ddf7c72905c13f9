// SPDX-License-Identifier: BSD-2-Clause
// A flight controller made of node-mavlink, found through NODE_PATH, for imu_mavlink_flight_test.py.
//
// node node_autopilot.cjs DATA_CSV MESSAGE DRIFT JITTER_MS LOSS
// Plays the inertial samples of a log (data.csv as EuRoC has it, in axes x forward, y left, z up) once they are asked
// for by SET_MESSAGE_INTERVAL, three seconds later, each at its time. Its clock drifts, and each reading waits up to
// JITTER_MS. Without LOSS readings stay in order, as on a serial line; else that share of them never comes, and some
// overtake others. Prints the port, then the monotonic time of the first sample.
'use strict'

const dgram = require('dgram')
const fs = require('fs')
const { PassThrough } = require('stream')
const { MavLinkPacketParser, MavLinkPacketSplitter, MavLinkProtocolV2, common } = require('node-mavlink')

const [file, kind, drift, jitterMs, loss] = [process.argv[2], process.argv[3], ...process.argv.slice(4).map(Number)]
const BOOT_NS = process.hrtime.bigint() - 500_000_000_000n
const protocol = new MavLinkProtocolV2(1, 1)
const socket = dgram.createSocket('udp4')
let sequence = 0
let peer = null
let beginNs = null

// Repeatable, so that a failure is.
let seed = 12345
function random() {
  seed = (seed * 1103515245 + 12345) % 2147483648
  return seed / 2147483648
}

const bootNs = (ns) => BigInt(Math.round(Number(ns - BOOT_NS) * (1 + drift)))

function send(message) {
  socket.send(protocol.serialize(message, sequence), peer.port, peer.address)
  sequence = (sequence + 1) % 256
}

const samples = fs.readFileSync(file, 'utf8').split('\n').filter((line) => line && !line.startsWith('#'))
  .map((line) => { const [ns, ...values] = line.split(','); return { ns: BigInt(ns), values: values.map(Number) } })

function reading({ ns, values: [wx, wy, wz, ax, ay, az] }) {
  const timeUsec = bootNs(beginNs + (ns - samples[0].ns)) / 1000n
  if (kind === 'raw_imu') {
    const g = 9.80665e-3
    return Object.assign(new common.RawImu(), { timeUsec, xacc: Math.round(ax / g), yacc: Math.round(-ay / g),
      zacc: Math.round(-az / g), xgyro: Math.round(wx * 1e3), ygyro: Math.round(-wy * 1e3), zgyro: Math.round(-wz * 1e3),
      id: 0 })
  }
  return Object.assign(new common.HighresImu(), { timeUsec, xacc: ax, yacc: -ay, zacc: -az, xgyro: wx, ygyro: -wy,
    zgyro: -wz, fieldsUpdated: 0x1e3f, id: 0 })
}

let next = 0
const line = []  // readings on their way, in order
function play() {
  const now = process.hrtime.bigint()
  for (; next < samples.length && beginNs + (samples[next].ns - samples[0].ns) <= now; ++next) {
    const message = reading(samples[next])
    const delayMs = random() * jitterMs
    if (loss === 0) {
      line.push({ message, due: now + BigInt(Math.round(delayMs * 1e6)) })
    } else if (random() >= loss) {
      setTimeout(() => send(message), delayMs)
    }
  }
  while (line.length > 0 && line[0].due <= now) {
    send(line.shift().message)
  }
  setTimeout(play, 1)
}

const input = new PassThrough()
input.pipe(new MavLinkPacketSplitter()).pipe(new MavLinkPacketParser()).on('data', (packet) => {
  if (packet.header.msgid === common.TimeSync.MSG_ID) {
    const question = packet.protocol.data(packet.payload, common.TimeSync)
    if (question.tc1 === 0n) {
      // Both ways have the same delays, as if the question came later than it did: timers here are whole milliseconds.
      const [upMs, downMs] = [random() * jitterMs, random() * jitterMs]
      const tc1 = bootNs(process.hrtime.bigint() + BigInt(Math.round(upMs * 1e6)))
      const answer = Object.assign(new common.TimeSync(), { tc1, ts1: question.ts1, targetSystem: 1,
        targetComponent: 197 })
      setTimeout(() => send(answer), Math.ceil(upMs + downMs))
    }
  } else if (packet.header.msgid === common.CommandLong.MSG_ID) {
    const command = packet.protocol.data(packet.payload, common.CommandLong)
    const isAsked = command.command === 511 && command._param1 === (kind === 'raw_imu' ? 27 : 105)
    send(Object.assign(new common.CommandAck(), { command: command.command, result: isAsked ? 0 : 2, targetSystem: 1,
      targetComponent: 197 }))
    if (isAsked && beginNs === null) {
      beginNs = process.hrtime.bigint() + 3_000_000_000n
      process.stdout.write(`${beginNs}\n`)
      play()
    }
  }
})
socket.on('message', (datagram, from) => { peer = from; input.write(datagram) })
socket.bind(0, '127.0.0.1', () => process.stdout.write(`${socket.address().port}\n`))
