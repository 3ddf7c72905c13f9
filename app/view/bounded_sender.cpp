// SPDX-License-Identifier: BSD-2-Clause
#include "app/view/bounded_sender.h"

#include <algorithm>
#include <utility>

namespace facet {

std::size_t BoundedSender::waiting(std::size_t lane) const {
    return static_cast<std::size_t>(std::ranges::count(waiting_, lane, &Message::lane));
}

bool BoundedSender::put(Message message, std::size_t depth, const std::shared_ptr<void>& owner) {
    const bool is_full = waiting(message.lane) >= depth;
    if (is_full) {
        waiting_.erase(std::ranges::find(waiting_, message.lane, &Message::lane));
    }
    waiting_.push_back(std::move(message));
    send(owner);
    return is_full;
}

void BoundedSender::drop(std::size_t lane) {
    std::erase_if(waiting_, [&](const Message& message) { return message.lane == lane; });
}

void BoundedSender::send(const std::shared_ptr<void>& owner) {
    if (under_way_ || waiting_.empty()) {
        return;
    }
    under_way_ = std::move(waiting_.front());
    waiting_.pop_front();
    stream_.binary(under_way_->is_binary);
    const std::array<boost::asio::const_buffer, 2> parts{
        boost::asio::buffer(under_way_->head, under_way_->head_size),
        under_way_->body ? boost::asio::buffer(*under_way_->body) : boost::asio::const_buffer()};
    stream_.async_write(parts, [this, owner](boost::beast::error_code error, std::size_t) {
        under_way_.reset();
        if (error) {
            waiting_.clear();
            on_error_();
        } else {
            send(owner);
        }
    });
}

}  // namespace facet
