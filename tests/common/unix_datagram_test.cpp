// SPDX-License-Identifier: Apache-2.0
#include <handover/common/descriptor.hpp>
#include <handover/common/unix_datagram.hpp>

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>

#include <cstring>

namespace handover {
namespace {

TEST(UnixDatagram, ReachesASocketOfTheAbstractSpace) {
  const Descriptor fd(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  socklen_t size = sizeof(sa_family_t);  // the kernel finds a name
  ASSERT_EQ(::bind(fd.get(), reinterpret_cast<sockaddr*>(&address), size), 0);
  size = sizeof(address);
  ASSERT_EQ(::getsockname(fd.get(), reinterpret_cast<sockaddr*>(&address), &size), 0);
  const std::string name(address.sun_path + 1, size - sizeof(sa_family_t) - 1);
  EXPECT_TRUE(sendUnixDatagram("@" + name, "READY=1"));
  char got[16] = {};
  EXPECT_EQ(::recv(fd.get(), got, sizeof(got), 0), 7);
  EXPECT_STREQ(got, "READY=1");
}

TEST(UnixDatagram, SaysWhereNobodyReads) {
  EXPECT_FALSE(sendUnixDatagram("", "x"));
  EXPECT_FALSE(sendUnixDatagram("/nowhere/socket", "x"));
  EXPECT_FALSE(sendUnixDatagram(std::string(200, 'a'), "x"));
}

}  // namespace
}  // namespace handover
