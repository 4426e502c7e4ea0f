#include "hardware/ur/rtde_session.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "stonestack/core/log.hpp"

namespace stonestack::hardware {
namespace {

constexpr std::size_t kSessionChunk = 16384;
constexpr double kWriteTime = 0.2;  // s; a controller that takes longer is not reading
constexpr std::size_t kLongestNames = 2048;

bool is_finite(const RtdeValue& value) {
  if (const auto* number = std::get_if<double>(&value)) return std::isfinite(*number);
  if (const auto* three = std::get_if<std::array<double, 3>>(&value))
    return std::all_of(three->begin(), three->end(), [](double v) { return std::isfinite(v); });
  if (const auto* six = std::get_if<std::array<double, 6>>(&value))
    return std::all_of(six->begin(), six->end(), [](double v) { return std::isfinite(v); });
  return true;
}

std::vector<std::string> with_timestamp(const RtdeRecipe& recipe) {
  std::vector<std::string> names = {"timestamp"};
  for (const auto* list : {&recipe.required, &recipe.optional})
    for (const std::string& name : *list)
      if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  return names;
}

Deadline make_deadline(double seconds, bool interruptible) {
  const Deadline deadline = Deadline::in(seconds);
  return interruptible ? deadline.or_interrupt() : deadline;
}

TcpStream connect_to(const Endpoint& controller, Deadline deadline) {
  try {
    return TcpStream::connect(controller, deadline);
  } catch (const DeviceError& error) {
    throw DeviceError("UR RTDE", error.what(),
                      "switch the controller on, and enable RTDE in its security settings (PolyScope 5.10)");
  }
}

}  // namespace

RtdeSession::RtdeSession(const Endpoint& controller, const RtdeRecipeFor& recipe, const RtdeOptions& options,
                         RtdeTextSink text_sink, bool interruptible)
    : name_("UR RTDE at " + to_text(controller)),
      options_(options),
      interruptible_(interruptible),
      text_sink_(std::move(text_sink)),
      socket_(connect_to(controller, make_deadline(options.connect_timeout, interruptible))) {
  agree_on_protocol();
  read_version();
  const RtdeRecipe wanted = recipe(version);
  frequency = options_.frequency > 0 ? options_.frequency : version.control_rate();
  set_up_outputs(wanted);
  for (const auto& names : wanted.inputs) set_up_inputs(names);
  start();
}

void RtdeSession::fail(const std::string& problem, const std::string& next_step) const {
  throw DeviceError(name_, problem, next_step);
}

void RtdeSession::write(const RtdePacket& packet) {
  const std::lock_guard lock(writing_);
  const IoResult written = socket_.write_all(std::string_view(encode(packet)), Deadline::in(kWriteTime));
  if (written) return;
  socket_.shut();  // a packet cut in the middle would put the controller out of step
  fail(concat("cannot send: ", io_status_name(written.status)), "look whether the controller is up");
}

std::optional<RtdePacket> RtdeSession::next_packet(Deadline deadline) {
  std::array<std::uint8_t, kSessionChunk> bytes{};
  for (;;) {
    if (auto packet = stream_.next()) return packet;
    if (!stream_.problem().empty())
      fail("out of step: " + stream_.problem(), "is this port RTDE (30004)? Connecting anew helps otherwise");
    const IoResult read = socket_.read_some(bytes, deadline);
    if (read.status == IoStatus::kTimeOut) return std::nullopt;
    if (read.status == IoStatus::kClosed)
      fail("the controller closed the link", "it does so when it boots or when a reader is slow");
    stream_.feed({reinterpret_cast<const char*>(bytes.data()), read.bytes});
  }
}

RtdePacket RtdeSession::request(const RtdePacket& packet) {
  write(packet);
  const Deadline deadline = make_deadline(options_.reply_timeout, interruptible_);
  while (auto reply = next_packet(deadline)) {
    if (reply->kind == packet.kind) return *reply;
    if (const auto text = decode_text(*reply, protocol)) text_sink_(*text);
    if (deadline.over()) break;  // who talks without end is not waited for without end
  }
  fail(concat("no reply to '", static_cast<char>(packet.kind), "' within ", options_.reply_timeout, " s"),
       "look whether the controller has booted and RTDE is enabled in its services");
}

void RtdeSession::agree_on_protocol() {
  for (const std::uint16_t wanted : {2, 1}) {
    const RtdePacket reply = request(encode_protocol_request(wanted));
    const auto accepted = decode_accepted(reply, RtdeKind::kProtocolVersion);
    if (!accepted) fail("malformed reply to the protocol version", "is this port RTDE (30004)?");
    if (!*accepted) continue;
    protocol = wanted;
    return;
  }
  fail("refuses protocol 2 and 1", "update the controller's software");
}

void RtdeSession::read_version() {
  const auto answer = decode_control_version(request({RtdeKind::kControlVersion, {}}));
  if (!answer) fail("malformed version of the controller", "is this port RTDE (30004)?");
  version = *answer;
}

RtdeSetupReply RtdeSession::request_setup(const RtdePacket& packet, std::size_t names) {
  if (packet.payload.size() > kLongestNames)
    fail(concat("a recipe of ", packet.payload.size(), " bytes, ", kLongestNames, " allowed"),
         "ask for less");
  const auto reply = decode_setup_reply(request(packet), packet.kind, protocol);
  if (!reply || reply->types.size() != names)
    fail(concat("answers a setup of ", names, " fields with ", reply ? reply->types.size() : 0, " types"),
         "update the controller's software");
  return *reply;
}

void RtdeSession::require_type(const std::string& name, RtdeType reported, const RtdeField* known) const {
  if (known != nullptr && known->type != reported)
    fail(concat("the controller has ", name, " as ", rtde_type_name(reported), ", not as ",
                rtde_type_name(known->type)),
         "is this a UR controller? Its software may be newer than this program");
}

std::vector<RtdeType> RtdeSession::read_types(const std::vector<std::string>& names,
                                              const RtdeSetupReply& reply,
                                              std::vector<std::string>& not_found) const {
  std::vector<RtdeType> types;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto type = rtde_type(reply.types[i]);
    if (!type) {
      not_found.push_back(names[i]);
      continue;
    }
    require_type(names[i], *type, find_rtde_output(names[i]));
    types.push_back(*type);
  }
  return types;
}

void RtdeSession::set_up_outputs(const RtdeRecipe& recipe) {
  auto names = with_timestamp(recipe);
  missing.clear();
  for (int round = 0; round < 2; ++round) {
    const RtdeSetupReply reply =
        request_setup(encode_output_setup({names, frequency}, protocol), names.size());
    std::vector<std::string> not_found, required;
    output_types_ = read_types(names, reply, not_found);
    for (const std::string& name : not_found)
      if (std::find(recipe.optional.begin(), recipe.optional.end(), name) == recipe.optional.end())
        required.push_back(name);
    if (!required.empty())
      fail("controller " + to_string(version) + " does not have the output " + join_names(required),
           "update the controller's software");
    output_recipe_ = reply.recipe;
    if (not_found.empty()) {
      outputs = std::make_shared<const std::vector<std::string>>(std::move(names));
      return;
    }
    missing.insert(missing.end(), not_found.begin(), not_found.end());
    std::erase_if(names, [&](const std::string& name) {
      return std::find(not_found.begin(), not_found.end(), name) != not_found.end();
    });
  }
  fail("does not find outputs that it found before: " + join_names(missing), "restart the controller");
}

void RtdeSession::set_up_inputs(const std::vector<std::string>& names) {
  const RtdeSetupReply reply = request_setup(encode_input_setup(names), names.size());
  Input input{reply.recipe, names, {}};
  std::vector<std::string> in_use, not_found;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (const auto type = rtde_type(reply.types[i]))
      input.types.push_back(*type);
    else
      (reply.types[i] == "IN_USE" ? in_use : not_found).push_back(names[i]);
  }
  if (!not_found.empty())
    fail("controller " + to_string(version) + " does not have the input " + join_names(not_found),
         "update the controller's software");
  if (!in_use.empty())
    throw RtdeInUse(
        name_, "the input " + join_names(in_use) + " is in use",
        "end the other RTDE client, or switch off the fieldbus adapter that owns it (EtherNet/IP, "
        "PROFINET, MODBUS)");
  for (std::size_t i = 0; i < names.size(); ++i)
    require_type(names[i], input.types[i], find_rtde_input(names[i]));
  inputs_.push_back(std::move(input));
}

void RtdeSession::start() {
  const auto accepted = decode_accepted(request({RtdeKind::kStart, {}}), RtdeKind::kStart);
  if (!accepted.value_or(false)) fail("refuses to start sending", "restart the controller");
}

std::optional<RtdeData> RtdeSession::receive(Deadline deadline, long& refused) {
  while (const auto packet = next_packet(deadline)) {
    if (const auto text = decode_text(*packet, protocol)) text_sink_(*text);
    if (packet->kind != RtdeKind::kDataPackage && deadline.over()) break;
    if (packet->kind != RtdeKind::kDataPackage) continue;
    auto data = decode_data(*packet, output_types_, protocol, true);
    if (data && (protocol < 2 || data->recipe == output_recipe_) &&
        std::all_of(data->values.begin(), data->values.end(), is_finite))
      return data;
    ++refused;
    return RtdeData{};
  }
  return std::nullopt;
}

void RtdeSession::send(std::size_t recipe, const std::vector<RtdeValue>& values) {
  require(recipe < inputs_.size(), "there are ", inputs_.size(), " input recipes, not ", recipe + 1);
  const Input& input = inputs_[recipe];
  require(values.size() == input.types.size(), "input recipe ", recipe, " takes ", input.types.size(),
          " values, not ", values.size());
  for (std::size_t i = 0; i < values.size(); ++i)
    require(static_cast<RtdeType>(values[i].index()) == input.types[i] && is_finite(values[i]), "input ",
            input.names[i], " takes a finite ", rtde_type_name(input.types[i]));
  write(encode_data({input.recipe, values}, protocol, false));
}

}  // namespace stonestack::hardware
