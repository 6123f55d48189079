#pragma once
// Booting DSPs, as the host does it between its refreshes: it learns from LINK_REQUEST who waits, and writes each one's
// boot stream into its port of the link adapter, as many words at a time as the port's FIFO has room for, until the DSP
// answers with its slot + 1.
//
// Several are booted at once, in turn. One that takes no word for the limit, or answers something else, is given up
// until it is reset.
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "cmrc/tasks/words.hpp"
#include "machine/machine.hpp"

namespace state {
class Visitor;
}

namespace cmrc {

using machine::Time;

class BootLoader {
 public:
  /// \param stream what a slot's DSP is to be sent
  /// \param pause between two looks at the same port
  BootLoader(const Words& words, std::function<std::vector<Word>(unsigned slot)> stream, Time limit, Time pause);

  /// At power-on: this one will ask.
  void expect(unsigned slot, Time now);
  /// LINK_REQUEST has a bit set.
  void requested() { requested_ = true; }
  /// Nobody is being booted, or expected to ask.
  bool done() const { return !requested_ && boots_.empty(); }
  /// When the host should take the next step; never if nothing is to be done.
  Time next() const;
  /// Makes the next access. True: it is a read, whose answer belongs to answer().
  bool step(Time now, machine::HostPort& port);
  /// As step().
  bool answer(Word word, Time now, machine::HostPort& port);

  struct Ended {
    unsigned slot;
    std::string failure;  ///< empty: its program runs
  };
  /// Since this was last asked.
  std::vector<Ended> take_ended();
  void list_state(state::Visitor& list);

 private:
  enum class Asked : std::uint8_t { request, status, answer };
  struct Boot {
    unsigned slot;
    Time due;       // of the next look
    Time progress;  // the last word went, or it was first expected
    std::size_t sent = 0;
    std::vector<Word> stream;  // empty: it has not asked yet
  };

  void begin(Word slots, Time now, machine::HostPort& port);
  bool look(Word status, Time now, machine::HostPort& port);
  void end(std::string failure);
  Word at(Word reg) const { return words_.link_adapter + boots_.front().slot * words_.link_words + reg; }

  const Words& words_;
  std::function<std::vector<Word>(unsigned)> stream_;
  Time limit_, pause_;
  bool requested_ = false;
  Asked asked_ = Asked::request;
  std::deque<Boot> boots_;  // whose turn it is comes first
  std::vector<Ended> ended_;
};

}  // namespace cmrc
