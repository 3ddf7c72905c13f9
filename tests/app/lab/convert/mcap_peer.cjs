// SPDX-License-Identifier: BSD-2-Clause
// The other side of mcap_peer_test.py: @mcap/core, found through NODE_PATH.
//
// node mcap_peer.cjs read FILE              prints what the file holds as JSON; its checksums are checked
// node mcap_peer.cjs write FROM TO KIND     writes anew what FROM holds. KIND: zstd, plain (chunks without
//                                           compression), bare (no indices, nothing repeated in the summary), loose
//                                           (messages outside chunks)
// node mcap_peer.cjs schemas                prints Foxglove's own schemas as JSON
'use strict'

const crypto = require('crypto')
const fs = require('fs')
const { McapIndexedReader, McapStreamReader, McapWriter } = require('@mcap/core')
const { loadDecompressHandlers } = require('@mcap/support')

const sha256 = (bytes) => crypto.createHash('sha256').update(bytes).digest('hex')
const plain = (key, value) => (typeof value === 'bigint' ? value.toString() : value)
const print = (object) => process.stdout.write(JSON.stringify(object, plain) + '\n')

function readableOf(path) {
  const bytes = fs.readFileSync(path)
  return {
    bytes,
    size: async () => BigInt(bytes.length),
    read: async (offset, size) => new Uint8Array(bytes.subarray(Number(offset), Number(offset + size))),
  }
}

async function read(path) {
  const decompressHandlers = await loadDecompressHandlers()
  const readable = readableOf(path)
  const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers })
  const topics = {}
  for (const channel of reader.channelsById.values()) {
    const schema = reader.schemasById.get(channel.schemaId)
    topics[channel.topic] = {
      encoding: channel.messageEncoding,
      schema: schema.name,
      schemaEncoding: schema.encoding,
      schemaText: Buffer.from(schema.data).toString(),
      messages: [],
    }
  }
  for await (const message of reader.readMessages()) {
    const { topic } = reader.channelsById.get(message.channelId)
    const content = JSON.parse(Buffer.from(message.data).toString())
    if (content.data !== undefined) {
      content.data = sha256(Buffer.from(content.data, 'base64'))
    }
    topics[topic].messages.push({ time: message.logTime, content })
  }
  const attachments = {}
  for await (const attachment of reader.readAttachments()) {
    attachments[attachment.name] = sha256(attachment.data)
  }
  const records = {}
  const stream = new McapStreamReader({ validateCrcs: true, decompressHandlers })
  stream.append(readable.bytes)
  for (let record; (record = stream.nextRecord());) {
    records[record.type] = (records[record.type] ?? 0) + 1
  }
  print({
    profile: reader.header.profile, statistics: { ...reader.statistics, channelMessageCounts: undefined },
    topics, attachments, records, done: stream.done(),
  })
}

async function compressor(kind) {
  if (kind !== 'zstd') {
    return undefined
  }
  const zstd = require('@foxglove/wasm-zstd')
  await zstd.isLoaded
  return (data) => ({ compression: 'zstd', compressedData: zstd.compress(data, 3) })
}

async function write(from, to, kind) {
  const reader = await McapIndexedReader.Initialize({
    readable: readableOf(from), decompressHandlers: await loadDecompressHandlers(),
  })
  const pieces = []
  let size = 0n
  const bare = kind === 'bare'
  const writer = new McapWriter({
    writable: {
      position: () => size,
      write: async (bytes) => {
        pieces.push(Buffer.from(bytes))
        size += BigInt(bytes.length)
      },
    },
    useChunks: kind !== 'loose', chunkSize: 20000, compressChunk: await compressor(kind),
    useMessageIndex: !bare, useChunkIndex: !bare, repeatChannels: !bare, repeatSchemas: !bare, useStatistics: !bare,
    useSummaryOffsets: !bare, useAttachmentIndex: !bare,
  })
  await writer.start({ profile: '', library: 'mcap_peer' })
  const ids = new Map()
  for (const channel of reader.channelsById.values()) {
    const schemaId = await writer.registerSchema(reader.schemasById.get(channel.schemaId))
    ids.set(channel.id, await writer.registerChannel({ ...channel, schemaId }))
  }
  for await (const attachment of reader.readAttachments()) {
    await writer.addAttachment(attachment)
  }
  await writer.addMetadata({ name: 'notes', metadata: new Map([['key', 'value']]) })
  for await (const message of reader.readMessages()) {
    await writer.addMessage({ ...message, channelId: ids.get(message.channelId) })
  }
  await writer.end()
  fs.writeFileSync(to, Buffer.concat(pieces))
}

function schemas() {
  const { CompressedImage, PoseInFrame } = require('@foxglove/schemas/jsonschema')
  print({ 'foxglove.CompressedImage': CompressedImage, 'foxglove.PoseInFrame': PoseInFrame })
}

const [mode, ...rest] = process.argv.slice(2)
Promise.resolve({ read, write, schemas }[mode](...rest)).catch((error) => {
  console.error(error)
  process.exit(1)
})
