// SPDX-License-Identifier: Apache-2.0
// How handoverd ends (docs/operating.md).
#pragma once

namespace handover {

enum ExitCode : int {
  kExitDone = 0,
  kExitInternal = 1,
  kExitUsage = 2,
  kExitConfiguration = 3,
  kExitDds = 4,
};

}  // namespace handover
