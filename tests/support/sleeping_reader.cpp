// SPDX-License-Identifier: Apache-2.0
// Reads the events of everybody and takes none: its first callback never returns. Prints "reading"
// and stays until it is killed. usage: sleeping_reader DOMAIN
#include "wire/entities.hpp"

#include <handover/common/domain.hpp>

#include <iostream>
#include <latch>

int main(int argc, char** argv) {
  using namespace handover;
  const auto domain = parseDomain(argc == 2 ? argv[1] : "");
  if (!domain) {
    std::cerr << "usage: sleeping_reader DOMAIN\n";
    return 2;
  }
  std::latch never(1);
  const wire::Participant participant({.domain = *domain, .name = "sleeps", .on_writer = {}});
  const wire::Reader<msg::PlanEvent> reader(participant, {.partition = "*"},
                                            [&never](const auto&) { never.wait(); });
  std::cout << "reading" << std::endl;
  never.wait();
}
