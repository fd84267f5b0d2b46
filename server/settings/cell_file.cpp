// SPDX-License-Identifier: Apache-2.0
#include "settings/cell_file.hpp"

#include "settings/cell_description.hpp"
#include "settings/cell_overrides.hpp"
#include "settings/remarks.hpp"
#include "settings/roots.hpp"
#include "settings/scene_resolver.hpp"

#include <handover/common/check.hpp>

#include <algorithm>
#include <charconv>

namespace handover {
namespace {

/// The folders of robots/ that hold a settings file of their own name.
std::set<std::string> modelNames(const std::filesystem::path& root) {
  std::set<std::string> names;
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(root / "robots", ignored)) {
    const std::string name = entry.path().filename().string();
    if (std::filesystem::exists(entry.path() / (name + ".yaml"), ignored)) names.insert(name);
  }
  return names;
}

std::string shortest(double value) {
  std::array<char, 32> digits{};
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
  return {digits.data(), end};
}

std::string yamlOf(const std::vector<double>& values) {
  if (values.size() == 1) return shortest(values[0]);
  std::string text = "[";
  for (const double value : values) text += (text.size() > 1 ? ", " : "") + shortest(value);
  return text + "]";
}

/// Both ends of a range and every choice must be values that the reader takes.
void checkVariation(const YamlNode& cell, const Variation& variation, YamlReport& report) {
  std::vector<std::string> values = variation.choices;
  if (!variation.from.empty()) values = {yamlOf(variation.from), yamlOf(variation.to)};
  for (const std::string& value : values) {
    const std::vector<Override> change{{variation.path, value}};
    YamlNode document = cell;
    std::vector<Fault> faults = applyOverrides(document, change);
    if (faults.empty()) {
      YamlReport changed;
      readCell(document, changed);
      faults = asOverrideFaults(changed, change);
    }
    for (const Fault& fault : faults) report.add("vary." + variation.path, fault.message);
    if (!faults.empty()) return;
  }
}

/// What variations say of each other, and the bounds of what the daemon announces.
void checkVariations(const std::vector<Variation>& variations, YamlReport& report) {
  if (variations.size() > bounds::kVariations) {
    report.add("vary", "has more than " + std::to_string(bounds::kVariations) + " entries");
  }
  for (const Variation& variation : variations) {
    const std::string at = "vary." + variation.path;
    for (const Fault& fault : check(variation)) report.add(at, fault.message);
    if (!variation.facing) continue;
    const std::string place = placePath(variation);
    const bool placed = std::any_of(
        variations.begin(), variations.end(),
        [&place](const Variation& other) { return other.path == place && other.from.size() == 3; });
    if (!placed) report.add(at + ".facing", "needs a range of " + place + " too");
  }
}

/// Loads the models that the cell names and that are not there yet; collects what is wrong with
/// them.
void loadModels(const CellDescription& cell, const std::filesystem::path& root,
                const ConvexDecomposer& divide, ModelCache& models, YamlReport& report,
                std::vector<FileFault>& faults) {
  std::map<std::string, bool> tried;
  for (const RobotDescription& robot : cell.robots) {
    if (models.contains(robot.model) || !tried.emplace(robot.model, true).second) continue;
    const std::filesystem::path file = robotFile(robot.model, root);
    if (std::error_code error; !std::filesystem::is_regular_file(file, error)) {
      report.add("robots." + robot.name + ".model",
                 "no model '" + robot.model + "': " + file.string() + " does not exist" +
                     nearestSaid(nearestOf(modelNames(root), robot.model)));
      continue;
    }
    try {
      models.emplace(robot.model, std::make_shared<const RobotModel>(
                                      loadRobot(readRobotSettings(file, root), divide)));
    } catch (const FileError& error) {
      faults.insert(faults.end(), error.faults().begin(), error.faults().end());
    }
  }
}

/// Whether robots, objects and tasks were read: else every name would seem unknown.
bool entriesKnown(const YamlReport& report) {
  return std::none_of(report.faults().begin(), report.faults().end(), [](const YamlFault& fault) {
    return fault.path.empty() || fault.path == "robots" || fault.path == "objects" ||
           fault.path == "tasks";
  });
}

}  // namespace

struct Cell::Data {
  std::filesystem::path file, root;
  ConvexDecomposer divide;
  YamlNode document;
  CellDescription description;
  ModelCache models;                          ///< those of this cell
  std::map<std::string, KnownShapes> shapes;  ///< by object
  std::shared_ptr<const Scene> scene;         ///< without overrides
  std::vector<SceneTask> tasks;
  std::vector<FileFault> warnings, facts;
};

Cell Cell::load(const std::filesystem::path& file, const std::filesystem::path& root,
                ModelCache& models, const ConvexDecomposer& divide) {
  auto data = std::make_shared<Data>();
  data->file = file;
  data->root = root;
  data->divide = divide;
  const std::string shown_file = file.string();
  data->document = parseYaml(readSettingsText(file), shown_file);
  YamlReport report;
  data->description = readCell(data->document, report);
  if (!data->document.isMap()) throw FileError(report.inFile(shown_file));
  if (report.clean()) {
    checkVariations(data->description.variations, report);
    for (const Variation& variation : data->description.variations) {
      checkVariation(data->document, variation, report);
    }
  }

  std::vector<FileFault> robot_faults;
  YamlReport later = report.linesOnly();
  loadModels(data->description, root, divide, models, later, robot_faults);
  if (later.clean() && robot_faults.empty() && entriesKnown(report)) {
    for (const RobotDescription& robot : data->description.robots) {
      data->models.emplace(robot.model, models.at(robot.model));
    }
    ResolvedCell resolved = resolveCell(data->description, data->models, root, divide, {}, later);
    for (const SceneObject& object : resolved.scene.objects) {
      data->shapes.emplace(object.name,
                           KnownShapes{object.geometry, object.shapes, object.divided});
    }
    data->scene = std::make_shared<const Scene>(std::move(resolved.scene));
    data->tasks = std::move(resolved.tasks);
    for (const SceneTask& task : data->tasks) {
      if (!beginsWithHolder(task)) later.add("tasks." + task.name + ".chain", kNotItsHolder);
    }
    if (later.clean()) {
      Remarks remarks{report.linesOnly(), report.linesOnly()};
      remarkOnObjects(*data->scene, data->tasks, remarks);
      for (const SceneRobot& robot : data->scene->robots) {
        remarkOnRobot(*robot.model, robot.q_start, "robots." + robot.name, remarks);
      }
      data->warnings = remarks.warnings.inFile(shown_file);
      data->facts = remarks.facts.inFile(shown_file);
    }
  }
  report.addNew(later);  // what a value that is wrong already leads to is not said again
  std::vector<FileFault> faults = report.inFile(shown_file);
  faults.insert(faults.end(), robot_faults.begin(), robot_faults.end());
  if (!faults.empty()) throw FileError(std::move(faults));
  Cell cell;
  cell.data_ = std::move(data);
  return cell;
}

const std::string& Cell::name() const { return data_->description.name; }

const std::filesystem::path& Cell::file() const { return data_->file; }

std::vector<std::string> Cell::taskNames() const {
  std::vector<std::string> names;
  for (const SceneTask& task : data_->tasks) names.push_back(task.name);
  return names;
}

const std::vector<FileFault>& Cell::warnings() const { return data_->warnings; }

const std::vector<FileFault>& Cell::facts() const { return data_->facts; }

const std::vector<Variation>& Cell::variations() const { return data_->description.variations; }

std::variant<Cell::Instance, std::vector<Fault>> Cell::instantiate(
    const std::vector<Override>& overrides, std::uint64_t revision) const {
  return instantiate(overrides, revision, data_->divide);
}

std::variant<Cell::Instance, std::vector<Fault>> Cell::instantiate(
    const std::vector<Override>& overrides, std::uint64_t revision,
    const ConvexDecomposer& divide) const {
  if (overrides.empty()) {
    auto scene = std::make_shared<Scene>(*data_->scene);
    scene->revision = revision;
    return Instance{std::move(scene), data_->tasks};
  }
  YamlNode document = data_->document;
  std::vector<Fault> faults = applyOverrides(document, overrides);
  YamlReport report;
  const CellDescription description = readCell(document, report);
  if (!report.clean()) {
    const std::vector<Fault> found = asOverrideFaults(report, overrides);
    faults.insert(faults.end(), found.begin(), found.end());
  }
  if (!faults.empty()) return faults;
  ResolvedCell resolved =
      resolveCell(description, data_->models, data_->root, divide, data_->shapes, report);
  if (!report.clean()) return asOverrideFaults(report, overrides);
  resolved.scene.revision = revision;
  return Instance{std::make_shared<const Scene>(std::move(resolved.scene)),
                  std::move(resolved.tasks)};
}

}  // namespace handover
