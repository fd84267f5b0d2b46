// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

namespace handover::verify {

/// Where a plan's paths are looked up unless --root says otherwise: HANDOVER_ROOT, else the
/// installed share beside the running program, else the repository that it was built in. Empty:
/// none of them is there.
std::filesystem::path defaultRoot();

}  // namespace handover::verify
