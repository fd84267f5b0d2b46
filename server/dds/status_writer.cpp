// SPDX-License-Identifier: Apache-2.0
#include "dds/status_writer.hpp"

#include <handover/common/log.hpp>

#include <utility>

namespace handover {

StatusWriter::StatusWriter(const wire::Participant& participant, std::uint64_t most)
    : participant_(participant), most_(most) {
  current_.emplace(participant_, wire::EntityOptions{});
}

wire::WriteResult StatusWriter::write(const msg::DaemonStatus& status) {
  last_.reset();
  if (written_ >= most_) {
    try {
      wire::Writer<msg::DaemonStatus> next(participant_, {});
      last_ = std::exchange(current_, std::move(next));
      written_ = 0;
    } catch (const wire::DdsError& error) {
      logger("dds")->warn("the status goes on with its old writer: {}", error.what());
    }
  }
  ++written_;
  return current_->write(status);
}

}  // namespace handover
