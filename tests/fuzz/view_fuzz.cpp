// SPDX-License-Identifier: BSD-2-Clause
// What browsers and clients of Foxglove send to the live view. The first byte chooses: any bytes at all, any bytes
// after the handshake of a WebSocket, or frames of Foxglove's protocol. Whatever they are, the next one who asks is
// answered.
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <string>

#include "app/support/input_error.h"
#include "app/view/live_view.h"
#include "app/view/view_place.h"
#include "tests/fuzz/fuzz_input.h"

using namespace facet;

namespace {

/// One connection, which leaves no port behind.
class Connection {
public:
    explicit Connection(std::uint16_t port) : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
        const timeval limit{2, 0};
        const linger none{1, 0};
        (void)::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
        (void)::setsockopt(socket_, SOL_SOCKET, SO_SNDTIMEO, &limit, sizeof limit);
        (void)::setsockopt(socket_, SOL_SOCKET, SO_LINGER, &none, sizeof none);
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_port = htons(port);
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        int result = -1;
        do {  // libFuzzer's timer interrupts
            result = ::connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address);
        } while (result != 0 && (errno == EINTR || errno == EALREADY));
        test::require(result == 0 || errno == EISCONN);
    }
    ~Connection() { ::close(socket_); }
    Connection(const Connection&) = delete;
    Connection& operator=(const Connection&) = delete;

    /// The server may have closed already.
    void send(std::string_view text) { (void)::send(socket_, text.data(), text.size(), MSG_NOSIGNAL); }
    void end() { (void)::shutdown(socket_, SHUT_WR); }
    /// What comes next; empty at the end.
    std::string read() {
        std::array<char, 4096> bytes{};
        ssize_t size = -1;
        do {  // libFuzzer's timer interrupts
            size = ::recv(socket_, bytes.data(), bytes.size(), 0);
        } while (size < 0 && errno == EINTR);
        return {bytes.data(), static_cast<std::size_t>(std::max<ssize_t>(size, 0))};
    }
    /// Reads to the end, which must come: whoever says nothing more is let go.
    void drain() {
        for (std::string more = read(); !more.empty(); more = read()) {
        }
    }

private:
    int socket_;
};

std::string handshake(const char* target, const char* protocols) {
    return std::string("GET ") + target +
           " HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: upgrade\r\n"
           "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n" +
           protocols + "\r\n";
}

/// A client's frame of up to 125 bytes; its mask is zero.
std::string frame(std::uint8_t head, std::span<const std::uint8_t> payload) {
    std::string text{static_cast<char>(head), static_cast<char>(0x80U | payload.size()), 0, 0, 0, 0};
    text.append(reinterpret_cast<const char*>(payload.data()), payload.size());
    return text;
}

void check_texts(std::string_view text) {
    (void)has_token(text, "0123456789abcdef");
    (void)is_own_name(text);
    test::require(path_of(text).size() <= text.size());
    try {
        const ViewPlace place = parse_view_place(std::string(text));
        test::require(to_text(parse_view_place(to_text(place))) == to_text(place));
    } catch (const InputError&) {  // the one way to say no
    }
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static LiveView view({});
    static int frames = 0;
    check_texts({reinterpret_cast<const char*>(data), std::min<std::size_t>(size, 200)});
    test::FuzzInput input(data, size);
    const auto kind = input.take<std::uint8_t>() % 3;
    {
        Connection client(view.place().port);
        if (kind > 0) {
            client.send(kind == 1 ? handshake("/live", "")
                                  : handshake("/", "Sec-WebSocket-Protocol: foxglove.websocket.v1\r\n"));
            test::require(client.read().starts_with("HTTP/1.1 101"));
        }
        while (kind == 2 && !input.empty()) {
            const auto head = input.take<std::uint8_t>();
            const std::size_t length = input.take<std::uint8_t>() % 126U;
            client.send(frame(head, input.take_bytes(length)));
        }
        client.send(input.rest_as_text());
        ViewState state;
        state.stamp = Timestamp{1'000'000'000 + 50'000'000LL * ++frames};
        view.offer(state);
        client.end();
        client.drain();
    }
    Connection next(view.place().port);
    next.send("GET / HTTP/1.1\r\nHost: localhost\r\n\r\n");
    test::require(next.read().starts_with("HTTP/1.1 200"));
    return 0;
}
