// SPDX-License-Identifier: Apache-2.0
#include "runtime/memory.hpp"

#include <malloc.h>
#include <unistd.h>

#include <fstream>

namespace handover {
namespace {

/// Workers, senders and the middleware seldom allocate at the same moment.
constexpr int kMostPools = 2;

}  // namespace

void boundAllocatorPools() { ::mallopt(M_ARENA_MAX, kMostPools); }

void giveUnusedMemoryBack() { ::malloc_trim(0); }

std::uint64_t residentBytes() {
  std::ifstream statm("/proc/self/statm");
  std::uint64_t size = 0, resident = 0;
  statm >> size >> resident;
  return statm ? resident * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE)) : 0;
}

}  // namespace handover
