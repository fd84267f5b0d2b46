// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace handover {

/// What several clients wait for, handed out in fair turns: to the client with the fewest running,
/// of those to the one that used the least time, of those to the one whose turn was the longest
/// ago. A client that comes starts with the time of the one that used the least, so it neither
/// waits for others' past nor lives on its own idleness. Not safe from several threads.
template <typename Item>
class FairQueue {
 public:
  /// @param place  among the client's own: low ones first, each once.
  void push(const std::string& client, std::uint64_t place, Item item) {
    Client& of = clients_[client];
    if (!of.active()) of.used_s = std::max(of.used_s, leastUsed());
    of.waiting.emplace(place, std::move(item));
    ++size_;
  }

  /// How many that wait would go before one that this client added now, if each took as long: its
  /// own, and as many turns of every other client.
  std::size_t ahead(const std::string& client) const {
    const auto found = clients_.find(client);
    Client self = found == clients_.end() ? Client{} : found->second.withoutItems();
    const std::size_t own = found == clients_.end() ? 0 : found->second.waiting.size();
    if (own == 0 && self.running == 0) self.used_s = std::max(self.used_s, leastUsed());
    std::size_t ahead = own;
    for (const auto& [name, other] : clients_) {
      if (name == client) continue;
      const bool first = std::tuple(other.rank(), name) < std::tuple(self.rank(), client);
      const std::size_t turns = own + (first ? 1 : 0);
      ahead += std::min(other.waiting.size(), turns);
    }
    return ahead;
  }

  /// Takes the next, which runs until finished(). @pre !empty()
  Item pop() {
    const auto next = std::min_element(
        clients_.begin(), clients_.end(),
        [](const auto& a, const auto& b) { return a.second.turn() < b.second.turn(); });
    Client& of = next->second;
    Item item = std::move(of.waiting.begin()->second);
    of.waiting.erase(of.waiting.begin());
    --size_;
    ++of.running;
    of.last_turn = ++turns_;
    return item;
  }

  /// One of the client's runs no more, after so much time.
  void finished(const std::string& client, double seconds) {
    Client& of = clients_[client];
    --of.running;
    of.used_s += seconds;
    forget();
  }

  /// Takes out those that fulfil a condition; they do not run.
  template <typename Condition>
  std::vector<Item> extract(Condition condition) {
    std::vector<Item> taken;
    for (auto& [name, client] : clients_) {
      std::erase_if(client.waiting, [&](auto& entry) {
        if (!condition(entry.second)) return false;
        taken.push_back(std::move(entry.second));
        return true;
      });
    }
    size_ -= taken.size();
    forget();
    return taken;
  }

  template <typename Visit>
  void forEach(Visit visit) const {
    for (const auto& [name, client] : clients_) {
      for (const auto& [place, item] : client.waiting) visit(item);
    }
  }

  std::size_t size() const { return size_; }

  bool empty() const { return size_ == 0; }

 private:
  struct Client {
    std::map<std::uint64_t, Item> waiting;  ///< by place
    int running = 0;
    double used_s = 0;
    std::uint64_t last_turn = 0;

    bool active() const { return !waiting.empty() || running > 0; }

    /// Among those that wait.
    auto rank() const { return std::tuple(running, used_s, last_turn); }

    /// The least of those that wait is next.
    auto turn() const { return std::tuple_cat(std::tuple(waiting.empty()), rank()); }

    Client withoutItems() const { return {{}, running, used_s, last_turn}; }
  };

  /// Of those that wait or run; 0 when none does.
  double leastUsed() const {
    bool any = false;
    double least = 0;
    for (const auto& [name, client] : clients_) {
      if (!client.active()) continue;
      least = any ? std::min(least, client.used_s) : client.used_s;
      any = true;
    }
    return least;
  }

  /// Clients without requests that would start again as if they had never been here.
  void forget() {
    const bool idle = std::none_of(clients_.begin(), clients_.end(),
                                   [](const auto& entry) { return entry.second.active(); });
    const double least = leastUsed();
    std::erase_if(clients_, [&](const auto& entry) {
      return !entry.second.active() && (idle || entry.second.used_s <= least);
    });
  }

  std::map<std::string, Client> clients_;
  std::size_t size_ = 0;
  std::uint64_t turns_ = 0;
};

}  // namespace handover
