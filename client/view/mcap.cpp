// SPDX-License-Identifier: Apache-2.0
#include "view/mcap.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string_view>

namespace handover::view {
namespace {

using verify::Pose;

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

/// Writes the topics of one plan.
class Recorder {
 public:
  explicit Recorder(const verify::Motion& motion) : motion_(motion), scene_(motion.scene()) {
    const std::string with_header = std::string(kJointState) + std::string(kHeaderAndTime);
    for (const auto& robot : scene_.plan.robots) {
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
    double end = 0;
    for (const auto& stage : scene_.plan.stages) end = std::max(end, stage.end());
    const auto frames = static_cast<int>(std::ceil(end / kFrame));
    std::vector<const verify::PlanEvent*> stages;
    for (const auto& stage : scene_.plan.stages) stages.push_back(&stage);
    std::stable_sort(stages.begin(), stages.end(),
                     [](const auto* a, const auto* b) { return a->start < b->start; });
    addMarkers();
    std::size_t begun = 0;
    for (int frame = 0; frame <= frames; ++frame) {
      const double T = std::min(frame * kFrame, end);
      for (; begun < stages.size() && stages[begun]->start <= T; ++begun) {
        file_.addMessage(stage_, T, Cdr().text(stages[begun]->kind));
      }
      addFrame(T);
    }
    return file_.finish();
  }

 private:
  void addFrame(double T) {
    Cdr transforms;
    std::size_t count = scene_.plan.objects.size();
    for (const auto& robot : scene_.robots) count += robot.links.size();
    transforms.count(count);
    const auto add = [&](const std::string& frame, const Pose& X) {
      transforms.header(T, "world").text(frame).pose(X);
    };
    for (std::size_t r = 0; r < scene_.robots.size(); ++r) {
      const auto robot = static_cast<int>(r);
      const std::vector<double> q = motion_.jointsAt(robot, T);
      addJoints(r, q, T);
      std::vector<Pose> X_WL;
      scene_.kinematics[r].linkPoses(q, X_WL);
      for (std::size_t link = 0; link < X_WL.size(); ++link) {
        add(scene_.plan.robots[r].name + "/" + scene_.robots[r].links[link].name, X_WL[link]);
      }
    }
    for (std::size_t o = 0; o < scene_.plan.objects.size(); ++o) {
      const auto object = static_cast<int>(o);
      add(scene_.plan.objects[o].name,
          object == scene_.object ? motion_.objectAt(T) : motion_.otherObjectAt(object, T));
    }
    file_.addMessage(tf_, T, transforms);
  }

  void addJoints(std::size_t robot, const std::vector<double>& q, double T) {
    std::vector<std::string> names;
    std::vector<double> positions;
    for (std::size_t j = 0; j < q.size(); ++j) {
      const verify::Joint& joint = scene_.robots[robot].joints[j];
      if (!joint.movable()) continue;
      names.push_back(joint.name);
      positions.push_back(q[j]);
    }
    Cdr message;
    message.header(T, "").count(names.size());
    for (const std::string& name : names) message.text(name);
    message.numbers(positions).count(0).count(0);
    file_.addMessage(joints_[robot], T, message);
  }

  void addMarkers() {
    Cdr message;
    message.count(scene_.bodies.size());
    for (std::size_t b = 0; b < scene_.bodies.size(); ++b) {
      const verify::SceneBody& body = scene_.bodies[b];
      constexpr std::int32_t kTriangleList = 11, kAdd = 0;
      message.header(0, body.name).text(body.name).add(static_cast<std::int32_t>(b));
      message.add(kTriangleList).add(kAdd).pose(Pose::Identity()).point(Eigen::Vector3d::Ones());
      for (const float channel : colourOf(body)) message.add(channel);
      message.add(std::int32_t{0}).add(std::uint32_t{0}).add(std::uint8_t{1});  // for good, locked
      std::size_t corners = 0;
      for (const auto& shell : body.body.shells()) corners += 3 * shell.mesh.triangles.size();
      message.count(corners);
      for (const auto& shell : body.body.shells()) {
        for (const auto& triangle : shell.mesh.triangles) {
          for (const int corner : triangle) {
            message.point(shell.mesh.vertices[static_cast<std::size_t>(corner)]);
          }
        }
      }
      message.count(0).text("").header(0, "").text("").count(0).count(0);  // no colours, no texture
      message.text("").text("").text("").count(0).add(std::uint8_t{0});    // no text, no mesh
    }
    file_.addMessage(markers_, 0, message);
  }

  std::array<float, 4> colourOf(const verify::SceneBody& body) const {
    if (body.object >= 0 && body.object == scene_.object) return {0.25f, 0.64f, 0.30f, 1.0f};
    if (body.object >= 0) return {0.85f, 0.81f, 0.75f, 1.0f};
    if (body.robot == scene_.giver.robot) return {0.85f, 0.60f, 0.37f, 1.0f};
    if (body.robot == scene_.receiver.robot) return {0.50f, 0.65f, 0.81f, 1.0f};
    return {0.72f, 0.75f, 0.78f, 1.0f};
  }

  const verify::Motion& motion_;
  const verify::Scene& scene_;
  McapFile file_;
  std::vector<std::uint16_t> joints_;
  std::uint16_t tf_ = 0, markers_ = 0, stage_ = 0;
};

}  // namespace

std::string planMcap(const verify::Motion& motion) { return Recorder(motion).record(); }

}  // namespace handover::view
