#include "bus_model/bus_bridge.hpp"

#include <algorithm>
#include <stdexcept>

namespace pci {

namespace {

constexpr std::size_t longest_burst = 64;

MasterConfig master_of(const BusBridgeConfig& config, const char* what) {
  MasterConfig master;
  master.name = config.name + what;
  master.latency_timer = config.latency_timer;
  master.first_level = true;
  return master;
}

}  // namespace

// One direction: claims addresses on `near`, is a master on `far`.
class BusBridge::Direction {
 public:
  Direction(Bus& near, Bus& far, const BusBridgeConfig& config, Client* client)
      : near_{near}, far_{far}, config_{config}, client_{client}, writer_{*this}, reader_{*this} {
    write_master_ = far.add_master(master_of(config, " writes"), writer_);
    read_master_ = far.add_master(master_of(config, " reads"), reader_);
  }

  void opposite(const Direction& direction) { opposite_ = &direction; }
  Bus& near() { return near_; }
  void claim(const std::string& name, Address base, std::uint64_t words) {
    TargetConfig target;
    target.name = name;
    target.devsel = 2;
    target.read_initial = 1;
    target.write_initial = 0;
    near_.add_target(target, windows_.emplace_back(*this, base, words), base, words);
  }
  std::size_t posted() const { return fifo_.size(); }
  // A read that is running ends on the far bus, and one that is taken ends on the near bus: for another bridge.
  void forget(unsigned agent) {
    std::erase_if(reads_, [&](const Read& read) {
      return read.agent == agent && (read.state == Read::State::waiting || read.state == Read::State::answered);
    });
    for (Read& read : reads_) read.unwanted = read.unwanted || read.agent == agent;
  }
  void append_state(std::vector<std::uint64_t>& words) const {
    for (const Forwarded& word : fifo_) words.insert(words.end(), {word.address, word.value, word.agent});
    for (const Read& read : reads_) {
      words.insert(words.end(), {read.address, read.agent, static_cast<std::uint64_t>(read.state), read.unwanted});
      words.insert(words.end(), read.words.begin(), read.words.end());
    }
  }
  void list_state(state::Visitor& list) {
    list("fifo", fifo_);
    list("in flight", in_flight_);
    list("pushed", pushed_);
    list("landed", landed_);
    list("reads", reads_);
  }

 private:
  struct Forwarded {
    Address address;
    Word value;
    unsigned agent;
    Clocks clock;
  };
  struct Read {
    enum class State : std::uint8_t { waiting, running, answered, taken };
    Address address;
    unsigned agent;
    unsigned wanted;
    std::uint64_t writes_before;  // posted in this direction; they have to land first
    State state = State::waiting;
    std::uint64_t writes_back = 0;  // posted in the other direction; they have to land before the answer
    Clocks since = 0;
    Result result = Result::done;
    std::vector<Word> words;
    bool unwanted = false;  // its agent has left: no answer to a later read
  };

  struct Window final : Target {
    Window(Direction& the_direction, Address the_base, std::uint64_t the_words)
        : direction{the_direction}, base{the_base}, words{the_words} {}
    Answer answer(Address offset, unsigned, bool write, const Access& access) override {
      if (write) return direction.room() == 0 ? Answer::retry : Answer::accept;
      return direction.answer(base + offset, words - offset, access);
    }
    unsigned most(Address offset, unsigned wanted, bool write, const Access& access) override {
      const std::size_t can = write ? direction.room() : direction.taken(base + offset, access).words.size();
      return static_cast<unsigned>(std::min<std::size_t>(wanted, can));
    }
    Word read(Address offset, const Access& access) override {
      const Read& read = direction.taken(base + offset, access);
      return read.words.at(base + offset - read.address);
    }
    void write(Address offset, Word value, const Access& access) override {
      direction.fifo_.push_back({base + offset, value, access.agent, access.clock});
      direction.pushed_ += 1;
      direction.send(access.clock);
    }
    Direction& direction;
    Address base;
    std::uint64_t words;
  };
  struct Writer final : Initiator {
    explicit Writer(Direction& the_direction) : direction{the_direction} {}
    unsigned framed(const Attempt& attempt, bool first, Clocks now, std::span<Word> room) override {
      return first ? direction.combine(now, room) : attempt.wanted;
    }
    void completed(const Transaction& transaction, std::span<const Word>) override { direction.landed(transaction); }
    Direction& direction;
  };
  struct Reader final : Initiator {
    explicit Reader(Direction& the_direction) : direction{the_direction} {}
    unsigned framed(const Attempt& attempt, bool, Clocks, std::span<Word>) override { return attempt.wanted; }
    void completed(const Transaction& transaction, std::span<const Word> words) override {
      direction.fetched(transaction, words);
    }
    Direction& direction;
  };

  std::size_t room() const { return config_.post_depth - fifo_.size(); }

  Clocks soon(Clocks clock) const { return std::max(clock + config_.forward, far_.now()); }

  // The first word of the FIFO requests the far bus, unless it does already.
  void send(Clocks clock) {
    if (far_.busy(write_master_) || fifo_.empty()) return;
    far_.buffer(write_master_)[0] = fifo_.front().value;
    far_.submit(write_master_, Command::write, fifo_.front().address, 1, soon(clock), fifo_.front().agent);
  }

  unsigned combine(Clocks now, std::span<Word> words) {
    std::size_t n = 1;
    while (n < fifo_.size() && n < longest_burst && fifo_[n].address == fifo_[0].address + n &&
           fifo_[n].agent == fifo_[0].agent && fifo_[n].clock <= now)
      n += 1;
    for (std::size_t i = 0; i < n; ++i) words[i] = fifo_[i].value;
    in_flight_ = n;
    return static_cast<unsigned>(n);
  }

  void landed(const Transaction& transaction) {
    const Clocks ended = transaction.ended;
    for (std::size_t i = 0; i < in_flight_; ++i) {
      const Forwarded word = fifo_.front();
      fifo_.pop_front();
      landed_ += 1;
      if (client_ != nullptr)
        client_->delivered(far_, word.agent, word.address, word.value, transaction.ended,
                           i < transaction.words ? Result::done : transaction.result);
    }
    in_flight_ = 0;
    send(ended);
    fetch(ended);
  }

  // The oldest read whose turn has come requests the far bus.
  void fetch(Clocks clock) {
    if (far_.busy(read_master_)) return;
    for (Read& read : reads_) {
      if (read.state != Read::State::waiting || landed_ < read.writes_before) continue;
      read.state = Read::State::running;
      far_.submit(read_master_, far_.command_of(false, read.address, read.wanted), read.address, read.wanted,
                  soon(clock), read.agent);
      return;
    }
  }

  void fetched(const Transaction& transaction, std::span<const Word> words) {
    const auto read = std::ranges::find(reads_, Read::State::running, &Read::state);
    if (read->unwanted) {
      reads_.erase(read);
      return fetch(transaction.ended);
    }
    read->state = Read::State::answered;
    read->since = transaction.ended;
    read->result = transaction.result;
    read->writes_back = opposite_->pushed_;
    read->words.assign(words.begin(), words.end());
    fetch(transaction.ended);
  }

  Answer answer(Address address, std::uint64_t to_the_end, const Access& access) {
    std::erase_if(reads_, [&](const Read& read) {
      return read.state == Read::State::taken ||
             (read.state == Read::State::answered && access.clock > read.since + discard_clocks);
    });
    const auto known = std::ranges::find_if(reads_, [&](const Read& read) {
      return read.address == address && read.agent == access.agent && !read.unwanted;
    });
    if (known == reads_.end()) {
      if (reads_.size() < config_.delayed_reads) {
        reads_.push_back({.address = address,
                          .agent = access.agent,
                          .wanted = ahead(address, to_the_end, access.command),
                          .writes_before = pushed_,
                          .words = {}});
        fetch(access.clock);
      }
      return Answer::retry;
    }
    if (known->state != Read::State::answered || opposite_->landed_ < known->writes_back) return Answer::retry;
    known->state = Read::State::taken;
    return known->result == Result::done ? Answer::accept : Answer::abort;
  }

  const Read& taken(Address address, const Access& access) const {
    return *std::ranges::find_if(reads_, [&](const Read& read) {
      return read.state == Read::State::taken && read.agent == access.agent && address >= read.address &&
             address - read.address < read.words.size();
    });
  }

  unsigned ahead(Address address, std::uint64_t to_the_end, Command command) const {
    const unsigned line = near_.config().line_words;
    unsigned words = 1;
    if (command != Command::read) words = line - (address & (line - 1));
    if (command == Command::read_multiple) words += line * (config_.prefetch_lines - 1);
    return static_cast<unsigned>(std::min<std::uint64_t>(words, to_the_end));
  }

  Bus& near_;
  Bus& far_;
  BusBridgeConfig config_;
  Client* client_;
  const Direction* opposite_ = nullptr;
  Writer writer_;
  Reader reader_;
  unsigned write_master_ = 0;
  unsigned read_master_ = 0;
  std::deque<Window> windows_;
  std::deque<Forwarded> fifo_;
  std::size_t in_flight_ = 0;
  std::uint64_t pushed_ = 0;
  std::uint64_t landed_ = 0;
  std::deque<Read> reads_;
};

BusBridge::BusBridge(Bus& first, Bus& second, const BusBridgeConfig& config, Client* client) {
  const auto require = [&](bool good, const char* what) {
    if (!good) throw std::invalid_argument{config.name + ": " + what};
  };
  require(&first != &second, "a bridge joins two buses");
  require(config.post_depth >= 1 && config.post_depth <= 256, "post_depth is 1 to 256 words");
  require(config.delayed_reads >= 1, "delayed_reads is at least 1");
  require(config.prefetch_lines >= 1 && config.prefetch_lines * first.config().line_words <= Bus::most_words,
          "prefetch_lines is at least 1, and a transaction has at most 256 words");
  require(config.forward >= 1, "forward is at least 1 clock");
  there_ = std::make_unique<Direction>(first, second, config, client);
  back_ = std::make_unique<Direction>(second, first, config, client);
  there_->opposite(*back_);
  back_->opposite(*there_);
}

BusBridge::~BusBridge() = default;

void BusBridge::claim(Bus& near, const std::string& name, Address base, std::uint64_t words) {
  if (&near != &there_->near() && &near != &back_->near())
    throw std::invalid_argument{"pci::BusBridge::claim: a bus that the bridge is not on"};
  (&near == &there_->near() ? there_ : back_)->claim(name, base, words);
}

void BusBridge::forget(unsigned agent) {
  there_->forget(agent);
  back_->forget(agent);
}

std::size_t BusBridge::posted() const { return there_->posted() + back_->posted(); }

void BusBridge::list_state(state::Visitor& list) {
  list("there", *there_);
  list("back", *back_);
}

void BusBridge::append_state(std::vector<std::uint64_t>& words) const {
  there_->append_state(words);
  back_->append_state(words);
}

}  // namespace pci
