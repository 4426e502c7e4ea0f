#include "modelled_stones.hpp"

#include <memory>

#include "stacking/model_again.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/modelling/model_objects.hpp"

namespace stonestack::bench {
namespace {

constexpr int kViewsOfAttitude = 4;  // as `run --unseen` takes
constexpr int kAttitudesTried = 10;  // until one is parted from the table as one object

/// Attitudes of one stone so far, and the model made of them.
struct Growing {
  std::vector<std::unique_ptr<modelling::AlignedScene>> scenes;
  std::vector<modelling::LyingObject>
      made_of;  ///< of which O is the frame of the scan, as well as the views agree
  modelling::ObjectModel model;
  std::vector<Eigen::Vector3d> up_at_rest;
};

/// Adds one more attitude; false where it shows no object that is the stone, or none that can be joined.
bool add_attitude(const BenchScene& drawn, Growing& growing) {
  auto scene = std::make_unique<modelling::AlignedScene>(modelling::align_scene(drawn.views));
  if (scene->segmentation.objects.size() != 1) return false;
  const Pose T_W_O = drawn.views.front().T_W_C * drawn.truth.front().T_C_O;
  modelling::LyingObject lying{scene.get(), 0, T_W_O};
  if (!growing.made_of.empty()) {
    const auto found = modelling::find_turned(growing.model, growing.made_of, lying);
    if (!found) return false;
    lying.T_W_O = found->T_W_O;
  }
  growing.made_of.push_back(lying);
  growing.up_at_rest.emplace_back(lying.T_W_O.linear().transpose() * Eigen::Vector3d::UnitZ());
  growing.scenes.push_back(std::move(scene));
  growing.model = modelling::model_object(growing.made_of);
  return true;
}

}  // namespace

std::vector<StoneFromViews> stones_from_views(const SceneMaker& maker, int attitudes, std::uint64_t seed) {
  std::vector<StoneFromViews> made;
  for (const StoneIndex stone : first_stones(maker.stones().size())) {
    throw_if_interrupted();
    const std::string& name = at(maker.stones(), stone).name;
    Growing growing;
    for (int k = 0, joined = 0; k < kAttitudesTried && joined < attitudes; ++k)
      joined += add_attitude(
                    maker.views_around(stone, kViewsOfAttitude, seed * 100 + static_cast<std::uint64_t>(k)),
                    growing)
                    ? 1
                    : 0;
    require(!growing.made_of.empty(), "stone ", name, " is not parted from the table in ", kAttitudesTried,
            " attitudes");
    stacking::ModelledStone says;
    says.name = name;
    const Stone from_views = stacking::stone_of_model(growing.model, says, {}, growing.up_at_rest);
    log_info(concat(name, ": modelled from ", growing.made_of.size(), " attitudes, ",
                    100.0 * growing.model.seen_share, " % of its surface seen"));
    made.push_back({from_views, from_views.T_O_file.inverse()});
  }
  return made;
}

}  // namespace stonestack::bench
