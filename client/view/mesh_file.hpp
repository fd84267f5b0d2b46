// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include <filesystem>
#include <vector>

namespace handover::view {

/// The corners of every triangle of a mesh file, three each, node transforms and units honoured,
/// axes as in the file. @throws
/// client::PlanFileError when it is no mesh or has no triangle.
std::vector<Eigen::Vector3d> meshTriangles(const std::filesystem::path& file);

}  // namespace handover::view
