// SPDX-License-Identifier: BSD-2-Clause
// Where the live view listens, and who may look.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace facet {

/// An address of this computer and a port.
struct ViewPlace {
    std::string address = "127.0.0.1";  ///< IPv4 or IPv6, in numbers
    std::uint16_t port = 0;             ///< 0: any that is free
};

/// [ADDRESS:]PORT, an IPv6 address in brackets; loopback without one. Throws InputError. Reentrant. Heap.
ViewPlace parse_view_place(const std::string& text);

/// As in a URL: an IPv6 address in brackets. Reentrant. Heap.
std::string to_text(const ViewPlace& place);

/// Whether only programs on this computer can reach the address. Reentrant.
bool is_loopback(const std::string& address);

/// The first line of a file: 16 to 256 letters, digits and characters out of "-._~", which need no escape in a URL.
/// Throws InputError, which does not show the token. Reentrant. Heap.
std::string read_view_token(const std::string& path);

/// Whether the query of a request's target, such as /live?token=T, has the token. Takes as long whatever the query has.
/// Reentrant. Heap.
bool has_token(std::string_view target, std::string_view token);

/// The target without its query. Reentrant. No heap.
std::string_view path_of(std::string_view target);

/// Whether a Host is a name under which a browser on this computer reaches it: another name that leads here is
/// someone's trick to have a page of theirs read along (DNS rebinding). Reentrant. Heap.
bool is_own_name(std::string_view host);

}  // namespace facet
