// SPDX-License-Identifier: Apache-2.0
#include "view/mcap.hpp"

#include "view/mesh_file.hpp"
#include "view/playback.hpp"
#include "view/root_files.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string_view>

namespace handover::view {
namespace {

constexpr double kFrame = 1.0 / 30;  // [s]

// ---- ROS 2 definitions of what is written, each followed by those that it needs

constexpr std::string_view kHeaderAndTime =
    "================================================================================\n"
    "MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n"
    "================================================================================\n"
    "MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n";

constexpr std::string_view kJointState =
    "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\n"
    "float64[] effort\n";

constexpr std::string_view kTransforms =
    "geometry_msgs/TransformStamped[] transforms\n"
    "================================================================================\n"
    "MSG: geometry_msgs/TransformStamped\nstd_msgs/Header header\nstring child_frame_id\n"
    "geometry_msgs/Transform transform\n"
    "================================================================================\n"
    "MSG: geometry_msgs/Transform\ngeometry_msgs/Vector3 translation\n"
    "geometry_msgs/Quaternion rotation\n"
    "================================================================================\n"
    "MSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n"
    "================================================================================\n"
    "MSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n";

constexpr std::string_view kMarkers =
    "visualization_msgs/Marker[] markers\n"
    "================================================================================\n"
    "MSG: visualization_msgs/Marker\nstd_msgs/Header header\nstring ns\nint32 id\nint32 type\n"
    "int32 action\ngeometry_msgs/Pose pose\ngeometry_msgs/Vector3 scale\n"
    "std_msgs/ColorRGBA color\nbuiltin_interfaces/Duration lifetime\nbool frame_locked\n"
    "geometry_msgs/Point[] points\nstd_msgs/ColorRGBA[] colors\nstring texture_resource\n"
    "sensor_msgs/CompressedImage texture\nvisualization_msgs/UVCoordinate[] uv_coordinates\n"
    "string text\nstring mesh_resource\nvisualization_msgs/MeshFile mesh_file\n"
    "bool mesh_use_embedded_materials\n"
    "================================================================================\n"
    "MSG: geometry_msgs/Pose\ngeometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n"
    "================================================================================\n"
    "MSG: geometry_msgs/Point\nfloat64 x\nfloat64 y\nfloat64 z\n"
    "================================================================================\n"
    "MSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n"
    "================================================================================\n"
    "MSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n"
    "================================================================================\n"
    "MSG: std_msgs/ColorRGBA\nfloat32 r\nfloat32 g\nfloat32 b\nfloat32 a\n"
    "================================================================================\n"
    "MSG: builtin_interfaces/Duration\nint32 sec\nuint32 nanosec\n"
    "================================================================================\n"
    "MSG: sensor_msgs/CompressedImage\nstd_msgs/Header header\nstring format\nuint8[] data\n"
    "================================================================================\n"
    "MSG: visualization_msgs/UVCoordinate\nfloat32 u\nfloat32 v\n"
    "================================================================================\n"
    "MSG: visualization_msgs/MeshFile\nstring filename\nuint8[] data\n";

constexpr std::string_view kString = "string data\n";

// ---- bytes

template <typename T>
void append(std::string& bytes, T value) {
  static_assert(std::endian::native == std::endian::little);
  char raw[sizeof value];
  std::memcpy(raw, &value, sizeof value);
  bytes.append(raw, sizeof value);
}

/// A ROS 2 message: plain CDR, little endian, members aligned to their size after the first four
/// bytes.
class Cdr {
 public:
  template <typename T>
  Cdr& add(T value) {
    while ((bytes_.size() - kStart) % sizeof value != 0) bytes_ += '\0';
    append(bytes_, value);
    return *this;
  }

  Cdr& text(std::string_view value) {
    add(static_cast<std::uint32_t>(value.size() + 1));
    bytes_.append(value);
    bytes_ += '\0';
    return *this;
  }

  Cdr& count(std::size_t value) { return add(static_cast<std::uint32_t>(value)); }

  Cdr& numbers(const std::vector<double>& values) {
    count(values.size());
    for (const double value : values) add(value);
    return *this;
  }

  Cdr& point(const Eigen::Vector3d& p) { return add(p.x()).add(p.y()).add(p.z()); }

  Cdr& pose(const Pose& X) {
    const Eigen::Quaterniond quat(X.linear());
    return point(X.translation()).add(quat.x()).add(quat.y()).add(quat.z()).add(quat.w());
  }

  Cdr& header(double T, std::string_view frame) {
    const auto nanoseconds = std::llround(T * 1e9);
    add(static_cast<std::int32_t>(nanoseconds / 1'000'000'000));
    add(static_cast<std::uint32_t>(nanoseconds % 1'000'000'000));
    return text(frame);
  }

  const std::string& bytes() const { return bytes_; }

 private:
  static constexpr std::size_t kStart = 4;
  std::string bytes_{"\0\1\0\0", kStart};
};

/// The records of an MCAP file without chunks, an index or a summary.
class McapFile {
 public:
  McapFile() {
    bytes_.assign(kMagic);
    std::string header;
    addText(header, "ros2");
    addText(header, "handover");
    record(0x01, header);
  }

  std::uint16_t addChannel(std::string_view topic, std::string_view type,
                           std::string_view definition) {
    ++channels_;
    std::string schema;
    append(schema, channels_);
    addText(schema, type);
    addText(schema, "ros2msg");
    addText(schema, definition);
    record(0x03, schema);
    std::string channel;
    append(channel, channels_);
    append(channel, channels_);
    addText(channel, topic);
    addText(channel, "cdr");
    append(channel, std::uint32_t{0});  // no metadata
    record(0x04, channel);
    return channels_;
  }

  void addMessage(std::uint16_t channel, double T, const Cdr& message) {
    std::string body;
    append(body, channel);
    append(body, std::uint32_t{0});  // no sequence numbers
    const auto nanoseconds = static_cast<std::uint64_t>(std::llround(T * 1e9));
    append(body, nanoseconds);
    append(body, nanoseconds);
    record(0x05, body + message.bytes());
  }

  std::string finish() {
    record(0x0F, std::string(4, '\0'));   // data end, no checksum
    record(0x02, std::string(20, '\0'));  // footer, no summary
    bytes_.append(kMagic);
    return std::move(bytes_);
  }

 private:
  static constexpr std::string_view kMagic{"\x89MCAP0\r\n", 8};

  static void addText(std::string& bytes, std::string_view text) {
    append(bytes, static_cast<std::uint32_t>(text.size()));
    bytes.append(text);
  }

  void record(std::uint8_t kind, const std::string& body) {
    append(bytes_, kind);
    append(bytes_, static_cast<std::uint64_t>(body.size()));
    bytes_ += body;
  }

  std::string bytes_;
  std::uint16_t channels_ = 0;
};

using Colour = std::array<float, 4>;

constexpr Colour kObject{0.25f, 0.64f, 0.30f, 1.0f}, kThing{0.85f, 0.81f, 0.75f, 1.0f},
    kIdle{0.72f, 0.75f, 0.78f, 1.0f};
/// Of the robots that hold the object, in the order in which they do.
constexpr std::array<Colour, 4> kHolders{{{0.85f, 0.60f, 0.37f, 1.0f},
                                          {0.50f, 0.65f, 0.81f, 1.0f},
                                          {0.71f, 0.60f, 0.81f, 1.0f},
                                          {0.83f, 0.56f, 0.66f, 1.0f}}};

/// Writes the topics of one plan.
class Recorder {
 public:
  Recorder(const Playback& playback, const RootFiles& files) : playback_(playback), files_(files) {
    const std::string with_header = std::string(kJointState) + std::string(kHeaderAndTime);
    for (const RobotSnapshot& robot : playback_.scene().robots) {
      joints_.push_back(file_.addChannel("/joint_states/" + robot.name,
                                         "sensor_msgs/msg/JointState", with_header));
    }
    tf_ = file_.addChannel("/tf", "tf2_msgs/msg/TFMessage",
                           std::string(kTransforms) + std::string(kHeaderAndTime));
    markers_ = file_.addChannel("/scene", "visualization_msgs/msg/MarkerArray",
                                std::string(kMarkers) + std::string(kHeaderAndTime));
    stage_ = file_.addChannel("/stage", "std_msgs/msg/String", kString);
  }

  std::string record() {
    const double end = playback_.duration();
    const auto frames = static_cast<int>(std::ceil(end / kFrame));
    std::vector<const StageTrajectory*> stages;
    for (const StageTrajectory& stage : playback_.plan().stages) stages.push_back(&stage);
    std::stable_sort(stages.begin(), stages.end(),
                     [](const auto* a, const auto* b) { return a->start < b->start; });
    addMarkers();
    auto begun = stages.begin();
    for (int frame = 0; frame <= frames; ++frame) {
      const double T = std::min(frame * kFrame, end);
      for (; begun != stages.end() && (*begun)->start <= T; ++begun) {
        file_.addMessage(stage_, T, Cdr().text(playback_.labelOf(**begun)));
      }
      addFrame(T);
    }
    return file_.finish();
  }

 private:
  void addFrame(double T) {
    const Moment moment = playback_.at(T);
    Cdr transforms;
    std::size_t count = moment.X_WO.size();
    for (const auto& links : moment.X_WL) count += links.size();
    transforms.count(count);
    const auto add = [&](const std::string& frame, const Pose& X) {
      transforms.header(T, "world").text(frame).pose(X);
    };
    for (std::size_t r = 0; r < moment.X_WL.size(); ++r) {
      const std::string& robot = playback_.scene().robots[r].name;
      addJoints(r, moment.q[r], T);
      for (std::size_t link = 0; link < moment.X_WL[r].size(); ++link) {
        add(robot + "/" + playback_.models()[r].links()[link].name, moment.X_WL[r][link]);
      }
    }
    for (std::size_t o = 0; o < moment.X_WO.size(); ++o) {
      add(playback_.scene().objects[o].name, moment.X_WO[o]);
    }
    file_.addMessage(tf_, T, transforms);
  }

  void addJoints(std::size_t robot, const Positions& q, double T) {
    const Robot& model = playback_.models()[robot];
    std::vector<std::string> names;
    std::vector<double> positions;
    for (const Joint& joint : model.joints()) {
      if (joint.motion == Joint::Motion::kNone) continue;
      names.push_back(joint.name);
      positions.push_back(model.positionOf(joint, q));
    }
    Cdr message;
    message.header(T, "").count(names.size());
    for (const std::string& name : names) message.text(name);
    message.numbers(positions).count(0).count(0);
    file_.addMessage(joints_[robot], T, message);
  }

  /// A shape in the frame of a body.
  struct Mark {
    std::string body;
    Shape shape;
    Colour colour;
    std::string urdf;  ///< that names its mesh; empty: the plan does
  };

  std::vector<Mark> marks() const {
    std::vector<Mark> marks;
    const SceneSnapshot& scene = playback_.scene();
    for (std::size_t r = 0; r < scene.robots.size(); ++r) {
      const RobotSnapshot& robot = scene.robots[r];
      for (const Link& link : playback_.models()[r].links()) {
        for (const Shape& shape : link.collision) {
          addMark({robot.name + "/" + link.name, shape, colourOf(robot.name), robot.urdf}, marks);
        }
      }
    }
    for (const ObjectSnapshot& object : scene.objects) {
      const Colour& colour = object.name == scene.object ? kObject : kThing;
      addMark({object.name, {Pose::Identity(), object.geometry}, colour, ""}, marks);
    }
    return marks;
  }

  const Colour& colourOf(const std::string& robot) const {
    std::vector<std::string> order;
    for (const Holder& holder : playback_.plan().solution.holders) {
      const std::string& name = holder.arm.robot;
      if (std::find(order.begin(), order.end(), name) == order.end()) order.push_back(name);
      if (name == robot) return kHolders[(order.size() - 1) % kHolders.size()];
    }
    return kIdle;
  }

  static void addMark(const Mark& mark, std::vector<Mark>& marks) {
    const auto* compound = std::get_if<CompoundGeometry>(&mark.shape.geometry);
    if (compound == nullptr) {
      marks.push_back(mark);
      return;
    }
    for (const GeometryPart& part : compound->parts) {
      const Shape shape{mark.shape.X_LS * toPose(part.X_OS), part.geometry};
      addMark({mark.body, shape, mark.colour, mark.urdf}, marks);
    }
  }

  void addMarkers() {
    const std::vector<Mark> all = marks();
    Cdr message;
    message.count(all.size());
    for (std::size_t id = 0; id < all.size(); ++id) addMarker(all[id], id, message);
    file_.addMessage(markers_, 0, message);
  }

  void addMarker(const Mark& mark, std::size_t id, Cdr& message) const {
    constexpr std::int32_t kAdd = 0;
    const auto [type, scale] = typeOf(mark.shape.geometry);
    message.header(0, mark.body).text(mark.body).add(static_cast<std::int32_t>(id));
    message.add(type).add(kAdd).pose(mark.shape.X_LS).point(scale);
    for (const float channel : mark.colour) message.add(channel);
    message.add(std::int32_t{0}).add(std::uint32_t{0}).add(std::uint8_t{1});  // for good, locked
    const auto corners = cornersOf(mark);
    message.count(corners.size());
    for (const Eigen::Vector3d& corner : corners) message.point(corner);
    message.count(0).text("").header(0, "").text("").count(0).count(0);  // no colours, no texture
    message.text("").text("").text("").count(0).add(std::uint8_t{0});    // no text, no mesh
  }

  static std::pair<std::int32_t, Eigen::Vector3d> typeOf(const Geometry& geometry) {
    constexpr std::int32_t kCube = 1, kSphere = 2, kCylinder = 3, kTriangleList = 11;
    if (const auto* box = std::get_if<BoxGeometry>(&geometry)) {
      return {kCube, Eigen::Vector3d(box->size.data())};
    }
    if (const auto* sphere = std::get_if<SphereGeometry>(&geometry)) {
      return {kSphere, Eigen::Vector3d::Constant(2 * sphere->radius)};
    }
    if (const auto* cylinder = std::get_if<CylinderGeometry>(&geometry)) {
      return {kCylinder, {2 * cylinder->radius, 2 * cylinder->radius, cylinder->length}};
    }
    return {kTriangleList, Eigen::Vector3d::Ones()};
  }

  /// Of a mesh's triangles; none for other shapes.
  std::vector<Eigen::Vector3d> cornersOf(const Mark& mark) const {
    const auto* mesh = std::get_if<MeshGeometry>(&mark.shape.geometry);
    if (mesh == nullptr) return {};
    const std::optional<std::string> path =
        mark.urdf.empty() ? mesh->path : files_.findMesh(mesh->path, mark.urdf);
    if (!path) throw client::PlanFileError(mark.urdf, "mesh \"" + mesh->path + "\" not found");
    auto corners = meshTriangles(files_.pathOf(*path));
    const Eigen::Vector3d scale(mesh->scale.data());
    for (Eigen::Vector3d& corner : corners) corner = corner.cwiseProduct(scale);
    return corners;
  }

  const Playback& playback_;
  const RootFiles& files_;
  McapFile file_;
  std::vector<std::uint16_t> joints_;
  std::uint16_t tf_ = 0, markers_ = 0, stage_ = 0;
};

}  // namespace

std::string planMcap(const std::string& plan_text, const std::filesystem::path& root) {
  const RootFiles files(root);
  return Recorder(Playback(client::parsePlanFile(plan_text), files), files).record();
}

}  // namespace handover::view
