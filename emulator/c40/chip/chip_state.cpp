// The lists with which a chip and its parts are saved, loaded and compared. Derived values are computed again after
// loading: blocks, decoded slots, ids of pipelines, marks of code, the next event of the timers, whether the DMA is
// active, whether the cache holds words that memory has changed since.
#include <algorithm>
#include <cstring>
#include <utility>

#include "c40/engine/engine.hpp"
#include "c40/peripherals/link.hpp"
#include "state/visitor.hpp"

namespace c40 {
namespace {

constexpr Word saved_page_words = 1024;

// Each word is compared with the next one: the C library compares many at a time.
bool all_zero(std::span<const Word> words) {
  return words.front() == 0 && std::memcmp(words.data(), words.data() + 1, words.size_bytes() - sizeof(Word)) == 0;
}

/// Calls visit(address, words) for each page of an area.
template <class Visit>
void each_page(const Memory::Area& area, Visit&& visit) {
  if (area.data == nullptr) return;
  for (Word at = 0; at < area.words;) {
    const Word words = std::min(saved_page_words, area.words - at);
    visit(area.base + at, std::span(area.data + at, words));
    at += words;
  }
}

}  // namespace

// Not listed: values from handlers to the engine, which each instruction sets before they are read.
void Core::list_state(state::Visitor& list) {
  list("registers", r);
  list("exponents", e);
  list("negative", negative);
  list("zero", zero);
  list("carry", carry);
  list("range", range);
  list("sticky", sticky);
  list("modes", modes);
  list("pc", pc);
  list("delay_target", delay_target);
  list("delay_slots", delay_slots);
  list("delay_taken", delay_taken);
  list("delay_repeat", delay_repeat);
  list("annul", annul);
  list("idle", idle);
  list("repeat_single", repeat_single);
  list("ivtp", ivtp);
  list("tvtp", tvtp);
  if (list.loads()) attention = false, code_writes = 0;
}

void Pipeline::list_state(state::Visitor& list) {
  list("fetch_ready", fetch_ready_);
  list("read_entered", read_entered_);
  list("waited_for", waited_for_);
  list("ready", ready_);
  list("ports", ports_);
  list("buses", buses_);
}

void Cache::list_state(state::Visitor& list) {
  *this = in_order_of_use();  // so the same contents are saved as the same words
  list("words", words_);
  list("present", present_);
  list("start", start_);
}

void Fifo::list_state(state::Visitor& list) {
  list("words", words_);
  list("count", count_);
}

void Timer::list_state(state::Visitor& list) {
  list("control", control_);
  list("counter", counter_);
  list("period", period_);
  list("at", at_);
  list("toggle", toggle_);
  list("pulse", pulse_);
  list("outside", outside_);
}

void State::list_state(state::Visitor& list) {
  list("core", core);
  list("pipeline", pipeline);
  list("cycle", cycle);
  list("instructions", instructions);
  list("causes", causes);
  list("answers", answers);
  list("global_interface_control", global_interface_control);
  list("local_interface_control", local_interface_control);
  list("cache", cache);
  list("cache_control", cache_control);
  list("cache_change", cache_change);
  list("cache_changes", cache_changes);
  list("cache_clear", cache_clear);
  list("open_pages", open_pages);
  list("locked", locked);
  list("ports", ports);
  list("timers", timers);
  list("dma", dma);
  list("stalled_on_port", stalled_on_port);
  list("iiof_levels", iiof_levels);
  list("iiof_driven", iiof_driven);
  list("nmi_low", nmi_low);
  list("drives", drives);
  list("drives_reported", drives_reported);
  list("held", held);
  list("faulted", faulted);
}

/// Areas are whole during its lifetime.
class Memory::Joined {
 public:
  explicit Joined(Memory& memory) : memory_(memory), apart_(memory.apart_) { memory_.set_apart({}); }
  ~Joined() { memory_.set_apart(std::move(apart_)); }
  Joined(const Joined&) = delete;
  Joined& operator=(const Joined&) = delete;

 private:
  Memory& memory_;
  std::vector<AddressRange> apart_;
};

// The interface control registers with the values that accesses use: a write to the registers counts from the next
// instruction on.
void Memory::list_state(state::Visitor& list) {
  list("control", control_);
  if (list.loads()) note_paged();

  std::vector<Address> made, pages;
  std::vector<Word> words;
  if (!list.loads()) {
    gather();
    for (const Area* area : whole_areas()) {
      if (area->made) made.push_back(area->base);
      each_page(*area, [&](Address address, std::span<Word> page) {
        if (all_zero(page)) return;
        pages.push_back(address);
        words.insert(words.end(), page.begin(), page.end());
      });
    }
  }
  if (flat_) list("flat_pages", made);
  list("pages", pages);
  list("words", words);
  if (!list.loads()) return;

  const Joined joined(*this);
  if (flat_) set_flat_pages(made);
  auto next = pages.cbegin();
  auto from = words.cbegin();
  for (const auto& area : areas_)
    each_page(*area, [&](Address address, std::span<Word> page) {
      if (next != pages.cend() && *next == address) {
        if (words.cend() - from < static_cast<std::ptrdiff_t>(page.size()))
          throw state::StateError("memory.words: fewer than its pages have");
        std::copy_n(from, page.size(), page.begin());
        from += static_cast<std::ptrdiff_t>(page.size());
        ++next;
      } else if (!all_zero(page)) {
        std::ranges::fill(page, 0);
      }
    });
  if (next != pages.cend()) throw state::StateError("memory.pages: not the pages of this board, by rising address");
  if (from != words.cend()) throw state::StateError("memory.words: more than its pages have");
}

void Memory::set_flat_pages(const std::vector<Address>& bases) {
  std::erase_if(contents_, [&](const auto& words) {
    return std::ranges::any_of(areas_, [&](const auto& a) { return a->made && a->data == words.get(); });
  });
  std::erase_if(areas_, [](const auto& area) { return area->made; });
  flat_words_ = 0;
  for (const Address base : bases)
    if (std::as_const(*this).find(base) != nullptr || make_flat_page(base) == nullptr)
      throw state::StateError("memory.flat_pages: not the pages of this board");
}

// Not listed: members that live only from begin_following() on, during one call.
void DmaSide::list_state(state::Visitor& list) {
  // Accesses that have ended, or are not known, have no meaning; when they are removed depends on how a run is divided.
  std::erase_if(accesses_,
                [&](const ProcessorAccess& access) { return !knows_accesses_ || access.end < chip_.state.dma.now; });
  list("accesses", accesses_);
  list("knows_accesses", knows_accesses_);
  list("taken_until", taken_until_);
  list("written", written_);
  list("last_taken", last_taken_);
  list("touched_link", touched_link_);
  std::optional<Pipeline> alone;
  if (!list.loads() && undisturbed_) alone = chip_.pipelines[*undisturbed_];
  list("undisturbed", alone);
  if (list.loads()) undisturbed_ = alone ? std::optional(chip_.pipelines.intern(*alone)) : std::nullopt;
  list("gained", gained_);
}

// Not listed: the fault, which a stop has reported; `run_limit_`; and what `advance` sets before it is read.
void Engine::list_state(state::Visitor& list) {
  settle_counts();
  if (list.loads()) forget_pipelines();  // together with the blocks, whose marks are removed from the memory as it was
  list("state", state_);
  list("memory", memory_);
  peripherals_.list_state(list);

  if (state_.faulted) access_.set_reported(false);  // nothing will answer the access any more
  access_.list_state(list);
  if (reported_breakpoint_ != state_.cycle) reported_breakpoint_.reset();  // the chip has left it
  list("reported_breakpoint", reported_breakpoint_);
  Cycles idle_since = this->idle_since();
  list("idle_since", idle_since);
  if (list.loads()) idle_.set(idle_since, state_.cycle);

  list("dma_side", dma_side_);
  list("dma_request", dma_side_.request);
  list("dma_stop", dma_side_.stop);
  if (!list.loads()) return;

  peripherals_.state_changed();
  probe_.restart();
  code_ = {};
  decoded_slots_.forget();
  cache_.was_loaded(memory_);
  flush_blocks();  // marks the words in the cache
}

void Chip::list_state(state::Visitor& list) { engine_->list_state(list); }

void Link::End::list_state(state::Visitor& list) {
  list("clock", clock);
  list("views", views);
  list("seen", seen);
  list("requested", requested);
  list("has_sent", has_sent);
  list("arriving", arriving);
  list("counters", counters);
}

void Link::list_state(state::Visitor& list) {
  list("cut", cut_);
  list("action", action_);
  list("action_side", action_side_);
  list("begins", begins_);
  list("ends_at", ends_at_);
  list("ends", ends_);
  if (list.loads()) plan();
}

}  // namespace c40
