#include "emulators/ur/rtde_session.hpp"

#include <algorithm>
#include <cmath>

#include "stonestack/core/error.hpp"

namespace stonestack::emulators {
namespace {

constexpr std::size_t kMaxRecipes = 255;
constexpr std::size_t kLongestNames = 2048;  // bytes of a setup
constexpr const char* kNotFound = "NOT_FOUND";
constexpr const char* kInUse = "IN_USE";

bool listed(const std::string& list, const std::string& name) {
  const auto names = split_names(list);
  return std::find(names.begin(), names.end(), name) != names.end();
}

// Registers that EtherNet/IP, PROFINET and MODBUS adapters write.
bool is_fieldbus_register(const std::string& name) {
  if (name == "input_bit_registers0_to_31" || name == "input_bit_registers32_to_63") return true;
  for (const std::string prefix : {"input_int_register_", "input_double_register_"})
    if (name.rfind(prefix, 0) == 0) return std::stoi(name.substr(prefix.size())) < 24;
  return false;
}

// How many names of a list lie within what a controller reads of it. What a real one does with the rest is
// not known; here it is not found. UR's client library asks the newest controllers for more.
std::size_t names_read(const std::vector<std::string>& names, const UrVersion& version) {
  if (version.has({0, 0, 0, 0}, {5, 23, 0, 0})) return names.size();
  std::size_t count = 0, bytes = 0;
  while (count < names.size() && (bytes += names[count].size()) <= kLongestNames) {
    ++bytes;  // comma
    ++count;
  }
  return count;
}

bool sets_an_output(const std::string& name) {
  return name.find("digital_output") != std::string::npos || name.find("analog_output") != std::string::npos;
}

}  // namespace

RtdeSession::RtdeSession(int number, UrController& controller, InputOwners& owners)
    : number_(number), controller_(&controller), owners_(&owners) {}

RtdeSession::~RtdeSession() {
  for (auto it = owners_->begin(); it != owners_->end();)
    it = it->second == number_ ? owners_->erase(it) : std::next(it);
}

std::vector<std::string> RtdeSession::feed(std::string_view bytes) {
  std::vector<std::string> replies;
  stream_.feed(bytes);
  while (const auto packet = stream_.next()) answer(*packet, replies);
  return replies;
}

void RtdeSession::answer(const RtdePacket& packet, std::vector<std::string>& replies) {
  const auto reply = [&](const RtdePacket& made) { replies.push_back(encode(made)); };
  const auto before_setup = [&] {
    if (controller_->faults.message_before_reply)
      reply(encode_text({"SafetySetup has not been confirmed yet", "Controller", RtdeText::Level::kWarning},
                        protocol_));
  };
  switch (packet.kind) {
    case RtdeKind::kProtocolVersion: {
      const auto version = decode_protocol_request(packet);
      const bool known =
          version && (*version == 1 || (*version == 2 && !controller_->faults.refuse_protocol_2));
      if (known) protocol_ = *version;
      return reply(encode_accepted(packet.kind, known));
    }
    case RtdeKind::kControlVersion:
      return reply(encode_control_version(controller_->version()));
    case RtdeKind::kSetupOutputs: {
      before_setup();
      const auto setup = decode_output_setup(packet, protocol_);
      return reply(encode_setup_reply(packet.kind, set_up_outputs(setup.value_or(RtdeSetup())), protocol_));
    }
    case RtdeKind::kSetupInputs: {
      before_setup();
      const auto setup = decode_input_setup(packet);
      return reply(encode_setup_reply(packet.kind, set_up_inputs(setup.value_or(RtdeSetup())), protocol_));
    }
    case RtdeKind::kStart:
      started_ = !outputs_.empty();
      last_sample_ = controller_->steps();
      return reply(encode_accepted(packet.kind, started_));
    case RtdeKind::kPause:
      started_ = false;
      return reply(encode_accepted(packet.kind, true));
    case RtdeKind::kDataPackage:
      return take_data(packet);
    case RtdeKind::kTextMessage:
      return;  // a client's remark for the controller's log
  }
}

RtdeSetupReply RtdeSession::set_up_outputs(const RtdeSetup& setup) {
  RtdeSetupReply reply;
  outputs_.clear();
  started_ = false;
  bool whole = true;
  const std::size_t read = names_read(setup.names, controller_->version());
  for (const auto& name : setup.names) {
    const RtdeField* field = find_rtde_output(name);
    const bool there = reply.types.size() < read && field && field->in(controller_->version()) &&
                       !listed(controller_->faults.missing_fields, name);
    whole = whole && there;
    reply.types.emplace_back(there ? std::string(rtde_type_name(field->type)) : kNotFound);
    if (there) outputs_.push_back(rtde_reader(*field));
  }
  if (!whole) outputs_.clear();
  reply.recipe = outputs_.empty() ? 0 : 1;
  const double rate = controller_->version().control_rate();
  frequency_ = setup.frequency >= 0.1 && setup.frequency <= rate ? setup.frequency : rate;
  return reply;
}

std::string RtdeSession::input_state(const std::string& name) const {
  const RtdeField* field = find_rtde_input(name);
  if (!field || !field->in(controller_->version())) return kNotFound;
  const auto owner = owners_->find(name);
  if (owner != owners_->end() && owner->second != number_) return kInUse;
  if (controller_->faults.fieldbus_owns_lower_registers && is_fieldbus_register(name)) return kInUse;
  if (controller_->faults.fieldbus_owns_outputs && sets_an_output(name)) return kInUse;
  return std::string(rtde_type_name(field->type));
}

RtdeSetupReply RtdeSession::set_up_inputs(const RtdeSetup& setup) {
  RtdeSetupReply reply;
  InputRecipe recipe;
  bool whole = !setup.names.empty() && inputs_.size() < kMaxRecipes;
  const std::size_t read = names_read(setup.names, controller_->version());
  for (const auto& name : setup.names) {
    reply.types.push_back(reply.types.size() < read ? input_state(name) : kNotFound);
    const auto type = rtde_type(reply.types.back());
    whole = whole && type.has_value();
    if (!type) continue;
    recipe.names.push_back(name);
    recipe.types.push_back(*type);
    recipe.writers.push_back(rtde_writer(*find_rtde_input(name)));
  }
  if (!whole) return reply;
  for (const auto& name : recipe.names) (*owners_)[name] = number_;
  inputs_.push_back(std::move(recipe));
  reply.recipe = static_cast<std::uint8_t>(inputs_.size());
  return reply;
}

void RtdeSession::take_data(const RtdePacket& packet) {
  const auto number = data_recipe(packet);
  if (!number || *number == 0 || *number > inputs_.size()) return;
  const InputRecipe& recipe = inputs_[*number - 1U];
  const auto data = decode_data(packet, recipe.types, protocol_, false);
  if (!data) return;
  for (std::size_t i = 0; i < recipe.names.size(); ++i) {
    recipe.writers[i](*controller_, data->values[i]);
    controller_->input_written(recipe.names[i]);
  }
  apply_masked_inputs(*controller_, recipe.names);
}

std::optional<std::string> RtdeSession::sample() {
  if (!started_) return std::nullopt;
  const double rate = controller_->version().control_rate();
  const auto count = [&](std::uint64_t step) {
    return std::floor(static_cast<double>(step) * frequency_ / rate + 1e-9);
  };
  const std::uint64_t now = controller_->steps();
  if (count(now) == count(last_sample_)) return std::nullopt;
  last_sample_ = now;
  RtdeData data;
  data.recipe = 1;
  for (const auto& read : outputs_) data.values.push_back(read(*controller_));
  return encode(encode_data(data, protocol_, true));
}

}  // namespace stonestack::emulators
