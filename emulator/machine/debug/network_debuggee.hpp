#pragma once
/// A network of chips in a debugger, or one chip alone.
#include <utility>
#include <vector>

#include "machine/debug/debuggee.hpp"
#include "machine/networks/network.hpp"

namespace machine::debug {

class NetworkDebuggee final : public Debuggee {
 public:
  /// Words that end the run of one chip, as soon as memory holds their values.
  using EndWords = std::vector<std::pair<Address, Word>>;

  /// The network must outlive it.
  explicit NetworkDebuggee(Network& network, EndWords ends = {});
  ~NetworkDebuggee() override;

  std::size_t chips() const override;
  std::string chip_name(std::size_t n) const override;
  c40::Chip& chip(std::size_t n) override;
  const toolchain::Image& program(std::size_t n) const override;
  Time time_of(std::size_t n, c40::Cycles cycle) const override;
  std::string describe(std::size_t n) override;
  void set_trace(std::size_t n, c40::TraceSink* sink) override;
  Time now() const override { return now_; }
  std::optional<std::string> over() const override;
  std::optional<std::size_t> calls() const override;
  void changed_by_hand(std::optional<std::size_t> moved) override;
  void run_until(Time time) override;
  Time slice() const override { return std::chrono::milliseconds{1}; }
  std::string save() override;
  void load(std::string_view state) override;
  std::optional<Word> peek(std::size_t n, Address address) override;
  void poke(std::size_t n, Address address, Word value) override;
  std::optional<Address> shared_word(std::size_t n, Address address) const override;
  void watch_shared(SharedListener* listener, std::vector<c40::AddressRange> words) override;
  std::vector<EventKind> event_kinds() const override;
  void listen(DebugEventListener* listener, const std::set<std::string>& kinds) override;
  std::string output() override;
  std::vector<std::string> page_names() const override;
  std::string page(std::string_view name) override;

 private:
  void advance_to(Time time);
  void look_at_words();
  void tell_new();
  std::string described(std::size_t n) const;
  std::string devices_page();

  Network& network_;
  EndWords end_words_;
  std::string holds_;  ///< the word that has ended the run
  Time now_{0};
  std::optional<NetworkStop> ended_;
  DebugEventListener* listener_ = nullptr;
  std::set<std::string> kinds_;
  std::size_t reported_ = 0;  ///< number of the network's events that have been reported
  std::vector<ChipStatus> status_;
};

}  // namespace machine::debug
