// SPDX-License-Identifier: Apache-2.0
#include "damage.hpp"

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <vector>

namespace handover::test {
namespace {

const char* const kWords[] = {"nan",
                              "-1",
                              "1e999",
                              "1e-320",
                              "0x1p3",
                              "1,5",
                              "[",
                              "{",
                              "*a",
                              "&a",
                              "<",
                              "\"",
                              "0",
                              "\n",
                              ": ",
                              "!!int",
                              "---\n",
                              "99999999999",
                              "18446744073709551616",
                              "/",
                              "..",
                              "\xFF",
                              "-",
                              "<link/>",
                              "<!--",
                              "&#0;",
                              "<![CDATA["};

class Damager {
 public:
  Damager(std::string text, std::mt19937_64& generator)
      : text_(std::move(text)), generator_(generator) {}

  std::string make() {
    for (std::size_t changes = 1 + below(4); changes > 0 && !text_.empty(); --changes) change();
    return std::move(text_);
  }

 private:
  std::size_t below(std::size_t n) { return generator_() % std::max<std::size_t>(n, 1); }

  void change() {
    const std::size_t at = below(text_.size()), length = 1 + below(12);
    switch (below(8)) {
      case 0:
        text_[at] = static_cast<char>(generator_() & 0xFFu);
        break;
      case 1:
        text_.erase(at, length);
        break;
      case 2:
        text_.insert(at, text_.substr(below(text_.size()), length));
        break;
      case 3:
        text_.replace(at, length, word());
        break;
      case 4:
        replaceToken(at);
        break;
      case 5:
        changeLines();
        break;
      case 6:
        text_[at] = static_cast<char>(text_[at] ^ (1 << below(8)));
        break;
      default:
        if (below(4) == 0) text_.resize(at);
        break;
    }
  }

  const char* word() { return kWords[below(std::size(kWords))]; }

  /// The word or number that lies at or after a place.
  void replaceToken(std::size_t at) {
    const auto inside = [](char c) {
      return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '.' || c == '_' || c == '-';
    };
    while (at < text_.size() && !inside(text_[at])) ++at;
    std::size_t begin = at, end = at;
    while (begin > 0 && inside(text_[begin - 1])) --begin;
    while (end < text_.size() && inside(text_[end])) ++end;
    text_.replace(begin, end - begin, word());
  }

  void changeLines() {
    std::vector<std::string> lines(1);
    for (const char c : text_) {
      lines.back() += c;
      if (c == '\n') lines.emplace_back();
    }
    const std::size_t a = below(lines.size()), b = below(lines.size());
    const auto place = [&lines](std::size_t i) {
      return lines.begin() + static_cast<std::ptrdiff_t>(i);
    };
    const std::size_t how = below(3);
    if (how == 0) lines.erase(place(a));
    if (how == 1) lines.insert(place(a), std::string(lines[b]));
    if (how == 2) std::swap(lines[a], lines[b]);
    text_.clear();
    for (const std::string& line : lines) text_ += line;
  }

  std::string text_;
  std::mt19937_64& generator_;
};

}  // namespace

std::string damaged(std::string text, std::mt19937_64& generator) {
  return Damager(std::move(text), generator).make();
}

int fuzzRuns(int runs) {
  const char* factor = std::getenv("HANDOVER_FUZZ_FACTOR");
  return runs * std::max(1, factor == nullptr ? 1 : std::atoi(factor));
}

}  // namespace handover::test
