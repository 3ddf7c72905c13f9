// SPDX-License-Identifier: BSD-2-Clause
// The live view from the side of a client of Foxglove's protocol. tests/app/view/foxglove_node_test.py has another
// one's word on it.
#include <catch2/catch.hpp>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "app/foxglove/schemas.h"
#include "app/view/foxglove_hub.h"
#include "app/view/live_view.h"
#include "tests/app/foxglove/schema_check.h"
#include "tests/app/view/view_client.h"

namespace facet::foxglove_view_test {
namespace {

using Client = test::ViewClient;
using nlohmann::json;
using test::state_at;
using test::with_faces;

const test::ViewClientOptions kFoxglove{.target = "/", .origin = "", .protocols = "foxglove.websocket.v1"};

/// A message as a client sees it.
struct Heard {
    json text;                  ///< of a text message
    std::uint32_t id = 0;       ///< of a subscription; 0 with a time
    std::uint64_t time_ns = 0;  ///< of binary ones
    json data;                  ///< of a message of a topic
    std::size_t bytes = 0;
};

std::uint64_t little(const std::string& bytes, std::size_t at, std::size_t count) {
    std::uint64_t value = 0;
    for (std::size_t i = count; i-- > 0;) {
        value = value << 8U | static_cast<std::uint8_t>(bytes.at(at + i));
    }
    return value;
}

Heard hear(Client& client) {
    const std::string message = client.read();
    if (!client.is_binary()) {
        return {.text = json::parse(message), .data = {}};
    }
    if (message.at(0) == 2) {
        REQUIRE(message.size() == 9);
        return {.text = {}, .time_ns = little(message, 1, 8), .data = {}};
    }
    REQUIRE(message.at(0) == 1);
    return {.text = {},
            .id = static_cast<std::uint32_t>(little(message, 1, 4)),
            .time_ns = little(message, 5, 8),
            .data = json::parse(message.substr(13)),
            .bytes = message.size()};
}

/// The next message that is no time.
Heard hear_data(Client& client) {
    Heard heard = hear(client);
    while (heard.text.is_null() && heard.id == 0) {
        heard = hear(client);
    }
    return heard;
}

/// Channels by topic, after the greeting.
std::map<std::string, json> channels_of(Client& client) {
    const json greeting = hear(client).text;
    CHECK(greeting["op"] == "serverInfo");
    CHECK(greeting["capabilities"] == json{"time"});
    const json list = hear(client).text;
    CHECK(list["op"] == "advertise");
    std::map<std::string, json> channels;
    for (const json& channel : list["channels"]) {
        channels[channel["topic"]] = channel;
    }
    return channels;
}

json subscription(std::uint32_t id, const json& channel) {
    return {{"op", "subscribe"}, {"subscriptions", {{{"id", id}, {"channelId", channel["id"]}}}}};
}

bool has_come(const LiveView& view, std::uint64_t clients) {
    return test::comes_true([&] { return view.account().foxglove == clients; });
}

LiveView::Fillers with_everything() {
    LiveView::Fillers fillers = with_faces(2);
    fillers.picture = [](ViewPicture& picture) {
        picture = {.width = 2, .height = 1, .pixels = {7, 200}, .points = {}};
    };
    fillers.calibration = [](CalibrationEstimate& calibration) { calibration.correction.time_offset_s = 0.5; };
    return fillers;
}

TEST_CASE("a client is sent all topics, and what it subscribes to, as the schemas say") {
    LiveView view({});
    Client client(view, kFoxglove);
    CHECK(client.protocol() == "foxglove.websocket.v1");
    const std::map<std::string, json> channels = channels_of(client);
    REQUIRE(channels.size() == kFoxgloveTopics);
    std::map<std::uint32_t, json> schemas;
    for (const auto& [topic, channel] : channels) {
        CHECK(channel["encoding"] == "json");
        CHECK(channel["schemaEncoding"] == "jsonschema");
        const std::uint32_t id = channel["id"].get<std::uint32_t>() + 100;
        client.write(subscription(id, channel).dump());
        schemas[id] = json::parse(channel["schema"].get<std::string>());
    }
    REQUIRE(test::comes_true([&] { return view.wants_calibration() && view.wants_picture(Timestamp{0}, true); }));
    ViewState state = state_at(4);
    state.is_keyframe = true;
    state.T_B_C.p = {0.1, 0.2, 0.3};
    // A subscription that is not there is answered: all those before it have arrived.
    client.write(R"({"op":"unsubscribe","subscriptionIds":[1]})");
    CHECK(hear_data(client).text["op"] == "status");
    view.offer(state, with_everything());
    std::set<std::uint32_t> heard;
    for (int i = 0; i < 60 && heard.size() < kFoxgloveTopics; ++i) {
        const Heard message = hear_data(client);
        REQUIRE(schemas.contains(message.id));
        CHECK(test::schema_fault(message.data, schemas[message.id]).empty());
        CHECK(message.time_ns == static_cast<std::uint64_t>(state.stamp.ns));
        heard.insert(message.id);
    }
    CHECK(heard.size() == kFoxgloveTopics);
}

TEST_CASE("poses are those that were offered, all of them, and their times come with them") {
    LiveView view({});
    Client client(view, kFoxglove);
    const auto channels = channels_of(client);
    client.write(subscription(3, channels.at("/pose")).dump());
    client.write(subscription(4, channels.at("/image")).dump());
    REQUIRE(test::comes_true([&] { return view.wants_picture(Timestamp{0}, true); }));  // so the first has arrived too
    for (int frame = 0; frame < 20; ++frame) {  // faster than the server's thread looks
        view.offer(state_at(frame));
    }
    for (int frame = 0; frame < 20; ++frame) {
        const Heard pose = hear_data(client);
        CHECK(pose.id == 3);
        CHECK(pose.time_ns == static_cast<std::uint64_t>(state_at(frame).stamp.ns));
        CHECK(pose.data["pose"]["position"]["x"] == 1.0 * frame);
    }
    ViewState none = state_at(20);
    none.has_pose = false;
    view.offer(none);
    client.write(R"({"op":"unsubscribe","subscriptionIds":[4]})");
    REQUIRE(test::comes_true([&] { return !view.wants_picture(Timestamp{0}, true); }));
    view.offer(state_at(21));
    CHECK(hear_data(client).data["pose"]["position"]["x"] == 21.0);
}

TEST_CASE("whoever comes late is given mesh, path and the camera's place at once") {
    LiveView view({});
    ViewState state = state_at(1);
    state.is_keyframe = true;
    state.T_B_C.p = {0.1, 0.2, 0.3};
    view.offer(state, with_faces(3));
    Client client(view, {.target = "/", .origin = "", .protocols = "other, foxglove.sdk.v1"});
    CHECK(client.protocol() == "foxglove.sdk.v1");
    const auto channels = channels_of(client);
    client.write(subscription(1, channels.at("/mesh")).dump());
    const json mesh = hear_data(client).data;
    CHECK(mesh["entities"][0]["triangles"][0]["points"].size() == 9);
    client.write(subscription(2, channels.at("/path")).dump());
    CHECK(hear_data(client).data["poses"][0]["position"]["x"] == 1.0);
    client.write(subscription(3, channels.at("/tf")).dump());
    const json camera = hear_data(client).data;
    CHECK(camera["parent_frame_id"] == "body");
    CHECK(camera["translation"] == json{{"x", 0.1}, {"y", 0.2}, {"z", 0.3}});
}

TEST_CASE("the path restarts after a restart and keeps the newest keyframes") {
    LiveView view({});
    Client client(view, kFoxglove);
    client.write(subscription(1, channels_of(client).at("/path")).dump());
    ViewState state = state_at(0);
    state.is_keyframe = true;
    const auto path_after = [&](double x, std::uint32_t resets) {
        state.stamp = state.stamp + Duration{1'000'000};
        state.T_W_B.p.x() = x;
        state.health.reset_counter = resets;
        view.offer(state);
        json poses;
        while (poses.empty() || poses.back()["position"]["x"] != x) {
            poses = hear_data(client).data["poses"];
        }
        return poses;
    };
    CHECK(path_after(1.0, 0).size() == 1);
    CHECK(path_after(2.0, 0).size() == 2);
    const json after = path_after(3.0, 1);
    REQUIRE(after.size() == 1);
    for (int i = 0; i < static_cast<int>(FlightPath::kMostPoses) + 20; ++i) {
        if (i % 20 == 19) {  // heard before more is offered than waits for the server's thread
            path_after(10.0 + i, 1);
        } else {
            state.T_W_B.p.x() = 10.0 + i;
            view.offer(state);
        }
    }
    const json full = path_after(5.0, 1);
    CHECK(full.size() == FlightPath::kMostPoses);
    CHECK(full[0]["position"]["x"].get<double>() > 20.0);
}

TEST_CASE("what is no message of the protocol is answered in words, and changes nothing") {
    LiveView view({});
    Client client(view, kFoxglove);
    const json channel = channels_of(client).at("/health");
    const auto answer_to = [&](const std::string& text) {
        client.write(text);
        const json answer = hear_data(client).text;
        CHECK(answer["op"] == "status");
        CHECK(answer["level"] == 1);
        return answer["message"].get<std::string>();
    };
    for (const char* const text : {"", "{", "[]", "7", R"({"op":7})", R"({"subscriptions":[]})"}) {
        CHECK(answer_to(text).find("no JSON object with an op") != std::string::npos);
    }
    CHECK(answer_to(R"({"op":"advertise","channels":[]})") == "only subscribe and unsubscribe are served");
    CHECK(answer_to(R"({"op":"subscribe"})") == "subscribe needs a list of subscriptions");
    for (const char* const entry :
         {"null", "5", "{}", R"({"id":1})", R"({"id":1,"channelId":0})", R"({"id":1,"channelId":10})",
          R"({"id":-1,"channelId":1})", R"({"id":1.5,"channelId":1})", R"({"id":99999999999,"channelId":1})"}) {
        CHECK(answer_to(std::string(R"({"op":"subscribe","subscriptions":[)") + entry + "]}")
                  .find("needs an id and the channelId") != std::string::npos);
    }
    client.write(subscription(8, channel).dump());
    CHECK(answer_to(subscription(9, channel).dump()).find("already") != std::string::npos);
    CHECK(answer_to(R"({"op":"unsubscribe","subscriptionIds":[3]})") == "there is no such subscription");
    CHECK(answer_to(R"({"op":"unsubscribe","subscriptionIds":["8"]})") == "there is no such subscription");
    view.offer(state_at(0));
    CHECK(hear_data(client).id == 8);
}

TEST_CASE("Foxglove's own pages may connect, others may not, and no one without the protocol") {
    LiveView view({});
    const auto connect = [&](const std::string& origin, const std::string& protocols) {
        return Client(view, {.target = "/", .origin = origin, .protocols = protocols}).protocol();
    };
    CHECK(connect("https://app.foxglove.dev", "foxglove.websocket.v1") == "foxglove.websocket.v1");
    CHECK(connect("file://", "foxglove.sdk.v1, foxglove.websocket.v1") == "foxglove.websocket.v1");
    CHECK_THROWS(connect("https://elsewhere.example", "foxglove.websocket.v1"));
    CHECK_THROWS(connect("null", "foxglove.websocket.v1"));
    CHECK_THROWS(connect("https://app.foxglove.dev", ""));
    CHECK_THROWS(connect("", "foxglove.websocket.v9"));
}

TEST_CASE("a client that reads nothing holds up nobody and loses old messages only") {
    LiveView view({});
    Client stalled(view, {.target = "/", .origin = "", .protocols = "foxglove.websocket.v1", .receive_buffer = 4096});
    Client good(view, kFoxglove);
    for (Client* client : {&stalled, &good}) {
        const auto channels = channels_of(*client);
        client->write(subscription(1, channels.at("/mesh")).dump());
        client->write(subscription(2, channels.at("/pose")).dump());
    }
    REQUIRE(has_come(view, 2));
    std::chrono::steady_clock::duration longest{};
    // Several times as many where the view is slow, as in a sanitizer: it takes the newest of several frames then.
    for (int frame = 0; frame < 60 || (frame < 600 && view.account().replaced <= 10); ++frame) {
        const auto begin = std::chrono::steady_clock::now();
        view.offer(state_at(frame), with_faces(LiveView::kMaxFaces));
        longest = std::max(longest, std::chrono::steady_clock::now() - begin);
        std::this_thread::sleep_for(std::chrono::milliseconds(35));
    }
    CHECK(std::chrono::duration<double>(longest).count() < 0.25);
    CHECK(view.account().replaced > 10);
    view.offer(state_at(1000));
    double newest = 0.0;
    std::size_t largest = 0;
    for (int messages = 0; messages < 4000 && newest < 1000.0; ++messages) {
        const Heard heard = hear_data(good);
        newest = heard.id == 2 ? heard.data["pose"]["position"]["x"].get<double>() : newest;
        largest = std::max(largest, heard.bytes);
    }
    CHECK(newest == 1000.0);
    CHECK(largest > LiveView::kMaxFaces * 100);
}

}  // namespace
}  // namespace facet::foxglove_view_test
