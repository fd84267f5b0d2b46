// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace handover {

/// Has the allocator keep few pools: one for each thread holds on to what its busiest moment took.
/// Before the first thread.
void boundAllocatorPools();

/// Gives what the allocator holds unused back to the system. Takes milliseconds, in which others
/// that allocate wait.
void giveUnusedMemoryBack();

/// Memory that this process has resident; 0 where the system does not say.
std::uint64_t residentBytes();

}  // namespace handover
