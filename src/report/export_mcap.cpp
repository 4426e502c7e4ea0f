#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>

#include "report/export_formats.hpp"
#include "report/text.hpp"

namespace stonestack::report {
namespace {

using nlohmann::json;

// Record types of MCAP (mcap.dev/spec, version 0).
enum class McapRecord : std::uint8_t {
  kHeader = 1,
  kFooter = 2,
  kSchema = 3,
  kChannel = 4,
  kMessage = 5,
  kChunk = 6,
  kMessageIndex = 7,
  kChunkIndex = 8,
  kStatistics = 11,
  kDataEnd = 15
};
constexpr std::string_view kMcapMagic("\x89MCAP0\r\n", 8);

template <class Number>
void put(std::string& bytes, Number value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}
void put_text(std::string& bytes, std::string_view text) {
  put(bytes, static_cast<std::uint32_t>(text.size()));
  bytes += text;
}
void put_record(std::string& file, McapRecord type, const std::string& content) {
  put(file, static_cast<std::uint8_t>(type));
  put(file, static_cast<std::uint64_t>(content.size()));
  file += content;
}

/// A topic with the properties of its messages: name and JSON type.
struct Topic {
  const char* topic;
  const char* schema;
  json properties;
};

json schema_of(const char* type) {
  return {{"type", type}};
}
json list_of(const json& items) {
  return {{"type", "array"}, {"items", items}};
}

std::vector<Topic> topics() {
  const json number = schema_of("number"), text = schema_of("string"), flag = schema_of("boolean"),
             pose = {{"type", "object"}};
  return {{"/joints", "stonestack.joints", {{"q", list_of(number)}}},
          {"/gripper", "stonestack.gripper", {{"opening", number}, {"force", number}, {"holds", flag}}},
          {"/stones", "stonestack.stone", {{"stone", text}, {"T_W_O", pose}}},
          {"/placements",
           "stonestack.placement",
           {{"stone", text}, {"level", schema_of("integer")}, {"outcome", text}, {"T_W_O_planned", pose}}},
          {"/log", "stonestack.log", {{"text", text}}}};
}

struct TimedMessage {
  double time;
  std::uint16_t channel;  ///< from 1, in the order of `topics`
  json data;
};

std::vector<TimedMessage> messages_of(const RunRecord& record) {
  std::vector<TimedMessage> list;
  double last = 0.0;
  for (const RecordedSample& s : record.samples) {
    list.push_back({s.time, 1, {{"q", std::vector<double>(s.q.begin(), s.q.end())}}});
    list.push_back({s.time, 2, {{"opening", s.opening}, {"force", s.force}, {"holds", s.holds}}});
    last = std::max(last, s.time);
  }
  for (const RecordedStone& stone : record.stones)
    for (const Keyframe& frame : stone.motion) {
      list.push_back({frame.time, 3, {{"stone", stone.name}, {"T_W_O", pose_json(frame.T_W_O)}}});
      last = std::max(last, frame.time);
    }
  for (const RecordedEvent& event : record.events) list.push_back({event.time, 5, {{"text", event.text}}});
  for (const RecordedPlacement& p : record.placements)  // the record does not say when each was judged
    list.push_back({last,
                    4,
                    {{"stone", p.stone},
                     {"level", p.level},
                     {"outcome", p.outcome},
                     {"T_W_O_planned", pose_json(p.T_W_O_planned)}}});
  std::stable_sort(list.begin(), list.end(), [](const auto& a, const auto& b) { return a.time < b.time; });
  return list;
}

/// All messages in one chunk, with what a reader needs to find them by time.
struct McapChunk {
  std::string records;                                                                  ///< the messages
  std::uint64_t first = 0, last = 0;                                                    ///< times, ns
  std::map<std::uint16_t, std::uint64_t> counts;                                        ///< of each channel
  std::map<std::uint16_t, std::vector<std::pair<std::uint64_t, std::uint64_t>>> index;  ///< time and offset
};

McapChunk chunk_of(const std::vector<TimedMessage>& messages) {
  McapChunk chunk;
  for (const TimedMessage& message : messages) {
    const auto time = static_cast<std::uint64_t>(std::llround(std::clamp(message.time, 0.0, 1e9) * 1e9));
    if (&message == &messages.front()) chunk.first = time;
    chunk.last = time;
    chunk.index[message.channel].emplace_back(time, chunk.records.size());
    std::string content;
    put(content, message.channel);
    put(content, static_cast<std::uint32_t>(chunk.counts[message.channel]++));
    put(content, time);  // logged
    put(content, time);  // published
    content += message.data.dump(-1, ' ', false, json::error_handler_t::replace);
    put_record(chunk.records, McapRecord::kMessage, content);
  }
  return chunk;
}

/// Appends the chunk and its message indices to the file.
/// @return the content of the chunk's index, for the summary
std::string put_chunk(std::string& file, const McapChunk& chunk) {
  const auto size = static_cast<std::uint64_t>(chunk.records.size());
  const auto start = static_cast<std::uint64_t>(file.size());
  std::string content;
  put(content, chunk.first);
  put(content, chunk.last);
  put(content, size);
  put(content, std::uint32_t{0});  // no checksum
  put_text(content, "");           // not compressed
  put(content, size);
  content += chunk.records;
  put_record(file, McapRecord::kChunk, content);
  const auto length = static_cast<std::uint64_t>(file.size()) - start;
  const auto indices = static_cast<std::uint64_t>(file.size());
  std::string offsets;
  for (const auto& [channel, entries] : chunk.index) {
    put(offsets, channel);
    put(offsets, static_cast<std::uint64_t>(file.size()));
    std::string index;
    put(index, channel);
    put(index, static_cast<std::uint32_t>(entries.size() * 16));
    for (const auto& [time, offset] : entries) {
      put(index, time);
      put(index, offset);
    }
    put_record(file, McapRecord::kMessageIndex, index);
  }
  std::string summary;
  put(summary, chunk.first);
  put(summary, chunk.last);
  put(summary, start);
  put(summary, length);
  put(summary, static_cast<std::uint32_t>(offsets.size()));
  summary += offsets;
  put(summary, static_cast<std::uint64_t>(file.size()) - indices);
  put_text(summary, "");  // not compressed
  put(summary, size);
  put(summary, size);
  return summary;
}

}  // namespace

std::string to_mcap(const RunRecord& record) {
  const auto all_topics = topics();
  std::string declared;
  for (std::size_t i = 0; i < all_topics.size(); ++i) {
    const auto id = static_cast<std::uint16_t>(i + 1);
    const Topic& topic = all_topics[i];
    std::string schema, channel;
    put(schema, id);
    put_text(schema, topic.schema);
    put_text(schema, "jsonschema");
    json required = json::array();
    for (const auto& [name, type] : topic.properties.items()) required.push_back(name);
    put_text(schema, json{{"title", topic.schema},
                          {"type", "object"},
                          {"properties", topic.properties},
                          {"required", required}}
                         .dump());
    put_record(declared, McapRecord::kSchema, schema);
    put(channel, id);
    put(channel, id);
    put_text(channel, topic.topic);
    put_text(channel, "json");
    put(channel, std::uint32_t{0});  // no metadata
    put_record(declared, McapRecord::kChannel, channel);
  }
  std::string file(kMcapMagic), header;
  put_text(header, "");
  put_text(header, "stonestack");
  put_record(file, McapRecord::kHeader, header);
  file += declared;
  const auto messages = messages_of(record);
  const McapChunk chunk = chunk_of(messages);
  const std::string chunk_index = put_chunk(file, chunk);
  std::string data_end, statistics, footer;
  put(data_end, std::uint32_t{0});  // no checksum
  put_record(file, McapRecord::kDataEnd, data_end);
  const auto summary_start = static_cast<std::uint64_t>(file.size());
  file += declared;
  put_record(file, McapRecord::kChunkIndex, chunk_index);
  put(statistics, static_cast<std::uint64_t>(messages.size()));
  put(statistics, static_cast<std::uint16_t>(all_topics.size()));
  put(statistics, static_cast<std::uint32_t>(all_topics.size()));
  for (const std::uint32_t count : {0U, 0U, 1U}) put(statistics, count);  // attachments, metadata, chunks
  put(statistics, chunk.first);
  put(statistics, chunk.last);
  put(statistics, static_cast<std::uint32_t>(chunk.counts.size() * 10));
  for (const auto& [channel, count] : chunk.counts) {
    put(statistics, channel);
    put(statistics, count);
  }
  put_record(file, McapRecord::kStatistics, statistics);
  put(footer, summary_start);
  put(footer, std::uint64_t{0});  // no summary offsets
  put(footer, std::uint32_t{0});  // no checksum
  put_record(file, McapRecord::kFooter, footer);
  return file.append(kMcapMagic);
}

}  // namespace stonestack::report
