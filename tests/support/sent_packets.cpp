// SPDX-License-Identifier: Apache-2.0
#include "sent_packets.hpp"

#include <arpa/inet.h>
#include <dlfcn.h>
#include <sys/socket.h>
#include <sys/uio.h>

#include <algorithm>
#include <deque>
#include <mutex>
#include <string_view>
#include <utility>

namespace handover::test {
namespace {

constexpr std::size_t kMostKept = 4096;

struct Record {
  std::mutex mutex;
  std::deque<SentPacket> packets;
};

Record& record() {
  static Record all;
  return all;
}

thread_local bool unrecorded = false;

void note(const sockaddr* to, const iovec* pieces, std::size_t count) {
  if (unrecorded || to == nullptr || to->sa_family != AF_INET) return;
  SentPacket packet{ntohs(reinterpret_cast<const sockaddr_in*>(to)->sin_port), {}};
  for (std::size_t i = 0; i < count; ++i) {
    const auto* bytes = static_cast<const std::uint8_t*>(pieces[i].iov_base);
    packet.bytes.insert(packet.bytes.end(), bytes, bytes + pieces[i].iov_len);
  }
  constexpr std::string_view kMagic = "RTPS";
  if (packet.bytes.size() < 20 || !std::equal(kMagic.begin(), kMagic.end(), packet.bytes.begin()))
    return;
  const std::lock_guard lock(record().mutex);
  record().packets.push_back(std::move(packet));
  if (record().packets.size() > kMostKept) record().packets.pop_front();
}

template <typename Function>
Function* theirs(const char* name) {
  return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}

}  // namespace

std::vector<SentPacket> sentPackets() {
  const std::lock_guard lock(record().mutex);
  return {record().packets.begin(), record().packets.end()};
}

void forgetSentPackets() {
  const std::lock_guard lock(record().mutex);
  record().packets.clear();
}

Unrecorded::Unrecorded() { unrecorded = true; }

Unrecorded::~Unrecorded() { unrecorded = false; }

}  // namespace handover::test

extern "C" {

ssize_t sendmsg(int socket, const msghdr* message, int flags) {
  static auto* const next = handover::test::theirs<decltype(sendmsg)>("sendmsg");
  handover::test::note(static_cast<const sockaddr*>(message->msg_name), message->msg_iov,
                       message->msg_iovlen);
  return next(socket, message, flags);
}

ssize_t sendto(int socket, const void* bytes, std::size_t size, int flags, const sockaddr* to,
               socklen_t length) {
  static auto* const next = handover::test::theirs<decltype(sendto)>("sendto");
  const iovec whole{const_cast<void*>(bytes), size};
  handover::test::note(to, &whole, 1);
  return next(socket, bytes, size, flags, to, length);
}
}
