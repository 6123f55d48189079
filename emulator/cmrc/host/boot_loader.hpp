#pragma once
// The host's boot loader, which works between refreshes. LINK_REQUEST tells which DSPs wait. The host writes each one's
// boot stream into the DSP's port of the link adapter, as many words at a time as fit into the port's FIFO, until the
// DSP answers with its slot + 1.
//
// Several DSPs are booted at once, in turn. A DSP that takes no word for the limit, or answers something else, is given
// up until its next reset.
#include <cstdint>
#include <deque>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "cmrc/tasks/words.hpp"
#include "machine/system/host_program.hpp"

namespace state {
class Visitor;
}

namespace cmrc {

using machine::Time;

class BootLoader {
 public:
  /// \param stream the boot stream of a slot's DSP
  /// \param pause between two accesses to the same port
  BootLoader(const Words& words, std::function<std::vector<Word>(unsigned slot)> stream, Time limit, Time pause);

  /// At power-on: this DSP will request its program.
  void expect(unsigned slot, Time now);
  /// LINK_REQUEST has a bit set.
  void requested() { requested_ = true; }
  /// No DSP is being booted, or expected to request its program.
  bool done() const { return !requested_ && boots_.empty(); }
  /// When the host should take the next step; never if there is nothing to do.
  Time next() const;
  /// Makes the next access. True: the access is a read; pass its answer to answer().
  bool step(Time now, machine::HostPort& port);
  /// Returns the same as step().
  bool answer(Word word, Time now, machine::HostPort& port);

  struct Ended {
    unsigned slot;
    std::string failure;  ///< empty: its program runs
  };
  /// Slots that since the last call have requested their program or have been sent a part of it (bit n: slot n): until
  /// then they have been without one.
  Word take_without_program() { return std::exchange(without_program_, 0); }
  /// The boots that have ended since the last call.
  std::vector<Ended> take_ended();
  void list_state(state::Visitor& list);

 private:
  enum class Asked : std::uint8_t { request, status, answer };
  struct Boot {
    unsigned slot;
    Time due;       // time of the next access
    Time progress;  // when the last word was sent, or the request was first expected
    std::size_t sent = 0;
    std::vector<Word> stream;  // empty: the DSP has not requested it yet
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
  std::deque<Boot> boots_;  // the one whose turn it is comes first
  std::vector<Ended> ended_;
  Word without_program_ = 0;
};

}  // namespace cmrc
