#include "machine/board_vme.hpp"

namespace machine {
namespace {

/// Bits that a program cannot write: the read-only ones of vic068.h.
constexpr std::uint8_t read_only(std::size_t number) {
  switch (number) {
    case 0x13:
    case 0x14: return 0x03;  // number of the ICGS, ICMS interrupt
    case 0x15:
    case 0x16: return 0x07;  // number of the local, the error interrupt
    case 0x17: return 0xF0;  // ICGS in ICSR
    case 0x1D: return 0xFF;  // ICR5: the revision
    default: return 0;
  }
}

}  // namespace

c40::Word Vic068a::read(c40::Address number, c40::Cycles) { return static_cast<c40::Word>(held_[number]) << shift_; }

void Vic068a::write(c40::Address number, c40::Word value, c40::Cycles) {
  const std::uint8_t kept = read_only(number);
  held_[number] =
      static_cast<std::uint8_t>((held_[number] & kept) | ((value >> shift_) & static_cast<unsigned>(~kept)));
}

}  // namespace machine
