// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace handover {

/// What handoverd and handoverctl return; the daemon only those below 10.
enum ExitCode : int {
  kExitDone = 0,
  kExitInternal = 1,
  kExitUsage = 2,
  kExitConfiguration = 3,
  kExitDds = 4,
  kExitNoPlan = 10,
  kExitCancelled = 11,
  kExitRejected = 12,
  kExitNoDaemon = 13,
};

}  // namespace handover
