// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace handover::test {

/// Whether this is a sanitizer's build, where everything takes many times as long.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif

}  // namespace handover::test
