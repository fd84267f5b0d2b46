// SPDX-License-Identifier: Apache-2.0
// What commands share: where text goes, and how errors become exit codes.
#pragma once

#include "commands.hpp"
#include "signals.hpp"

#include <handover/client/client.hpp>

#include <exception>
#include <iosfwd>
#include <string>

namespace handover::ctl {

/// Where text for people goes.
std::ostream& people(const CommonOptions& common);

/// Says why on standard error, with --json as a line on standard output too; returns the code.
int fail(const CommonOptions& common, int code, const std::string& text);

int exitCodeOf(client::ClientError::Code code);

/// Runs a command with a client; its errors become exit codes.
template <typename Command>
int withClient(const CommonOptions& common, Command command) {
  SignalWatch::blockSignals();
  try {
    client::Client client({.domain = common.domain, .client_id = {}, .wait = common.wait});
    return command(client);
  } catch (const client::ClientError& error) {
    return fail(common, exitCodeOf(error.code()), error.what());
  } catch (const std::exception& error) {
    return fail(common, kExitInternal, error.what());
  }
}

}  // namespace handover::ctl
