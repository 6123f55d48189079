// Memories that several chips access: shared ones, with one access at a time, and dual-port ones.
#include <fmt/format.h>

#include <algorithm>

#include "isa/decode.hpp"
#include "machine/networks/network_parts.hpp"

namespace machine {

using c40::Address;
using c40::Cycles;
using c40::Word;

namespace {

bool is_sigi(Word word) {
  const isa::Decoded decoded = isa::decode(word);
  const auto* instruction = std::get_if<isa::Instruction>(&decoded);
  return instruction != nullptr && instruction->row->mnemonic == "sigi";
}

}  // namespace

void Network::add_memories() {
  for (const SharedMemory& given : description_.memories) {
    if (given.words == 0 || given.words > 1u << 24)
      throw NetworkError(fmt::format("memory {}: {} words; 1 to {} are possible", given.name, given.words, 1u << 24));
    if (given.dual_port && (given.places.size() != 2 || given.places[0].first == given.places[1].first))
      throw NetworkError(fmt::format("memory {}: a dual-port memory has two places, of two chips", given.name));
    if (given.dual_port && given.words < 2)
      throw NetworkError(
          fmt::format("memory {}: the two last words are mailboxes; 2 or more are expected", given.name));
    if (!given.dual_port && std::ranges::any_of(given.pins, [](const auto& pin) { return pin.has_value(); }))
      throw NetworkError(fmt::format("memory {}: only a dual-port memory pulls pins", given.name));
    if (given.waits < 0 || given.waits > 1000)
      throw NetworkError(fmt::format("memory {}: {} wait states; 0 to 1000 are possible", given.name, given.waits));
    for (const auto& [chip, base] : given.places) {
      if (chip >= nodes_.size())
        throw NetworkError(
            fmt::format("memory {}: there is no chip {}; the network has {}", given.name, chip, nodes_.size()));
      const auto& regions = nodes_[chip]->description.board.board.regions;
      const bool inside =
          std::any_of(regions.begin(), regions.end(), [&, node = chip, at = base](const c40::Region& r) {
            return r.kind == c40::Region::Kind::external_window && at >= r.base &&
                   !nodes_[node]->ignored.contains(at) && std::uint64_t{at} + given.words <= r.base + r.words;
          });
      if (!inside)
        throw NetworkError(
            fmt::format("memory {}: the board of chip {} has no window that holds {} words from {:08X}h; a region with "
                        "kind = \"window\" is expected there",
                        given.name, chip, given.words, base));
      if (memory_of(*nodes_[chip], base) != nullptr || memory_of(*nodes_[chip], base + given.words - 1) != nullptr)
        throw NetworkError(fmt::format("memory {}: chip {} has another memory at {:08X}h", given.name, chip, base));
    }
    auto& memory = *memories_.emplace_back(std::make_unique<Memory>());
    memory.description = given;
    memory.words.resize(given.words);
    for (const auto& place : given.places) nodes_[place.first]->shares_memory = true;
  }
}

void Network::perform_memory(Node& node) {
  Memory& memory = *memory_of(node, node.stop.access.address);
  const c40::ExternalAccess& access = node.stop.access;
  const std::size_t side = memory.side_of(node.number, access.address);
  const Address offset = access.address - memory.description.places[side].second;
  Word& word = memory.words[offset];
  const Word before = word;
  const Cycles cycle = node.first_cycle(now_);
  const Time ends = node.clock.at(cycle + 1 + memory.description.waits);
  const auto owner = memory.owner;
  if (memory.description.dual_port)
    memory.sides[side] = {offset, ends};
  else
    memory.free = ends;
  if (access.write && word != access.value) something_happened();
  if (access.interlocked && access.write)
    memory.owner.reset();
  else if (!memory.description.dual_port && access.interlocked && !is_sigi(node.chip.peek(node.chip.pc())))
    memory.owner = node.number;
  if (memory.owner != owner) something_happened();
  if (access.write) {
    word = access.value;
    node.chip.complete_write(cycle - access.cycle, memory.description.waits);
  } else {
    node.chip.complete_read(word, cycle - access.cycle, memory.description.waits);
  }
  if (memory.description.dual_port) tell_mailboxes(memory, side, offset, access.write);
  if (memory_listener_) memory_listener_(node.number, *memory_place(node.number, access.address), before, access, now_);
  if (access.channel >= 0) node.dma_answered = now_;
  node.status = ChipStatus::running;
  for (const auto& [chip, base] : memory.description.places) nodes_[chip]->changed();
}

std::size_t Network::Memory::side_of(std::size_t chip, Address address) const {
  const auto place = std::ranges::find_if(
      description.places, [&](const auto& p) { return p.first == chip && address - p.second < description.words; });
  return static_cast<std::size_t>(place - description.places.begin());
}

Time Network::Memory::free_for(std::size_t chip, Address address) const {
  if (!description.dual_port) return free;
  const std::size_t side = side_of(chip, address);
  const Side& other = sides[1 - side];
  const bool meet = other.word == address - description.places[side].second;
  return meet ? std::max(sides[side].until, other.until) : sides[side].until;
}

/// Side 0 writes the last word and side 1 reads it; the last but one is for the other direction.
void Network::tell_mailboxes(Memory& memory, std::size_t side, Address word, bool write) {
  const Address last = memory.description.words - 1;
  if (word != last && word != last - 1) return;
  const std::size_t reader = word == last ? 1 : 0;
  if (write == (side == reader)) return;
  if (Net* net = memory.mailbox_nets[reader]) net->script(write ? c40::Drive::low : c40::Drive::none, now_);
}

std::optional<Network::MemoryPlace> Network::memory_place(std::size_t chip, Address address) const {
  for (std::size_t n = 0; n < memories_.size(); ++n)
    for (const auto& [owner, base] : memories_[n]->description.places)
      if (owner == chip && address - base < memories_[n]->description.words) return MemoryPlace{n, address - base};
  return std::nullopt;
}

Network::Memory* Network::memory_of(const Node& node, Address address) const {
  for (const auto& memory : memories_)
    for (const auto& [chip, base] : memory->description.places)
      if (chip == node.number && address - base < memory->description.words) return memory.get();
  return nullptr;
}

}  // namespace machine
