// SPDX-License-Identifier: Apache-2.0
#include "core/model/content_hash.hpp"

#include <xxhash.h>

#include <array>
#include <bit>

namespace handover {
namespace {

struct ShapeAdder {
  ContentHash& hash;

  void operator()(const BoxShape& box) const { hash.add(0).add(box.size); }

  void operator()(const SphereShape& sphere) const { hash.add(1).add(sphere.radius); }

  void operator()(const CylinderShape& cylinder) const {
    hash.add(2).add(cylinder.radius).add(cylinder.length);
  }

  void operator()(const ConvexShape& convex) const {
    hash.add(3).add(convex.vertices.size());
    for (const Eigen::Vector3d& vertex : convex.vertices) hash.add(vertex);
    hash.add(convex.triangles.size());
    for (const auto& triangle : convex.triangles) {
      for (const int corner : triangle) hash.add(corner);
    }
  }
};

}  // namespace

ContentHash& ContentHash::addInteger(std::int64_t value) {
  static_assert(std::endian::native == std::endian::little, "hashes are the same on all machines");
  const auto bytes = std::bit_cast<std::array<char, sizeof(value)>>(value);
  bytes_.append(bytes.data(), bytes.size());
  return *this;
}

ContentHash& ContentHash::add(std::string_view text) {
  add(text.size());
  bytes_.append(text);
  return *this;
}

ContentHash& ContentHash::add(double value) {
  return addInteger(std::bit_cast<std::int64_t>(value + 0.0));
}

ContentHash& ContentHash::add(const std::vector<int>& values) {
  add(values.size());
  for (const int value : values) add(value);
  return *this;
}

ContentHash& ContentHash::add(const Eigen::Vector3d& values) {
  for (const double value : values) add(value);
  return *this;
}

ContentHash& ContentHash::add(const Eigen::VectorXd& values) {
  add(values.size());
  for (const double value : values) add(value);
  return *this;
}

ContentHash& ContentHash::add(const Pose& X) {
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) add(X(row, column));
  }
  return *this;
}

ContentHash& ContentHash::add(const std::vector<Shape>& shapes) {
  add(shapes.size());
  for (const Shape& shape : shapes) {
    add(shape.X_BS);
    std::visit(ShapeAdder{*this}, shape.geometry);
  }
  return *this;
}

std::string ContentHash::hex() const {
  static constexpr char kDigits[] = "0123456789abcdef";
  XXH128_canonical_t canonical;
  XXH128_canonicalFromHash(&canonical, XXH3_128bits(bytes_.data(), bytes_.size()));
  std::string text;
  for (const unsigned char byte : canonical.digest) {
    text += kDigits[byte >> 4];
    text += kDigits[byte & 0x0F];
  }
  return text;
}

}  // namespace handover
