// SPDX-License-Identifier: Apache-2.0
// Standard streams that are closed, full or without a reader, as programs have to expect them.
#pragma once

#include <string>

namespace handover {

/// Makes what is written to a stream that takes nothing an error of the writing, not the end of the
/// process; streams that are closed are held, so that no file or socket takes their place. To be
/// called first, from the only thread.
void holdStandardStreams();

/// The exit code of a program that would end with `code`: 3 in place of 0 where standard output did
/// not take all of its text, which standard error says after the program's name.
int checkedOutput(const std::string& program, int code);

}  // namespace handover
