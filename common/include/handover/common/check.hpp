// SPDX-License-Identifier: Apache-2.0
// The bounds of what travels: checked by both ends, since the wire itself checks none.
#pragma once

#include <handover/common/plan_event.hpp>
#include <handover/common/status.hpp>

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace handover {

/// Largest sizes of a message's parts. Text in bytes.
namespace bounds {
inline constexpr std::size_t kName = 256;
inline constexpr std::size_t kPath = 1024;
inline constexpr std::size_t kOverridePath = 512;
inline constexpr std::size_t kText = 4096;
inline constexpr std::size_t kOverrides = 256;
inline constexpr std::size_t kFaults = 1024;
inline constexpr std::size_t kRobots = 64;
inline constexpr std::size_t kObjects = 1024;
inline constexpr std::size_t kJoints = 512;  ///< and links of a robot
inline constexpr std::size_t kParts = 4096;
inline constexpr std::size_t kPairs = 4096;
inline constexpr std::size_t kLattice = 4096;
inline constexpr std::size_t kSlices = 16;  ///< of workspaces
inline constexpr std::size_t kSliceCells = 32'768;
inline constexpr std::size_t kScores = 256;
inline constexpr std::size_t kHolders = 8;  ///< of a chain
inline constexpr std::size_t kStages = 128;
inline constexpr std::size_t kQualities = 64;  ///< entries of a list of Quality
inline constexpr std::size_t kSamples = 100'000;
inline constexpr std::size_t kCells = 1024;
inline constexpr std::size_t kVariations = 256;
inline constexpr std::size_t kChoices = 256;
inline constexpr std::size_t kRangeSize = 64;  ///< numbers of a range's end
inline constexpr double kSlowest = 1e-3;  ///< speed scale: a plan of a minute takes most of a day
inline constexpr double kSlack = 10;      ///< [s]
}  // namespace bounds

/// True for [a-z0-9_-]{1,64}.
bool validClientId(std::string_view text);

/// `robot` or `robot/arm`; nullopt for anything else. An arm left out is empty.
std::optional<ArmName> holderOf(std::string_view text);

/// Every fault of a value: sizes beyond the bounds, numbers that are not finite, quaternions off
/// unit length by more than 1e-3, unknown enumerators, rows of the wrong length, times that do not
/// rise, chain entries of another form. `field` is the member's path, list entries by index. Empty:
/// none. Names are not looked up here.
std::vector<Fault> check(const PlanRequest& request);
std::vector<Fault> check(const PlanEvent& event);
std::vector<Fault> check(const DaemonStatus& status);
std::vector<Fault> check(const Variation& variation);

/// Faults in one line, each as " field message;".
std::string describe(const std::vector<Fault>& faults);

}  // namespace handover
