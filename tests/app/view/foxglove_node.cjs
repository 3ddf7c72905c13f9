// SPDX-License-Identifier: BSD-2-Clause
// The other side of foxglove_node_test.py: @foxglove/ws-protocol's client, found through NODE_PATH.
//
// node foxglove_node.cjs URL          subscribes to every channel, and prints a line of JSON for each thing it hears
//                                      until the server goes: {info}, {channels}, {protocol}, {topic, time, data}
// node foxglove_node.cjs schemas       prints the schemas that Foxglove publishes, by name
'use strict'

const { FoxgloveClient } = require('@foxglove/ws-protocol')
const { WebSocket } = require('ws')

const PROTOCOLS = ['foxglove.sdk.v1', FoxgloveClient.SUPPORTED_SUBPROTOCOL]
const print = (object) => process.stdout.write(JSON.stringify(object) + '\n')

function listen(url) {
  const socket = new WebSocket(url, PROTOCOLS)
  const client = new FoxgloveClient({ ws: socket })
  const topics = new Map()
  const text = new TextDecoder()
  client.on('open', () => print({ protocol: socket.protocol }))
  client.on('error', (error) => print({ error: String(error) }))
  client.on('status', (status) => print({ error: status.message }))
  client.on('serverInfo', (info) => print({ info }))
  client.on('time', (time) => print({ now: String(time.timestamp) }))
  client.on('advertise', (channels) => {
    print({ channels })
    for (const channel of channels) {
      topics.set(client.subscribe(channel.id), channel.topic)
    }
    print({ subscribed: topics.size })
  })
  client.on('message', ({ subscriptionId, timestamp, data }) => {
    print({ topic: topics.get(subscriptionId), time: String(timestamp), data: JSON.parse(text.decode(data)) })
  })
  client.on('close', () => process.exit(0))
}

if (process.argv[2] === 'schemas') {
  print(require('@foxglove/schemas/jsonschema'))
} else {
  listen(process.argv[2])
}
