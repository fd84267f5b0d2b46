// SPDX-License-Identifier: Apache-2.0
// A hash over values written out in one fixed binary form: equal values, equal hash, on any run.
#pragma once

#include "core/model/id.hpp"
#include "core/model/shape.hpp"

#include <handover/common/pose.hpp>

#include <Eigen/Core>

#include <concepts>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace handover {

/// Collects values, then hashes them (XXH3, 128 bits). Strings and lists carry their length, so
/// that neighbouring values cannot run into each other; -0.0 counts as 0.0.
class ContentHash {
 public:
  ContentHash& add(std::string_view text);
  ContentHash& add(double value);

  template <std::integral T>
  ContentHash& add(T value) {
    return addInteger(static_cast<std::int64_t>(value));
  }

  template <class Tag>
  ContentHash& add(Id<Tag> id) {
    return addInteger(id.value());
  }

  template <class Tag>
  ContentHash& add(const std::vector<Id<Tag>>& ids) {
    add(ids.size());
    for (const Id<Tag> id : ids) add(id);
    return *this;
  }

  ContentHash& add(const std::vector<int>& values);
  ContentHash& add(const Eigen::Vector3d& values);
  ContentHash& add(const Eigen::VectorXd& values);
  ContentHash& add(const Pose& X);
  ContentHash& add(const std::vector<Shape>& shapes);

  /// 32 hex digits.
  std::string hex() const;

 private:
  ContentHash& addInteger(std::int64_t value);

  std::string bytes_;
};

}  // namespace handover
