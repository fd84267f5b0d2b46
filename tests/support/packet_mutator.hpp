// SPDX-License-Identifier: Apache-2.0
// RTPS datagrams changed by seed: what a hostile or broken neighbour could send.
#pragma once

#include "rtps_packets.hpp"

#include <handover/common/random.hpp>

#include <span>
#include <vector>

namespace handover::test {

/// A datagram taken apart: its header, and submessages whose lengths are made anew when joined.
struct TakenApart {
  struct Part {
    std::uint8_t id = 0, flags = 0;
    Bytes content;
    int length = -1;  ///< what the header shall say; -1: the content's
  };

  Bytes header;
  std::vector<Part> parts;
};

/// @pre `datagram` is whole. Parts end where the datagram does.
TakenApart takeApart(const Bytes& datagram);
Bytes join(const TakenApart& parts);

/// The kinds of submessages in a datagram, in order.
std::vector<std::uint8_t> kindsOf(const Bytes& datagram);

/// Changes datagrams: bits flipped, ends cut, fields and lengths at the edges of their range,
/// submessages doubled, moved, borrowed from another datagram, or made about the same entities. The
/// same seed and datagrams, the same changes.
class PacketMutator {
 public:
  explicit PacketMutator(std::uint64_t seed) : random_(seed) {}

  /// A datagram with a few changes, which may borrow from `others`. @pre there are some.
  Bytes mutant(const Bytes& of, std::span<const Bytes> others);

 private:
  std::uint32_t below(std::size_t count) {
    return random_.index(static_cast<std::uint32_t>(count));
  }

  TakenApart::Part& anyPart(TakenApart& datagram) {
    return datagram.parts[below(datagram.parts.size())];
  }

  std::uint64_t edge(int size);
  void change(TakenApart& datagram, const Bytes& other);
  void setField(Bytes& content);
  void raiseCount(TakenApart::Part& part);
  void insertMade(TakenApart& datagram);
  TakenApart::Part madeAbout(const TakenApart::Part& known);
  void changeBytes(Bytes& datagram);

  SeededRandom random_;
};

}  // namespace handover::test
